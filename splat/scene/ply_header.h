// SPDX-License-Identifier: BSD-3-Clause
// The header of a PLY file, and a reader of the values that follow it.

#ifndef FREEGS_SPLAT_SCENE_PLY_HEADER_H_
#define FREEGS_SPLAT_SCENE_PLY_HEADER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::splat {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

enum class PlyType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64
};
size_t PlyTypeSize(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // The type of a list's length.
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // The fewest bytes that one item can take in a file of this format. A file
  // that claims more items than fit is refused before memory is allocated.
  uint64_t MinItemBytes(PlyFormat format) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;

  // What was subtracted from all positions, as a line "comment offset X Y Z"
  // says.
  std::array<double, 3> offset = {0, 0, 0};

  // Whether there is a line "comment SplatRenderMode: mip".
  bool antialiased = false;

  std::vector<PlyElement> elements;
  size_t size = 0;  // Bytes of the header, including the end_header line.
};

// Parses the header at the beginning of a file's content. Fails with kBadInput
// when it is malformed.
StatusOr<PlyHeader> ParsePlyHeader(std::string_view content);

// Reads the values that follow a header, one after another.
class PlyValueReader {
 public:
  PlyValueReader(PlyFormat format, std::string_view body)
      : format_(format), rest_(body) {}

  uint64_t remaining_bytes() const { return rest_.size(); }

  // Reads the next value. Returns false at the end of the content, or when the
  // next word of an ascii file is no number.
  bool Read(PlyType type, double* value);

  // Steps over the value of a property, or over all values of a list. Returns
  // false like Read.
  bool Skip(const PlyProperty& property);

 private:
  bool ReadToken(double* value);

  PlyFormat format_;
  std::string_view rest_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_PLY_HEADER_H_
