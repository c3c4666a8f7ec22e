// SPDX-License-Identifier: BSD-3-Clause
// Where things lie in a workspace, and the lock that keeps two runs apart.

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

// WORKSPACE/.fingerprints.json: hashes of files that did not change since.
std::filesystem::path FingerprintCachePath(
    const std::filesystem::path& workspace);

// WORKSPACE/STAGE: a stage's finished output, and stage.json in it.
std::filesystem::path StageFolder(const std::filesystem::path& workspace,
                                  std::string_view stage);

// WORKSPACE/STAGE.partial: what a running or interrupted stage writes.
std::filesystem::path PartialFolder(const std::filesystem::path& workspace,
                                    std::string_view stage);

// WORKSPACE/STAGE.old: an output being replaced; deleted after the swap.
std::filesystem::path RetiredFolder(const std::filesystem::path& workspace,
                                    std::string_view stage);

// The path relative to the workspace if it lies inside, else as it is.
std::string DisplayPath(const std::filesystem::path& workspace,
                        const std::filesystem::path& path);

// WORKSPACE/workspace.json: what a workspace remembers between runs.
struct WorkspaceInfo {
  std::filesystem::path images;  // Absolute; empty if none was given yet.

  // Option name -> value of the last run's command line.
  std::map<std::string, std::string> settings;
};

// The path as it is inside the workspace: a relative one is taken from there.
std::filesystem::path PathInWorkspace(const std::filesystem::path& workspace,
                                      const std::string& path);

// An empty info if there is no file; kBadInput if it is malformed. Photos
// inside the workspace are stored relative to it, so that it can be moved.
StatusOr<WorkspaceInfo> ReadWorkspaceInfo(
    const std::filesystem::path& workspace);
Status WriteWorkspaceInfo(const std::filesystem::path& workspace,
                          const WorkspaceInfo& info);

// Whether a run holds the workspace now. Changes nothing.
bool IsLocked(const std::filesystem::path& workspace);

// Holds the workspace (flock on WORKSPACE/.lock) until destroyed. The kernel
// releases the lock of a killed process, so nothing needs to be cleaned up.
class WorkspaceLock {
 public:
  // kBadInput if another process holds it.
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
