// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/workspace.h"

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <sys/file.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "core/text.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

// JSON holds UTF-8 only, and a path may be of any bytes. Such a text becomes
// {"percent": "caf%E9"}, with the bytes beyond ASCII, and '%', as hex digits.
constexpr char kPercent[] = "percent";

nlohmann::json BytesToJson(const std::string& bytes) {
  if (ValidUtf8(bytes) == bytes) return bytes;
  return {{kPercent, PercentEncode(bytes, [](char c) {
             return static_cast<uint8_t>(c) < 0x80 && c != '%';
           })}};
}

StatusOr<std::string> ReadBytes(const nlohmann::json& value,
                                const std::string& where) {
  const nlohmann::json* escaped = FindField(value, kPercent);
  if (escaped == nullptr) return ReadText(&value, where);
  FREEGS_ASSIGN_OR_RETURN(const std::string text, ReadText(escaped, where));
  std::optional<std::string> bytes = PercentDecode(text);
  if (!bytes) return BadInputError(where + ": a '%' without two hex digits");
  return *std::move(bytes);
}

// Far more than any workspace.json needs.
constexpr uint64_t kMaxInfoBytes = uint64_t{1} << 28;

}  // namespace

fs::path WorkspaceInfoPath(const fs::path& workspace) {
  return workspace / "workspace.json";
}

fs::path ConfigPath(const fs::path& workspace) {
  return workspace / "config.ini";
}

fs::path LogPath(const fs::path& workspace) { return workspace / "log.txt"; }

fs::path FingerprintCachePath(const fs::path& workspace) {
  return workspace / ".fingerprints.json";
}

fs::path ProgressPath(const fs::path& workspace) {
  return workspace / "progress.json";
}

fs::path PreviewPath(const fs::path& workspace) {
  return workspace / "preview.jpg";
}

fs::path StageFolder(const fs::path& workspace, std::string_view stage) {
  return workspace / stage;
}

fs::path PartialFolder(const fs::path& workspace, std::string_view stage) {
  return workspace / (std::string(stage) + ".partial");
}

fs::path RetiredFolder(const fs::path& workspace, std::string_view stage) {
  return workspace / (std::string(stage) + ".old");
}

fs::path AbsolutePath(const fs::path& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  if (error) return path.lexically_normal();
  fs::path up_to_parents;  // Up to the last "..".
  fs::path rest;
  for (const fs::path& part : absolute) {
    rest /= part;
    if (part != "..") continue;
    up_to_parents /= rest;
    rest.clear();
  }
  if (up_to_parents.empty()) return absolute.lexically_normal();
  const fs::path resolved = fs::weakly_canonical(up_to_parents, error);
  if (error) return absolute.lexically_normal();
  // Appending an empty path would add a slash.
  return rest.empty() ? resolved : (resolved / rest).lexically_normal();
}

std::string DisplayPath(const fs::path& workspace, const fs::path& path) {
  std::error_code error;
  const fs::path base = fs::absolute(workspace, error).lexically_normal();
  const fs::path full = (base / path).lexically_normal();
  const fs::path relative = full.lexically_relative(base);
  if (relative.empty() || *relative.begin() == "..") return full.string();
  return relative.string();
}

fs::path PathInWorkspace(const fs::path& workspace, const std::string& path) {
  if (path.empty()) return {};
  std::error_code error;
  return (fs::absolute(workspace, error) / path).lexically_normal();
}

StatusOr<WorkspaceInfo> ReadWorkspaceInfo(const fs::path& workspace) {
  const fs::path path = WorkspaceInfoPath(workspace);
  std::error_code error;
  if (!fs::exists(path, error)) return WorkspaceInfo();
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxInfoBytes));
  const auto with_advice = [](const Status& fault) {
    return BadInputError(fault.message() +
                         "; delete the file and give the photo folder again");
  };
  const StatusOr<nlohmann::json> document = ParseJson(text, path.string());
  if (!document.ok()) return with_advice(document.status());
  const nlohmann::json& json = *document;
  WorkspaceInfo info;
  Status status;
  JsonObjectReader reader(json, path.string(), "", &status);
  const auto read = [&status](const nlohmann::json& value,
                              const std::string& where) {
    StatusOr<std::string> bytes = ReadBytes(value, where);
    if (bytes.ok()) return *std::move(bytes);
    if (status.ok()) status = bytes.status();
    return std::string();
  };
  if (const nlohmann::json* images = FindField(json, "images")) {
    info.images =
        PathInWorkspace(workspace, read(*images, reader.Where("images")));
  }
  if (reader.Has("settings")) {
    for (const auto& [name, value] : reader.Object("settings").items()) {
      info.settings[name] = read(value, reader.Where("settings." + name));
    }
  }
  if (!status.ok()) return with_advice(status);
  return info;
}

Status WriteWorkspaceInfo(const fs::path& workspace,
                          const WorkspaceInfo& info) {
  nlohmann::json json = nlohmann::json::object();
  json["images"] = BytesToJson(
      info.images.empty() ? "" : DisplayPath(workspace, info.images));
  json["settings"] = nlohmann::json::object();
  for (const auto& [name, value] : info.settings) {
    json["settings"][name] = BytesToJson(value);
  }
  return WriteFileAtomic(WorkspaceInfoPath(workspace), JsonText(json));
}

bool IsLocked(const fs::path& workspace) {
  const int descriptor =
      open((workspace / ".lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked =
      flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return locked;
}

StatusOr<WorkspaceLock> WorkspaceLock::Acquire(const fs::path& workspace) {
  const fs::path path = workspace / ".lock";
  // Children must not keep the lock alive after this process: O_CLOEXEC.
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return BadInputError(workspace.string() +
                         ": cannot write here: " + std::strerror(errno));
  }
  // Somebody who only looks at the workspace holds the lock for a moment.
  constexpr auto kPatience = std::chrono::seconds(1);
  constexpr auto kPause = std::chrono::milliseconds(20);
  const auto end = std::chrono::steady_clock::now() + kPatience;
  int failed = flock(descriptor, LOCK_EX | LOCK_NB);
  while (failed != 0 && errno == EWOULDBLOCK &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kPause);
    failed = flock(descriptor, LOCK_EX | LOCK_NB);
  }
  if (failed != 0) {
    const int reason = errno;
    close(descriptor);
    if (reason == EWOULDBLOCK) {
      return BadInputError(workspace.string() +
                           ": another freegs_pipeline is working in this "
                           "workspace; wait for it or stop it first");
    }
    return InternalError(path.string() +
                         ": cannot lock: " + std::strerror(reason));
  }
  return WorkspaceLock(descriptor);
}

WorkspaceLock::WorkspaceLock(WorkspaceLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

WorkspaceLock& WorkspaceLock::operator=(WorkspaceLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

WorkspaceLock::~WorkspaceLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace freegs::pipeline
