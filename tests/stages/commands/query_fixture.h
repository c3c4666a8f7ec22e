// SPDX-License-Identifier: BSD-3-Clause
// A small workspace that `query` is asked about.

#ifndef FREEGS_TESTS_STAGES_COMMANDS_QUERY_FIXTURE_H_
#define FREEGS_TESTS_STAGES_COMMANDS_QUERY_FIXTURE_H_

#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "pipeline/exit_code.h"
#include "semantics/queries/instance_features.h"
#include "splat/render/renderer.h"
#include "stages/commands/query_command.h"
#include "tests/stages/synthetic_workspace.h"
#include "tests/stages/word_features.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

class QueryFixture : public testing::Test {
 protected:
  QueryFixture() { workspace_.AddInstances(); }

  int Query(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), workspace_.path().string());
    output_.str("");
    messages_.str("");
    CommandContext context{output_, messages_, cancellation_, "freegs"};
    const Status status = RunQueryCommand(arguments, context);
    message_ = status.message();
    return pipeline::ExitCode(status.code());
  }

  nlohmann::json QueryJson(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const int code = Query(arguments);
    EXPECT_EQ(code, 0) << message_;
    return code == 0 ? nlohmann::json::parse(output_.str()) : nlohmann::json();
  }

  void AddFeatures() { WriteWordFeatures(FeatureFile()); }
  void Write(const semantics::InstanceFeatures& features) {
    ASSERT_TRUE(semantics::WriteInstanceFeatures(FeatureFile(), features).ok());
  }
  std::filesystem::path FeatureFile() const {
    return workspace_ / "bootstrap" / "instance_features.json";
  }

  // What the renderer says about a view at its own size.
  Image<int32_t> Labels(const View& view) {
    splat::RenderOptions white;
    white.background = {1, 1, 1};
    return splat::RenderLabels(workspace_.model,
                               view.camera,
                               view.cam_from_world,
                               white,
                               pool_,
                               workspace_.labels);
  }

  // A pixel of the view that shows the label.
  static std::pair<int, int> PixelOf(const Image<int32_t>& labels,
                                     int32_t label) {
    for (int y = 0; y < labels.height(); ++y) {
      for (int x = 0; x < labels.width(); ++x) {
        if (labels(x, y) == label) return {x, y};
      }
    }
    ADD_FAILURE() << "no pixel of " << label;
    return {0, 0};
  }

  std::string out() const { return (out_.path() / "sub").string(); }

  SyntheticWorkspace workspace_;
  TemporaryFolder out_;
  CancellationToken cancellation_;
  std::ostringstream output_;
  std::ostringstream messages_;
  std::string message_;
  ThreadPool pool_{2};
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_COMMANDS_QUERY_FIXTURE_H_
