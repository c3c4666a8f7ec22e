// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/progress_file.h"

#include <fstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "pipeline/workspace.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kInterval = 1;
constexpr double kMax = 1e15;

// Unlike WriteFileAtomic without waiting for the disk: the file is worth
// nothing after a power cut.
void Replace(const fs::path& path, const std::string& text) {
  const fs::path part = path.string() + ".part";
  std::error_code error;
  if (std::ofstream(part, std::ios::binary) << text << std::flush) {
    fs::rename(part, path, error);
  }
  if (error) fs::remove(part, error);
}

}  // namespace

void RemoveProgress(const fs::path& workspace) {
  std::error_code ignored;
  for (const fs::path& path :
       {ProgressPath(workspace), PreviewPath(workspace)}) {
    fs::remove(path, ignored);
    fs::remove(path.string() + ".part", ignored);
  }
}

ProgressFile::ProgressFile(fs::path workspace, std::string stage, Clock clock)
    : workspace_(std::move(workspace)),
      stage_(std::move(stage)),
      clock_(clock ? std::move(clock) : SteadySeconds) {
  Write({}, 0);
  last_written_ = clock_();
}

ProgressFile::~ProgressFile() { RemoveProgress(workspace_); }

void ProgressFile::Report(const Progress& progress) {
  const std::lock_guard lock(mutex_);
  const double now = clock_();
  const double rate = rate_.Update(now, progress);
  if (now - last_written_ < kInterval) return;
  last_written_ = now;
  Write(progress, rate);
}

void ProgressFile::Write(const Progress& progress, double rate) {
  nlohmann::json json = {{"stage", stage_},
                         {"step", progress.step},
                         {"done", progress.done},
                         {"total", progress.total},
                         {"seconds_left", nullptr}};
  if (rate > 0 && progress.total >= progress.done) {
    json["seconds_left"] = (progress.total - progress.done) / rate;
  }
  Replace(ProgressPath(workspace_), JsonText(json, -1));
}

StatusOr<RunProgress> ReadProgressFile(const fs::path& workspace) {
  const fs::path path = ProgressPath(workspace);
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json json, ReadJson(path));
  Status status;
  JsonObjectReader reader(json, path.string(), "", &status);
  RunProgress progress;
  progress.stage = reader.Text("stage");
  progress.step = reader.Text("step");
  progress.done = reader.Number("done", 0, kMax);
  progress.total = reader.Number("total", 0, kMax);
  if (!reader.IsNull("seconds_left")) {
    progress.seconds_left = reader.Number("seconds_left", 0, kMax);
  }
  FREEGS_RETURN_IF_ERROR(status);
  return progress;
}

}  // namespace freegs::pipeline
