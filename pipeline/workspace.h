// SPDX-License-Identifier: BSD-3-Clause
// The paths in a workspace, and the lock that allows one run at a time.

#ifndef FREEGS_PIPELINE_WORKSPACE_H_
#define FREEGS_PIPELINE_WORKSPACE_H_

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "core/status.h"

namespace freegs::pipeline {

// WORKSPACE/config.ini: the user's options.
std::filesystem::path ConfigPath(const std::filesystem::path& workspace);

// WORKSPACE/log.txt: every line that was logged.
std::filesystem::path LogPath(const std::filesystem::path& workspace);

// WORKSPACE/.fingerprints.json: the hashes of a FingerprintCache.
std::filesystem::path FingerprintCachePath(
    const std::filesystem::path& workspace);

// WORKSPACE/progress.json and WORKSPACE/preview.jpg: what a run under way is
// doing (pipeline/progress_file.h), and a picture of it.
std::filesystem::path ProgressPath(const std::filesystem::path& workspace);
std::filesystem::path PreviewPath(const std::filesystem::path& workspace);

// WORKSPACE/STAGE: a stage's finished output, and stage.json in it.
std::filesystem::path StageFolder(const std::filesystem::path& workspace,
                                  std::string_view stage);

// WORKSPACE/STAGE.partial: what a running or interrupted stage writes.
std::filesystem::path PartialFolder(const std::filesystem::path& workspace,
                                    std::string_view stage);

// WORKSPACE/STAGE.old: an output that is being replaced. It is deleted when the
// new one is in place.
std::filesystem::path RetiredFolder(const std::filesystem::path& workspace,
                                    std::string_view stage);

// The absolute path without "." and "..", which means the same place: ".."
// after a link leads to the folder above the one that the link leads to. Links
// that no ".." follows stay.
std::filesystem::path AbsolutePath(const std::filesystem::path& path);

// Returns the path relative to the workspace if it lies inside, and the
// absolute path otherwise.
std::string DisplayPath(const std::filesystem::path& workspace,
                        const std::filesystem::path& path);

// What a workspace remembers between runs, in WORKSPACE/workspace.json.
struct WorkspaceInfo {
  std::filesystem::path images;  // Absolute; empty if none was given yet.

  // The options on the command lines of earlier runs that still hold, by name.
  std::map<std::string, std::string> settings;
};

// The inverse of DisplayPath: a relative path starts at the workspace.
std::filesystem::path PathInWorkspace(const std::filesystem::path& workspace,
                                      const std::string& path);

// WORKSPACE/workspace.json.
std::filesystem::path WorkspaceInfoPath(const std::filesystem::path& workspace);

// Reads workspace.json. Returns an empty info if there is no such file and
// kBadInput if it is malformed. A photo folder inside the workspace is stored
// with its relative path, so that the workspace can be moved.
StatusOr<WorkspaceInfo> ReadWorkspaceInfo(
    const std::filesystem::path& workspace);
Status WriteWorkspaceInfo(const std::filesystem::path& workspace,
                          const WorkspaceInfo& info);

// Whether some process holds the lock of the workspace now.
bool IsLocked(const std::filesystem::path& workspace);

// Holds the lock of a workspace (flock on WORKSPACE/.lock) as long as it lives.
// The kernel releases the lock of a killed process, so nothing needs to be
// cleaned up.
class WorkspaceLock {
 public:
  // Returns kBadInput if another process holds the lock.
  static StatusOr<WorkspaceLock> Acquire(
      const std::filesystem::path& workspace);

  WorkspaceLock(WorkspaceLock&& other) noexcept;
  WorkspaceLock& operator=(WorkspaceLock&& other) noexcept;
  ~WorkspaceLock();

 private:
  explicit WorkspaceLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_WORKSPACE_H_
