// SPDX-License-Identifier: BSD-3-Clause
// Hashes the content of files and folders. The same content gives the same
// hash, wherever and whenever it was written.

#ifndef FREEGS_PIPELINE_FINGERPRINT_H_
#define FREEGS_PIPELINE_FINGERPRINT_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs::pipeline {

// The content of one input of a stage.
struct InputFingerprint {
  // 32 hex digits, "missing", "unreadable" or "special".
  std::string hash;
  int64_t files = 0;  // Number of files below a folder; 1 for a file.
  // Where an input lay that the user named, as DisplayPath writes it. Empty for
  // what other stages make, and in records of older programs.
  std::string path = {};
  // The way from the workspace to such an input, such as "../list.txt", where
  // `path` is absolute. Empty otherwise, and in records of older programs.
  std::string from_workspace = {};

  bool missing() const { return hash == "missing"; }
  // The same content counts as the same input, wherever it lies.
  bool operator==(const InputFingerprint& other) const {
    return hash == other.hash && files == other.files;
  }
};

// What file managers and photo editors leave beside photos, as a file or as a
// folder of this name. No stage reads it.
bool IsBystander(const std::string& name, bool folder);

// Hashes files and remembers the hashes of files that do not change:
//
//   FingerprintCache cache(workspace, FingerprintCachePath(workspace));
//   const InputFingerprint photos = cache.Hash("/home/me/photos");
//   FREEGS_RETURN_IF_ERROR(cache.Save());
//
// A file counts as unchanged while its size, inode, time of modification and
// time of status change are the same. A file whose status changed less than two
// seconds ago is not remembered, because it could change again without its
// times changing.
class FingerprintCache {
 public:
  // Starts with what Save() wrote at `path`. A missing or malformed file counts
  // as an empty one. Paths inside `workspace` are stored relative to it, so
  // that the workspace can be moved. `cancellation` may be null, and must
  // outlive the cache.
  FingerprintCache(std::filesystem::path workspace,
                   std::filesystem::path path,
                   const CancellationToken* cancellation = nullptr);

  // Hashes a file, or a folder with the names and contents of all files below
  // it, in the order of their names. Hidden files and folders, Thumbs.db,
  // desktop.ini and *.xmp are left out: file managers and photo editors write
  // them. A link to a file counts as the file. A link to a folder is not
  // followed, so that loops end, and counts with the name of its target. What
  // cannot be read counts as "unreadable", and what is neither a file nor a
  // folder as "special". This never fails. But once it is cancelled, files that
  // are not remembered count as "unreadable": ask the token before using it.
  InputFingerprint Hash(const std::filesystem::path& path);

  // Writes the hashes, if there are new ones.
  Status Save();

 private:
  struct Entry {
    int64_t size = 0;
    int64_t modified_ns = 0;
    int64_t changed_ns = 0;
    uint64_t inode = 0;
    std::string hash;
  };

  std::string HashOneFile(const std::filesystem::path& path);
  void HashFolder(const std::filesystem::path& folder,
                  const std::string& prefix,
                  std::string* listing,
                  int64_t* files);

  std::filesystem::path workspace_;
  std::filesystem::path path_;
  const CancellationToken* cancellation_;
  std::map<std::string, Entry> entries_;
  bool changed_ = false;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_FINGERPRINT_H_
