// SPDX-License-Identifier: BSD-3-Clause
// The words of `query`, understood.

#ifndef FREEGS_STAGES_QUERY_QUERY_REQUEST_H_
#define FREEGS_STAGES_QUERY_QUERY_REQUEST_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/queries/text_query.h"

namespace freegs::stages {

// A place in a view, in pixels of its image.
struct ViewPlace {
  std::string view;
  std::vector<double> numbers;  // X Y, or X0 Y0 X1 Y1.
};

struct QueryRequest {
  std::filesystem::path workspace;

  // Exactly one is given.
  std::optional<std::string> text;
  std::optional<std::filesystem::path> example;
  std::optional<ViewPlace> click;
  std::optional<ViewPlace> box;

  std::string out;
  bool json = false;
  std::string cameras;
  bool no_align = false;
  int size = 0;
  std::string model;
  int max_hits = 1;
  double min_cosine = -1;
  semantics::TextQueryOptions text_options;
  int threads = 0;
};

// kInvalidArgument says what is wrong and how it should be; errors of the
// workspace's config.ini likewise.
StatusOr<QueryRequest> ParseQueryRequest(
    const std::vector<std::string>& arguments);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_REQUEST_H_
