// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_scan.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <dirent.h>
#include <memory>
#include <set>
#include <sys/stat.h>
#include <utility>

#include "core/io/files.h"
#include "core/text.h"

namespace freegs::photos {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kImageExtensions[] = {
    // Formats we read.
    "jpg",
    "jpeg",
    "jpe",
    "jfif",
    "png",
    "tif",
    "tiff",
    "mpo",
    // Formats that are worth a word when we meet them.
    "heic",
    "heif",
    "hif",
    "avif",
    "webp",
    "gif",
    "bmp",
    "jxl",
    "jp2",
    "exr",
    "hdr",
    "tga",
    "ppm",
    "pgm",
    "psd",
    "dng",
    "crw",
    "cr2",
    "cr3",
    "nef",
    "nrw",
    "arw",
    "orf",
    "raf",
    "rw2",
    "pef",
    "srw",
    "3fr",
    "iiq",
    "x3f",
    "gpr",
    "rwl"};

constexpr std::string_view kFilmExtensions[] = {"mp4",
                                                "m4v",
                                                "mov",
                                                "qt",
                                                "ts",
                                                "avi",
                                                "mkv",
                                                "webm",
                                                "mpg",
                                                "mpeg",
                                                "wmv",
                                                "flv",
                                                "ogv",
                                                "3gp",
                                                "mts",
                                                "m2ts"};

// The name's extension in small letters, without the dot.
std::string LowerExtension(const fs::path& path) {
  std::string extension = LowerSuffix(path);
  if (!extension.empty()) extension.erase(0, 1);
  return extension;
}

template <size_t N>
bool IsOneOf(const std::string& text, const std::string_view (&list)[N]) {
  return std::find(std::begin(list), std::end(list), text) != std::end(list);
}

// A folder is known by its device and number, whatever its names.
using FolderId = std::pair<dev_t, ino_t>;

// True for names that end like an image of any kind, those that we read and
// those that we do not: files that their owner may take for photos.
bool HasImageExtension(const fs::path& path) {
  return IsOneOf(LowerExtension(path), kImageExtensions);
}

class Scanner {
 public:
  Scanner(fs::path root, PhotoScan* scan)
      : root_(std::move(root)), scan_(scan) {}

  void Exclude(const fs::path& folder) {
    struct stat info = {};
    if (stat(folder.c_str(), &info) == 0) {
      visited_.insert({info.st_dev, info.st_ino});
    }
  }

  // Folders by their own names first, links to folders last.
  void Run() {
    pending_.push_back("");
    while (!pending_.empty() || !links_.empty()) {
      const bool link = pending_.empty();
      std::deque<std::string>& queue = link ? links_ : pending_;
      const std::string folder = std::move(queue.front());
      queue.pop_front();
      if (Visit(folder) && link) scan_->linked_folders.push_back(folder);
    }
  }

 private:
  // False if the folder has been visited before or cannot be read.
  bool Visit(const std::string& folder) {
    const fs::path path = root_ / folder;
    struct stat info = {};
    if (stat(path.c_str(), &info) != 0) return Warn(folder);
    if (!visited_.insert({info.st_dev, info.st_ino}).second) return false;
    const std::unique_ptr<DIR, int (*)(DIR*)> stream(opendir(path.c_str()),
                                                     &closedir);
    if (stream == nullptr) return Warn(folder);
    std::vector<std::string> names;
    errno = 0;
    while (const dirent* entry = readdir(stream.get())) {
      if (entry->d_name[0] != '.') names.emplace_back(entry->d_name);
    }
    if (errno != 0) Warn(folder);
    std::sort(names.begin(), names.end(), NaturalLess);
    for (const std::string& name : names) {
      Add(folder.empty() ? name : folder + "/" + name);
    }
    return true;
  }

  void Add(const std::string& file) {
    const fs::path path = root_ / file;
    struct stat link = {};
    struct stat target = {};
    if (lstat(path.c_str(), &link) != 0) {
      Warn(file);
      return;
    }
    const bool followed = stat(path.c_str(), &target) == 0;
    if (followed && S_ISDIR(target.st_mode)) {
      (S_ISLNK(link.st_mode) ? links_ : pending_).push_back(file);
    } else if (HasImageExtension(path)) {
      scan_->files.push_back(file);
    } else if (HasFilmExtension(path)) {
      scan_->films.push_back(file);
    }
  }

  // Notes what errno says; false.
  bool Warn(const std::string& name) {
    const int code = errno;
    scan_->warnings.push_back(
        (name.empty() ? "." : name) + ": cannot be looked into: " +
        std::strerror(code) + "; make it readable if it holds photos");
    return false;
  }

  fs::path root_;
  PhotoScan* scan_;
  std::set<FolderId> visited_;
  std::deque<std::string> pending_;
  std::deque<std::string> links_;
};

}  // namespace

bool HasFilmExtension(const fs::path& path) {
  return IsOneOf(LowerExtension(path), kFilmExtensions);
}

StatusOr<PhotoScan> ScanPhotos(const fs::path& folder,
                               const std::vector<fs::path>& excluded) {
  struct stat info = {};
  if (stat(folder.c_str(), &info) != 0) {
    return BadInputError(folder.string() + ": cannot read the photo folder: " +
                         std::strerror(errno) + "; check its name");
  }
  if (!S_ISDIR(info.st_mode)) {
    return BadInputError(folder.string() +
                         ": not a folder; name the folder that holds the "
                         "photos");
  }
  const std::unique_ptr<DIR, int (*)(DIR*)> stream(opendir(folder.c_str()),
                                                   &closedir);
  if (stream == nullptr) {
    return BadInputError(folder.string() + ": cannot read the photo folder: " +
                         std::strerror(errno) + "; make it readable");
  }
  PhotoScan scan;
  Scanner scanner(folder, &scan);
  for (const fs::path& path : excluded) scanner.Exclude(path);
  scanner.Run();
  std::sort(scan.files.begin(), scan.files.end(), NaturalLess);
  std::sort(scan.films.begin(), scan.films.end(), NaturalLess);
  return scan;
}

}  // namespace freegs::photos
