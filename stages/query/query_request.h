// SPDX-License-Identifier: BSD-3-Clause
// The command line of `query`.

#ifndef FREEGS_STAGES_QUERY_QUERY_REQUEST_H_
#define FREEGS_STAGES_QUERY_QUERY_REQUEST_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "semantics/queries/text_query.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

// A point or a box in a view, in pixels of its image.
struct ViewPlace {
  std::string view;
  std::vector<double> numbers;  // X Y, or X0 Y0 X1 Y1.
};

struct QueryRequest {
  std::filesystem::path workspace;

  // The question; exactly one of the four is set.
  std::optional<std::string> text;
  std::optional<std::filesystem::path> example;
  std::optional<ViewPlace> click;
  std::optional<ViewPlace> box;

  // The picture of a question by example, H x W x 3, RGB, where it is not to be
  // read from a file; `example` is only its name then.
  ImageU8 example_pixels;

  // For clicks: levels of the hierarchy above the instance that was clicked, or
  // below it where negative. Nothing: the instance itself.
  std::optional<int> level;

  std::string out;      // Folder for masks and overlays; empty writes none.
  bool json = false;    // Whether the answer is printed as JSON.
  std::string cameras;  // See ViewSelection.
  bool no_align = false;
  int size = 0;            // Longest side in pixels of views; 0 is no bound.
  std::string model;       // CLIP model folder; see OpenModelOfFeatures.
  int max_hits = 1;        // 0 is no limit.
  double min_cosine = -1;  // Threshold for questions by example.
  semantics::TextQueryOptions text_options;
  int threads = 0;  // 0 takes one per available core.
};

CommandWords QueryWords();

// kInvalidArgument says what is wrong and how it should be, also for errors in
// the workspace's config.ini.
StatusOr<QueryRequest> ParseQueryRequest(
    const std::vector<std::string>& arguments);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_REQUEST_H_
