// SPDX-License-Identifier: BSD-3-Clause

#include "photos/film_rotation.h"

#include <cstdint>
#include <fstream>
#include <string>

namespace freegs::photos {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxMoovBytes = uint64_t{256} << 20;
constexpr int kMaxBoxes = 10000;  // At the top of a file.

uint64_t BigEndian(std::string_view bytes) {
  uint64_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<uint8_t>(c);
  return value;
}

// Splits the first box off `data`. False at the end or if it is damaged.
bool NextBox(std::string_view* data,
             std::string_view* type,
             std::string_view* content) {
  if (data->size() < 8) return false;
  uint64_t size = BigEndian(data->substr(0, 4));
  uint64_t header = 8;
  if (size == 1) {
    if (data->size() < 16) return false;
    size = BigEndian(data->substr(8, 8));
    header = 16;
  }
  if (size == 0) size = data->size();
  if (size < header || size > data->size()) return false;
  *type = data->substr(4, 4);
  *content = data->substr(header, size - header);
  data->remove_prefix(size);
  return true;
}

// The content of the first box of a type; empty if there is none.
std::string_view FindBox(std::string_view data, std::string_view wanted) {
  std::string_view type;
  std::string_view content;
  while (NextBox(&data, &type, &content)) {
    if (type == wanted) return content;
  }
  return {};
}

bool IsVideo(std::string_view track) {
  const std::string_view handler = FindBox(FindBox(track, "mdia"), "hdlr");
  return handler.size() >= 12 && handler.substr(8, 4) == "vide";
}

int TrackRotation(std::string_view track) {
  const std::string_view header = FindBox(track, "tkhd");
  if (header.empty()) return 0;
  // Version 1 has three times of 64 bits instead of 32.
  const size_t matrix = header[0] == 1 ? 52 : 40;
  if (header.size() < matrix + 20) return 0;
  const auto entry = [&](size_t i) {
    return static_cast<int32_t>(BigEndian(header.substr(matrix + 4 * i, 4)));
  };
  // (x, y) goes to (a x + c y, b x + d y).
  const int32_t a = entry(0);
  const int32_t b = entry(1);
  const int32_t c = entry(3);
  const int32_t d = entry(4);
  if (a == 0 && d == 0 && b > 0 && c < 0) return 90;
  if (a == 0 && d == 0 && b < 0 && c > 0) return 270;
  if (b == 0 && c == 0 && a < 0 && d < 0) return 180;
  return 0;
}

}  // namespace

int MovieRotation(std::string_view moov) {
  std::string_view type;
  std::string_view content;
  while (NextBox(&moov, &type, &content)) {
    if (type == "trak" && IsVideo(content)) return TrackRotation(content);
  }
  return 0;
}

int FilmRotation(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const uint64_t file_size = fs::file_size(path, error);
  if (error) return 0;
  uint64_t at = 0;
  for (int box = 0; box < kMaxBoxes && at + 8 <= file_size; ++box) {
    char header[16] = {};
    file.clear();
    file.seekg(static_cast<std::streamoff>(at));
    file.read(header, sizeof(header));
    if (file.gcount() < 8) return 0;
    const std::string_view bytes(header, sizeof(header));
    uint64_t size = BigEndian(bytes.substr(0, 4));
    uint64_t start = 8;
    if (size == 1) {
      size = BigEndian(bytes.substr(8, 8));
      start = 16;
    }
    if (size == 0) size = file_size - at;
    if (size < start || size > file_size - at) return 0;
    if (bytes.substr(4, 4) == "moov") {
      if (size > kMaxMoovBytes) return 0;
      std::string moov(size - start, '\0');
      file.clear();
      file.seekg(static_cast<std::streamoff>(at + start));
      file.read(moov.data(), static_cast<std::streamsize>(moov.size()));
      if (static_cast<uint64_t>(file.gcount()) != moov.size()) return 0;
      return MovieRotation(moov);
    }
    at += size;
  }
  return 0;
}

}  // namespace freegs::photos
