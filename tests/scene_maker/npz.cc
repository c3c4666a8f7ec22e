// SPDX-License-Identifier: BSD-3-Clause
// NumPy's .npz: a zip archive (PKWARE APPNOTE 6.3) of .npy files (NEP 1).

#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include <Eigen/Core>

#include "tests/scene_maker/scene_files.h"

namespace freegs::scene_maker {
namespace {

void AppendLittleEndian(uint32_t value, int bytes, std::string* out) {
  for (int i = 0; i < bytes; ++i) {
    out->push_back(static_cast<char>(value >> (8 * i) & 255));
  }
}

// CRC-32 as of zip, reflected polynomial 0xedb88320.
uint32_t Crc32(const std::string& bytes) {
  std::array<uint32_t, 256> table{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) {
      c = (c & 1) != 0 ? 0xedb88320u ^ (c >> 1) : c >> 1;
    }
    table[i] = c;
  }
  uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc = table[(crc ^ static_cast<uint8_t>(byte)) & 255] ^ (crc >> 8);
  }
  return ~crc;
}

std::string EncodeNpyFloat16(const ImageF& values) {
  std::string header = "{'descr': '<f2', 'fortran_order': False, 'shape': (" +
                       std::to_string(values.height()) + ", " +
                       std::to_string(values.width()) + "), }";
  // Magic, version and length take 10 bytes; the data start at a multiple
  // of 64.
  header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 10 - 1, ' ');
  header += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  AppendLittleEndian(static_cast<uint32_t>(header.size()), 2, &out);
  out += header;
  for (size_t i = 0; i < values.size(); ++i) {
    AppendLittleEndian(
        Eigen::numext::bit_cast<uint16_t>(Eigen::half(values.data()[i])),
        2,
        &out);
  }
  return out;
}

}  // namespace

std::string EncodeNpzFloat16(const std::string& key, const ImageF& values) {
  const std::string name = key + ".npy";
  const std::string content = EncodeNpyFloat16(values);
  const uint32_t size = static_cast<uint32_t>(content.size());

  std::string common;  // Shared by the local and the central header.
  AppendLittleEndian(20, 2, &common);  // Version needed.
  AppendLittleEndian(0, 2, &common);   // Flags.
  AppendLittleEndian(0, 2, &common);   // Stored.
  AppendLittleEndian(0, 2, &common);   // Time.
  AppendLittleEndian(33, 2, &common);  // Date: 1980-01-01.
  AppendLittleEndian(Crc32(content), 4, &common);
  AppendLittleEndian(size, 4, &common);
  AppendLittleEndian(size, 4, &common);
  AppendLittleEndian(static_cast<uint32_t>(name.size()), 2, &common);
  AppendLittleEndian(0, 2, &common);  // Extra field.

  std::string out("PK\x03\x04", 4);
  out += common + name + content;
  const uint32_t directory = static_cast<uint32_t>(out.size());
  out += std::string("PK\x01\x02", 4);
  AppendLittleEndian(20, 2, &out);  // Made by.
  out += common;
  AppendLittleEndian(0, 2, &out);  // Comment.
  AppendLittleEndian(0, 2, &out);  // Disk.
  AppendLittleEndian(0, 2, &out);  // Internal attributes.
  AppendLittleEndian(0, 4, &out);  // External attributes.
  AppendLittleEndian(0, 4, &out);  // Offset of the local header.
  out += name;
  const uint32_t end = static_cast<uint32_t>(out.size());
  out += std::string("PK\x05\x06", 4);
  AppendLittleEndian(0, 2, &out);
  AppendLittleEndian(0, 2, &out);
  AppendLittleEndian(1, 2, &out);
  AppendLittleEndian(1, 2, &out);
  AppendLittleEndian(end - directory, 4, &out);
  AppendLittleEndian(directory, 4, &out);
  AppendLittleEndian(0, 2, &out);
  return out;
}

}  // namespace freegs::scene_maker
