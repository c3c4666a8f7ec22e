// SPDX-License-Identifier: BSD-3-Clause
// What a file or folder holds, as one hash: the same content gives the same
// hash wherever and whenever it was written.

#ifndef FREEGS_PIPELINE_FINGERPRINT_H_
#define FREEGS_PIPELINE_FINGERPRINT_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "core/status.h"

namespace freegs::pipeline {

// The content of one input of a stage.
struct InputFingerprint {
  // 32 hex digits, or "missing", or "unreadable".
  std::string hash;
  int64_t files = 0;  // Number of files below a folder; 1 for a file.

  bool missing() const { return hash == "missing"; }
  bool operator==(const InputFingerprint&) const = default;
};

// Hashes files, remembering the hash of files that did not change since (by
// size, inode, times of modification and of status change). A file touched less
// than two seconds ago is not remembered: it could change again without its
// times changing.
class FingerprintCache {
 public:
  // Starts from what Save() wrote at `path`; a missing or malformed file is the
  // same as an empty one. Keys inside `workspace` are kept relative to it.
  FingerprintCache(std::filesystem::path workspace, std::filesystem::path path);

  // A file, or a folder: the names and contents of all files below it, in the
  // order of their names. Links to files count as the files; links to folders
  // are not followed and count with their target's name, so that loops end.
  // What cannot be read counts as "unreadable", what is neither a file nor a
  // folder as "special"; neither is opened. Never fails.
  InputFingerprint Hash(const std::filesystem::path& path);

  // Writes what was learnt, if anything was.
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
  std::map<std::string, Entry> entries_;
  bool changed_ = false;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_FINGERPRINT_H_
