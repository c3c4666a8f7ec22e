// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_names.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include "core/text.h"

namespace freegs::photos {
namespace {

// Bytes of one name between slashes; file systems take 255, and numbers and
// suffixes come on top.
constexpr size_t kMaxPartBytes = 200;

// Bytes of the UTF-8 character at `at`, or 0 if there is no valid one.
// Source: RFC 3629, section 4.
size_t CharacterBytes(std::string_view text, size_t at) {
  const auto byte = [text](size_t i) {
    return i < text.size() ? static_cast<uint8_t>(text[i]) : 0;
  };
  const auto tail = [&byte](size_t i, int low = 0x80, int high = 0xbf) {
    return byte(i) >= low && byte(i) <= high;
  };
  const int lead = byte(at);
  if (lead < 0x80) return 1;
  if (lead >= 0xc2 && lead <= 0xdf) return tail(at + 1) ? 2 : 0;
  if (lead >= 0xe0 && lead <= 0xef) {
    const int low = lead == 0xe0 ? 0xa0 : 0x80;
    const int high = lead == 0xed ? 0x9f : 0xbf;
    return tail(at + 1, low, high) && tail(at + 2) ? 3 : 0;
  }
  if (lead >= 0xf0 && lead <= 0xf4) {
    const int low = lead == 0xf0 ? 0x90 : 0x80;
    const int high = lead == 0xf4 ? 0x8f : 0xbf;
    return tail(at + 1, low, high) && tail(at + 2) && tail(at + 3) ? 4 : 0;
  }
  return 0;
}

// One name between slashes, made safe for COLMAP's text files and cut to
// max_bytes.
std::string SafePart(std::string_view part, size_t max_bytes) {
  std::string safe;
  for (size_t at = 0; at < part.size();) {
    const size_t bytes = CharacterBytes(part, at);
    if (safe.size() + std::max<size_t>(bytes, 1) > max_bytes) break;
    const auto c = static_cast<uint8_t>(part[at]);
    if (bytes == 0 || c <= ' ' || c == 0x7f || c == '\\' ||
        (c == '#' && at == 0)) {
      safe += '_';
    } else {
      safe += part.substr(at, bytes);
    }
    at += std::max<size_t>(bytes, 1);
  }
  return safe;
}

std::string Extension(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

// The suffix of the photo in the workspace.
std::string SafeExtension(const Photo& photo) {
  if (photo.converted) return ".png";
  const std::string extension = Extension(photo.file);
  const std::string lower = AsciiLower(extension);
  if (photo.format == "PNG") return lower == ".png" ? extension : ".png";
  const bool jpeg = lower == ".jpg" || lower == ".jpeg" || lower == ".jpe";
  return jpeg ? extension : ".jpg";
}

std::string SafeName(const Photo& photo) {
  const std::string& file = photo.file;
  std::string safe;
  size_t at = 0;
  for (size_t end = file.find('/'); end != std::string::npos;
       end = file.find('/', at)) {
    safe +=
        SafePart(std::string_view(file).substr(at, end - at), kMaxPartBytes);
    safe += '/';
    at = end + 1;
  }
  std::string_view stem = std::string_view(file).substr(at);
  stem.remove_suffix(Extension(file).size());
  return safe + SafePart(stem, kMaxPartBytes) + SafeExtension(photo);
}

// Names in use. A name that is a folder to another one is in use, too. Names
// that differ only in large and small letters are one: they are on disks as
// cameras and Windows have them, where a workspace may lie.
class Names {
 public:
  bool Take(const std::string& wish) {
    const std::string name = AsciiLower(wish);
    if (taken_.contains(name) || folders_.contains(name)) return false;
    std::set<std::string> folders;
    for (size_t at = name.find('/'); at != std::string::npos;
         at = name.find('/', at + 1)) {
      const std::string folder = name.substr(0, at);
      if (taken_.contains(folder)) return false;
      folders.insert(folder);
    }
    folders_.merge(folders);
    taken_.insert(name);
    return true;
  }

  // The length of the first folder of a name that is a file already, or else
  // that of the whole name.
  size_t BlockedPart(const std::string& wish) const {
    const std::string name = AsciiLower(wish);
    for (size_t at = name.find('/'); at != std::string::npos;
         at = name.find('/', at + 1)) {
      if (taken_.contains(name.substr(0, at))) return at;
    }
    return name.size();
  }

 private:
  std::set<std::string> taken_;
  std::set<std::string> folders_;
};

// "a/b.jpg" -> "a/b_2.jpg".
std::string Numbered(const std::string& name, int number) {
  std::filesystem::path path(name);
  const std::string leaf = path.stem().string() + "_" + std::to_string(number) +
                           path.extension().string();
  return path.replace_filename(leaf).string();
}

// The wish, or the first free variant of it. A folder gets the number if it is
// what cannot be had: no name of a photo in it is free.
std::string TakeFree(const std::string& wish, Names* names) {
  std::string name = wish;
  const size_t part = names->BlockedPart(wish);
  for (int number = 2; !names->Take(name); ++number) {
    name = Numbered(wish.substr(0, part), number) + wish.substr(part);
  }
  return name;
}

}  // namespace

void AssignNames(std::vector<Photo>* photos) {
  Names names;
  // Those that can keep their names go first, so that nobody takes them.
  for (Photo& photo : *photos) {
    photo.name.clear();
    if (photo.usable() && SafeName(photo) == photo.file) {
      photo.name = TakeFree(photo.file, &names);
    }
  }
  for (Photo& photo : *photos) {
    if (!photo.usable() || !photo.name.empty()) continue;
    photo.name = TakeFree(SafeName(photo), &names);
  }
}

}  // namespace freegs::photos
