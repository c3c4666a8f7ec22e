// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/fingerprint.h"

#include <algorithm>
#include <ctime>
#include <sys/stat.h>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "pipeline/workspace.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kNanosecond = 1'000'000'000;
constexpr int64_t kSettledAfter = 2 * kNanosecond;

int64_t Nanoseconds(const timespec& time) {
  return time.tv_sec * kNanosecond + time.tv_nsec;
}

int64_t NowNanoseconds() {
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  return Nanoseconds(now);
}

}  // namespace

bool IsBystander(const std::string& name, bool folder) {
  if (name.starts_with('.')) return true;
  return !folder && (name == "Thumbs.db" || name == "desktop.ini" ||
                     name.ends_with(".xmp") || name.ends_with(".XMP"));
}

FingerprintCache::FingerprintCache(fs::path workspace,
                                   fs::path path,
                                   const CancellationToken* cancellation)
    : workspace_(std::move(workspace)),
      path_(std::move(path)),
      cancellation_(cancellation) {
  const StatusOr<nlohmann::json> json = ReadJson(path_);
  if (!json.ok() || !json->is_object()) return;
  for (const auto& [key, value] : json->items()) {
    if (!value.is_array() || value.size() != 5 || !value[4].is_string()) {
      continue;
    }
    if (!std::all_of(value.begin(), value.begin() + 4, [](const auto& v) {
          return v.is_number_integer();
        })) {
      continue;
    }
    entries_[key] = {value[0].get<int64_t>(),
                     value[1].get<int64_t>(),
                     value[2].get<int64_t>(),
                     value[3].get<uint64_t>(),
                     value[4].get<std::string>()};
  }
}

InputFingerprint FingerprintCache::Hash(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return {"missing", 0};
  if (!fs::status_known(status)) return {"unreadable", 0};
  if (!fs::is_directory(status)) return {HashOneFile(path), 1};
  std::string listing;
  int64_t files = 0;
  HashFolder(path, "", &listing, &files);
  return {HashBytes(listing), files};
}

std::string FingerprintCache::HashOneFile(const fs::path& path) {
  struct stat info = {};
  if (stat(path.c_str(), &info) != 0) return "unreadable";
  if (!S_ISREG(info.st_mode)) return "special";
  Entry entry{info.st_size,
              Nanoseconds(info.st_mtim),
              Nanoseconds(info.st_ctim),
              info.st_ino,
              ""};
  const std::string key = ValidUtf8(DisplayPath(workspace_, path));
  const auto known = entries_.find(key);
  if (known != entries_.end() && known->second.size == entry.size &&
      known->second.modified_ns == entry.modified_ns &&
      known->second.changed_ns == entry.changed_ns &&
      known->second.inode == entry.inode) {
    return known->second.hash;
  }
  const int64_t now = NowNanoseconds();
  const StatusOr<std::string> hash = HashFile(path, cancellation_);
  if (!hash.ok()) return "unreadable";
  // Every change moves the time of status change. The time of modification can
  // be set to any value; cameras with a wrong clock set it to the future.
  if (now - entry.changed_ns >= kSettledAfter) {
    entry.hash = *hash;
    entries_[key] = entry;
    changed_ = true;
  }
  return *hash;
}

void FingerprintCache::HashFolder(const fs::path& folder,
                                  const std::string& prefix,
                                  std::string* listing,
                                  int64_t* files) {
  // Names and kinds are separated by bytes that no name contains, so that two
  // different folders never give the same listing.
  const auto add = [&](const std::string& name, const std::string& what) {
    *listing += prefix + name;
    *listing += '\0';
    *listing += what;
    *listing += '\0';
  };
  std::error_code error;
  fs::directory_iterator iterator(folder, error);
  if (error) {
    add(".", "unreadable");
    return;
  }
  std::vector<fs::path> paths;
  for (; !error && iterator != fs::directory_iterator();
       iterator.increment(error)) {
    paths.push_back(iterator->path());
  }
  if (error) add(".", "unreadable");
  std::sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) {
    return a.native() < b.native();
  });
  for (const fs::path& path : paths) {
    const std::string name = path.filename().string();
    const fs::file_status link = fs::symlink_status(path, error);
    if (IsBystander(name, fs::is_directory(link))) continue;
    if (fs::is_directory(link)) {
      add(name, "folder");
      HashFolder(path, prefix + name + "/", listing, files);
      continue;
    }
    if (fs::is_symlink(link)) {
      const fs::file_status target = fs::status(path, error);
      if (!fs::is_regular_file(target)) {
        add(name, "link " + fs::read_symlink(path, error).string());
        continue;
      }
    }
    ++*files;
    add(name, HashOneFile(path));
  }
}

Status FingerprintCache::Save() {
  if (!changed_) return Status();
  nlohmann::json json = nlohmann::json::object();
  for (const auto& [key, entry] : entries_) {
    json[key] = {entry.size,
                 entry.modified_ns,
                 entry.changed_ns,
                 entry.inode,
                 entry.hash};
  }
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path_, JsonText(json, -1)));
  changed_ = false;
  return Status();
}

}  // namespace freegs::pipeline
