// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/gunzip.h"

#include <algorithm>
#include <limits>
#include <vector>
#include <zlib.h>

namespace freegs::semantics {

bool IsGzip(std::string_view bytes) {
  return bytes.size() >= 2 && bytes.substr(0, 2) == "\x1f\x8b";
}

StatusOr<std::string> Gunzip(std::string_view bytes, uint64_t max_bytes) {
  if (bytes.size() > std::numeric_limits<uInt>::max()) {
    return BadInputError("the gzip data is too large");
  }
  z_stream stream = {};
  // 16 asks for gzip's header and checksum.
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) {
    return InternalError("zlib cannot be initialised");
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string content;
  std::vector<char> buffer(1 << 16);
  int result = Z_OK;
  while (result == Z_OK && content.size() <= max_bytes) {
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    result = inflate(&stream, Z_NO_FLUSH);
    content.append(buffer.data(), buffer.size() - stream.avail_out);
  }
  const bool all_read = stream.avail_in == 0;
  inflateEnd(&stream);
  if (content.size() > max_bytes) {
    return BadInputError("the gzip data unpacks to more than " +
                         std::to_string(max_bytes) + " bytes");
  }
  if (result != Z_STREAM_END || !all_read) {
    return BadInputError("the gzip data is damaged or truncated");
  }
  return content;
}

}  // namespace freegs::semantics
