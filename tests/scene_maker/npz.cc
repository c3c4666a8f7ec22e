// SPDX-License-Identifier: BSD-3-Clause
// NumPy's .npz: a zip archive (PKWARE APPNOTE 6.3) of .npy files (NEP 1).

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include <Eigen/Core>

#include "core/io/byte_stream.h"
#include "tests/scene_maker/scene_files.h"

namespace freegs::scene_maker {
namespace {

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
  ByteWriter out;
  out.PutBytes({"\x93NUMPY\x01\x00", 8});
  out.Put(static_cast<uint16_t>(header.size()));
  out.PutBytes(header);
  for (size_t i = 0; i < values.size(); ++i) {
    out.Put(Eigen::numext::bit_cast<uint16_t>(Eigen::half(values.data()[i])));
  }
  return std::move(out).content();
}

}  // namespace

std::string EncodeNpzFloat16(const std::string& key, const ImageF& values) {
  const std::string name = key + ".npy";
  const std::string content = EncodeNpyFloat16(values);
  const uint32_t size = static_cast<uint32_t>(content.size());

  ByteWriter common;         // Shared by the local and the central header.
  common.Put<uint16_t>(20);  // Version needed.
  common.Put<uint16_t>(0);   // Flags.
  common.Put<uint16_t>(0);   // Stored.
  common.Put<uint16_t>(0);   // Time.
  common.Put<uint16_t>(33);  // Date: 1980-01-01.
  common.Put<uint32_t>(Crc32(content));
  common.Put<uint32_t>(size);
  common.Put<uint32_t>(size);
  common.Put(static_cast<uint16_t>(name.size()));
  common.Put<uint16_t>(0);  // Extra field.

  ByteWriter out;
  out.PutBytes("PK\x03\x04");
  out.PutBytes(common.content());
  out.PutBytes(name);
  out.PutBytes(content);
  const auto directory = static_cast<uint32_t>(out.content().size());
  out.PutBytes("PK\x01\x02");
  out.Put<uint16_t>(20);  // Made by.
  out.PutBytes(common.content());
  out.Put<uint16_t>(0);  // Comment.
  out.Put<uint16_t>(0);  // Disk.
  out.Put<uint16_t>(0);  // Internal attributes.
  out.Put<uint32_t>(0);  // External attributes.
  out.Put<uint32_t>(0);  // Offset of the local header.
  out.PutBytes(name);
  const auto end = static_cast<uint32_t>(out.content().size());
  out.PutBytes("PK\x05\x06");
  out.Put<uint16_t>(0);
  out.Put<uint16_t>(0);
  out.Put<uint16_t>(1);
  out.Put<uint16_t>(1);
  out.Put<uint32_t>(end - directory);
  out.Put<uint32_t>(directory);
  out.Put<uint16_t>(0);
  return std::move(out).content();
}

}  // namespace freegs::scene_maker
