// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/byte_stream.h"

#include <xxhash.h>

namespace freegs {

void ByteWriter::PutChecksum() {
  Put<uint64_t>(XXH3_64bits(content_.data(), content_.size()));
}

bool HasChecksum(std::string_view content) {
  if (content.size() < kChecksumBytes) return false;
  const std::string_view body = WithoutChecksum(content);
  uint64_t expected = 0;
  ByteReader(content.substr(body.size())).Get(&expected);
  return XXH3_64bits(body.data(), body.size()) == expected;
}

}  // namespace freegs
