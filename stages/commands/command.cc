// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/command.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "core/io/files.h"
#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "sfm/import/import_model.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"

namespace freegs::stages {

namespace fs = std::filesystem;

void WarnOfRun(const std::filesystem::path& workspace,
               CommandContext& context) {
  if (!pipeline::IsLocked(workspace)) return;
  context.err << "warning: a run is working in " << workspace.string()
              << "; stages that it has not come to yet are older than those "
                 "before them, and may not fit to them\n";
}

namespace {

// Whether a file at `place` would come among what the user has named for a
// stage to read. A workspace may lie in a folder of masks; places in the
// workspace are free even so.
bool IsAmong(const fs::path& place,
             const fs::path& named,
             const fs::path& workspace) {
  return IsWithin(place, named) &&
         !(IsWithin(workspace, named) && IsWithin(place, workspace));
}

// Whether a place is among the files of `named`, which sfm.import names. Stage
// sfm reads only a few files of a folder, which often holds the whole scene, so
// other places below it are free. Those where a COLMAP model is looked for are
// not: a model that is exported there would replace or hide what is imported.
bool IsAmongImport(const fs::path& place, const fs::path& named) {
  std::vector<fs::path> kept = sfm::ModelFolders(named);
  if (const auto source = sfm::FindImportSource(named); source.ok()) {
    const std::vector<fs::path> files = source->Files();
    kept.insert(kept.end(), files.begin(), files.end());
    kept.push_back(source->colmap_model);
  }
  return std::ranges::any_of(kept, [&](const fs::path& path) {
    return IsWithin(place, path) && IsWithin(path, place);
  });
}

// kInvalidArgument for a place in what the user has named for a stage to read,
// such as masks of photos or a COLMAP model.
Status CheckInputs(const fs::path& workspace,
                   const pipeline::WorkspaceInfo& info,
                   const fs::path& place) {
  PipelineOptions options;
  const pipeline::OptionTable table = MakeOptionTable(&options);
  std::vector<pipeline::OptionSetting> settings =
      RememberedSettings(workspace, info, table);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<pipeline::OptionSetting> config,
                          ConfigSettings(workspace, table));
  settings.insert(settings.end(), config.begin(), config.end());
  for (const pipeline::OptionSetting& setting : settings) {
    if (!table.Find(setting.name)->spec.is_path) continue;
    const bool among = setting.name == "sfm.import"
                           ? IsAmongImport(place, setting.value)
                           : IsAmong(place, setting.value, workspace);
    if (!among) continue;
    return InvalidArgumentError(
        place.string() + ": the stages read what is here (" + setting.name +
        " = " + setting.value + "); give another place");
  }
  return Status();
}

}  // namespace

Status CheckOutputPlace(const fs::path& workspace, const fs::path& place) {
  if (place.empty()) return Status();
  if (const std::string stage = StageThatHolds(workspace, place);
      !stage.empty()) {
    return InvalidArgumentError(
        place.string() + ": lies in the folder of stage " + stage +
        ", whose files must stay as the stage made them; give another place");
  }
  if (const auto info = pipeline::ReadWorkspaceInfo(workspace); info.ok()) {
    if (!info->images.empty() && IsWithin(place, info->images)) {
      return InvalidArgumentError(
          place.string() + ": lies in " + info->images.string() +
          ", which holds the photos of the scene; give another place");
    }
    FREEGS_RETURN_IF_ERROR(CheckInputs(workspace, *info, place));
  }
  return CheckOutputPlace(place);
}

Status CheckOutputPlace(const fs::path& place) {
  if (place.empty()) return Status();
  std::error_code error;
  const fs::path absolute =
      fs::weakly_canonical(pipeline::AbsolutePath(place), error);
  const fs::path folder = absolute.parent_path();
  for (const fs::path& own : {pipeline::WorkspaceInfoPath(folder),
                              pipeline::ConfigPath(folder),
                              pipeline::LogPath(folder)}) {
    if (absolute == own && fs::exists(own, error)) {
      return InvalidArgumentError(place.string() +
                                  ": belongs to a workspace itself; give "
                                  "another place");
    }
  }
  for (fs::path above = absolute; above.has_relative_path();
       above = above.parent_path()) {
    if (!fs::exists(pipeline::RecordPath(above), error)) continue;
    return InvalidArgumentError(
        place.string() + ": lies in " + above.string() +
        ", which a stage made, and must stay as the stage made it; give "
        "another place");
  }
  return Status();
}

}  // namespace freegs::stages
