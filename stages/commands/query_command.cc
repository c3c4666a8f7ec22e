// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/query_command.h"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "core/parallel.h"
#include "pipeline/logger.h"
#include "pipeline/progress_line.h"
#include "pipeline/system_info.h"
#include "stages/query/lap.h"
#include "stages/query/query_answer.h"
#include "stages/query/query_engine.h"
#include "stages/query/query_masks.h"
#include "stages/query/query_request.h"
#include "stages/query/query_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

Status WriteMasks(const QueryRequest& request,
                  const QueryScene& scene,
                  CommandContext& context,
                  ThreadPool& pool,
                  QueryAnswer* answer) {
  Lap lap;
  QueryMasksTask task{.scene = *scene.scene,
                      .labels = scene.labels,
                      .views = scene.views,
                      .ids = {},
                      .photos = {},
                      .out = request.out};
  for (const ScoredInstance& hit : answer->hits) task.ids.push_back(hit.id);
  if (request.cameras.empty()) {
    task.photos = request.workspace / "undistort" / "images";
  }
  RemoveEarlierAnswer(request.out);
  pipeline::Logger logger(context.err, pipeline::IsTerminal(context.err), {});
  pipeline::ProgressLine progress(&logger, "query");
  FREEGS_ASSIGN_OR_RETURN(
      answer->masks,
      WriteQueryMasks(
          task,
          context.cancellation,
          [&](size_t done) {
            progress.Report({"masks",
                             static_cast<double>(done),
                             static_cast<double>(scene.views.size()),
                             ""});
          },
          pool));
  answer->masks_ms = lap.Milliseconds();
  return Status();
}

}  // namespace

Status RunQueryCommand(const std::vector<std::string>& arguments,
                       CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const QueryRequest request,
                          ParseQueryRequest(arguments));
  if (!request.out.empty()) {
    const fs::path out = request.out;
    for (const fs::path& place : {out, out / "masks", out / "overlay"}) {
      FREEGS_RETURN_IF_ERROR(CheckOutputPlace(request.workspace, place));
    }
  }
  WarnOfRun(request.workspace, context);
  if (!request.out.empty()) {
    FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.out));
  }
  ThreadPool pool(pipeline::WorkingThreads(request.threads));
  Lap lap;
  QueryScene scene;
  std::ostringstream messages;
  const Status loaded = LoadQueryScene(request, messages, &scene);
  context.err << messages.str();
  FREEGS_RETURN_IF_ERROR(loaded);
  const double load_ms = lap.Milliseconds();
  if (context.cancellation.cancelled()) {
    return InterruptedError("query: stopped");
  }
  QueryNetworks networks;
  FREEGS_ASSIGN_OR_RETURN(QueryAnswer answer,
                          FindAnswer(request, pool, &scene, &networks));
  answer.load_ms = load_ms;
  context.err << answer.note;
  answer.note = messages.str() + answer.note;
  if (!request.out.empty()) {
    FREEGS_RETURN_IF_ERROR(WriteMasks(request, scene, context, pool, &answer));
    FREEGS_RETURN_IF_ERROR(
        WriteFileAtomic(fs::path(request.out) / "query.json",
                        JsonText(ToJson(answer, scene.instances))));
  }
  if (request.json) {
    context.out << JsonText(ToJson(answer, scene.instances));
  } else {
    PrintAnswer(answer, scene.instances, context.out);
  }
  return Status();
}

}  // namespace freegs::stages
