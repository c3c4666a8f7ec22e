// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/stage_output.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "pipeline/workspace.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

fs::path FingerprintPath(const fs::path& partial) {
  return partial / "partial.json";
}

fs::path UsagePath(const fs::path& partial) { return partial / "usage.json"; }

Status RemoveFile(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) {
    return InternalError(path.string() + ": cannot delete: " + error.message());
  }
  return Status();
}

Status Rename(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) {
    return InternalError(from.string() + ": cannot rename to " + to.string() +
                         ": " + error.message());
  }
  return Status();
}

// Puts everything written so far on disk, so that after a power cut the record
// is not there before what it vouches for. Fails where the disk did not take
// it. File systems that cannot be told to do so are left as they are.
Status FlushFileSystem(const fs::path& folder) {
  const int descriptor =
      open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return Status();
  const int reason = syncfs(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  if (reason != EIO && reason != ENOSPC && reason != EDQUOT) return Status();
  return InternalError(folder.string() +
                       ": cannot write: " + std::strerror(reason));
}

bool IsFinished(const fs::path& folder) {
  const StatusOr<StageRecord> record = ReadStageRecord(folder);
  return record.ok() && record->outcome == StageOutcome::kDone;
}

// Whether there is something of this name, be it a link that leads nowhere.
bool IsTaken(const fs::path& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error));
}

// Deletes a folder. The files that make it count as a result go first, so that
// what a killed deletion leaves counts as nothing. Of a link to a folder only
// the link is deleted: its target may be the result of another workspace.
Status RemoveStageFolder(const fs::path& folder) {
  std::error_code error;
  if (!IsTaken(folder)) return Status();
  if (fs::is_symlink(fs::symlink_status(folder, error))) {
    return RemoveFile(folder);
  }
  FREEGS_RETURN_IF_ERROR(RemoveFile(RecordPath(folder)));
  FREEGS_RETURN_IF_ERROR(RemoveFile(FingerprintPath(folder)));
  fs::remove_all(folder, error);
  if (error) {
    return InternalError(folder.string() +
                         ": cannot delete: " + error.message());
  }
  return Status();
}

// Steps 2 to 4.
Status Swap(const fs::path& workspace, const std::string& stage) {
  const fs::path folder = StageFolder(workspace, stage);
  const fs::path partial = PartialFolder(workspace, stage);
  const fs::path retired = RetiredFolder(workspace, stage);
  // Only the runner reads these. The suffix is that of an unfinished write.
  FREEGS_RETURN_IF_ERROR(RemoveFile(FingerprintPath(partial)));
  FREEGS_RETURN_IF_ERROR(RemoveFile(UsagePath(partial)));
  FREEGS_RETURN_IF_ERROR(RemoveFile(UsagePath(partial).string() + ".part"));
  if (IsTaken(folder)) {
    const Status removed = RemoveStageFolder(retired);
    if (!removed.ok()) {
      return InternalError(removed.message() +
                           "; delete it yourself and run again, the new result "
                           "is complete and then takes its place");
    }
    FREEGS_RETURN_IF_ERROR(Rename(folder, retired));
  }
  FREEGS_RETURN_IF_ERROR(Rename(partial, folder));
  FREEGS_RETURN_IF_ERROR(FlushToDisk(workspace));
  // What cannot be deleted now is deleted later; the new result is in place.
  (void)RemoveStageFolder(retired);
  return Status();
}

}  // namespace

Status BeginPartial(const fs::path& partial,
                    const StageFingerprint& fingerprint) {
  FREEGS_RETURN_IF_ERROR(RemoveStageFolder(partial));
  FREEGS_RETURN_IF_ERROR(CreateFolders(partial));
  // Checkpoints in it are worth nothing if a power cut takes the folder away.
  FREEGS_RETURN_IF_ERROR(FlushToDisk(partial.parent_path()));
  return WriteFileAtomic(FingerprintPath(partial),
                         JsonText(ToJson(fingerprint)));
}

Status ContinuePartial(const fs::path& partial) {
  return RemoveFile(RecordPath(partial));
}

StatusOr<StageFingerprint> ReadPartialFingerprint(const fs::path& partial) {
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json json,
                          ReadJson(FingerprintPath(partial)));
  return FingerprintFromJson(json);
}

ResourceUsage ReadPartialUsage(const fs::path& partial) {
  ResourceUsage usage;
  const StatusOr<nlohmann::json> json = ReadJson(UsagePath(partial));
  if (!json.ok()) return usage;
  const auto number = [&json](const char* key) {
    const auto value = ReadNumber(FindField(*json, key), 0, 1e18, key);
    return value.ok() ? *value : 0.0;
  };
  usage.wall_seconds = number("wall_seconds");
  usage.cpu_seconds = number("cpu_seconds");
  usage.peak_memory_bytes = std::llround(number("peak_memory_bytes"));
  return usage;
}

Status WritePartialUsage(const fs::path& partial, const ResourceUsage& usage) {
  const nlohmann::json json = {{"wall_seconds", usage.wall_seconds},
                               {"cpu_seconds", usage.cpu_seconds},
                               {"peak_memory_bytes", usage.peak_memory_bytes}};
  return WriteFileAtomic(UsagePath(partial), JsonText(json));
}

std::vector<std::string> StageContents(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const fs::path& path = it->path();
    const std::string name = path.filename().string();
    const bool own = path == RecordPath(folder) ||
                     path == FingerprintPath(folder) ||
                     path == UsagePath(folder);
    if (!own && !name.starts_with('.') && path.extension() != ".part") {
      names.push_back(ValidUtf8(name));
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

Status FinishPartial(const fs::path& workspace,
                     const std::string& stage,
                     const StageRecord& record) {
  const fs::path partial = PartialFolder(workspace, stage);
  FREEGS_RETURN_IF_ERROR(FlushFileSystem(partial));
  FREEGS_RETURN_IF_ERROR(WriteStageRecord(partial, record));
  return Swap(workspace, stage);
}

Status RecoverStage(const fs::path& workspace, const std::string& stage) {
  const fs::path folder = StageFolder(workspace, stage);
  const fs::path partial = PartialFolder(workspace, stage);
  const fs::path retired = RetiredFolder(workspace, stage);
  if (IsFinished(partial)) return Swap(workspace, stage);
  if (!IsTaken(retired)) return Status();
  // The new result takes its place before the old one is deleted. If there is
  // none, somebody took it away: the old one is better than nothing.
  if (!IsTaken(folder) && IsFinished(retired)) {
    return Rename(retired, folder);
  }
  // It is in nobody's way before the stage runs again.
  (void)RemoveStageFolder(retired);
  return Status();
}

}  // namespace freegs::pipeline
