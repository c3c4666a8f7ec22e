// SPDX-License-Identifier: BSD-3-Clause

#include "stages/registry/stage_registry.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "core/io/files.h"
#include "pipeline/workspace.h"
#include "stages/bootstrap/bootstrap_stage.h"
#include "stages/export/export_stage.h"
#include "stages/ingest/ingest_stage.h"
#include "stages/reconstruct/reconstruct_stage.h"
#include "stages/sfm/sfm_stage.h"
#include "stages/sfm/undistort_stage.h"

namespace freegs::stages {

std::vector<pipeline::RunnerStage> MakeStages(
    const PipelineOptions& options, const pipeline::OptionTable& table) {
  std::vector<pipeline::RunnerStage> stages;
  const auto add = [&](std::unique_ptr<pipeline::Stage> stage, bool seeded) {
    pipeline::RunnerStage entry;
    const std::string section(stage->name());
    entry.options = table.Values(section, /*results_only=*/true);
    for (const auto& [name, value] :
         table.Values(section, /*results_only=*/false)) {
      if (!entry.options.contains(name)) entry.other_options[name] = value;
    }
    if (seeded) {
      entry.options["general.seed"] = std::to_string(options.general.seed);
    }
    entry.stage = std::move(stage);
    stages.push_back(std::move(entry));
  };
  const auto seed = static_cast<uint64_t>(options.general.seed);
  add(MakeIngestStage(options.ingest), /*seeded=*/false);
  add(MakeSfmStage(options.sfm, seed), /*seeded=*/true);
  add(MakeUndistortStage(options.undistort, options.sfm.colmap.colmap),
      /*seeded=*/false);
  add(MakeReconstructStage(options.reconstruct, seed), /*seeded=*/true);
  add(MakeBootstrapStage(options.bootstrap, seed), /*seeded=*/true);
  add(MakeExportStage(options.export_), /*seeded=*/false);
  return stages;
}

std::vector<std::string> StageNames() {
  PipelineOptions options;
  const pipeline::OptionTable table = MakeOptionTable(&options);
  std::vector<std::string> names;
  for (const pipeline::RunnerStage& entry : MakeStages(options, table)) {
    names.emplace_back(entry.stage->name());
  }
  return names;
}

std::string StageThatHolds(const std::filesystem::path& workspace,
                           const std::filesystem::path& path) {
  for (const std::string& stage : StageNames()) {
    if (IsWithin(path, pipeline::StageFolder(workspace, stage)) ||
        IsWithin(path, pipeline::PartialFolder(workspace, stage))) {
      return stage;
    }
  }
  return "";
}

Status CheckPhotosPlace(const std::filesystem::path& workspace,
                        const std::filesystem::path& images) {
  const std::string stage = StageThatHolds(workspace, images);
  if (stage.empty()) return Status();
  return InvalidArgumentError(
      images.string() + ": lies in the folder of stage " + stage +
      " of this workspace, which a run writes; give the folder of the photos");
}

}  // namespace freegs::stages
