// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/gzip.h"

#include <algorithm>
#include <limits>
#include <vector>
#include <zlib.h>

namespace freegs {
namespace {

// 16 asks for gzip's header and checksum.
constexpr int kGzipWindow = 16 + MAX_WBITS;
constexpr size_t kBufferBytes = 1 << 16;

struct Unpacked {
  std::string content;
  bool complete = false;  // The file ended where its data ended.
};

// Stops when there are more than max_bytes or the data end.
StatusOr<Unpacked> Unpack(std::string_view bytes, uint64_t max_bytes) {
  if (bytes.size() > std::numeric_limits<uInt>::max()) {
    return BadInputError("the gzip data is too large");
  }
  z_stream stream = {};
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) {
    return InternalError("zlib cannot be initialised");
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  Unpacked unpacked;
  std::vector<char> buffer(kBufferBytes);
  int result = Z_OK;
  while (result == Z_OK && unpacked.content.size() <= max_bytes) {
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    result = inflate(&stream, Z_NO_FLUSH);
    unpacked.content.append(buffer.data(), buffer.size() - stream.avail_out);
  }
  unpacked.complete = result == Z_STREAM_END && stream.avail_in == 0;
  inflateEnd(&stream);
  return unpacked;
}

Status DamagedError() {
  return BadInputError("the gzip data is damaged or truncated");
}

}  // namespace

StatusOr<std::string> Gzip(std::string_view content) {
  z_stream stream = {};
  if (deflateInit2(&stream,
                   Z_DEFAULT_COMPRESSION,
                   Z_DEFLATED,
                   kGzipWindow,
                   /*memLevel=*/8,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    return InternalError("zlib cannot be initialised");
  }
  std::string packed;
  std::vector<char> buffer(kBufferBytes);
  int result = Z_OK;
  while (result == Z_OK) {
    // zlib counts in 32 bits, so a large content is handed over in portions.
    if (stream.avail_in == 0 && !content.empty()) {
      const size_t portion = std::min(content.size(), size_t{1} << 30);
      stream.next_in =
          reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
      stream.avail_in = static_cast<uInt>(portion);
      content.remove_prefix(portion);
    }
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    result = deflate(&stream, content.empty() ? Z_FINISH : Z_NO_FLUSH);
    packed.append(buffer.data(), buffer.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  if (result != Z_STREAM_END) return InternalError("zlib cannot pack the data");
  return packed;
}

bool IsGzip(std::string_view bytes) {
  return bytes.size() >= 2 && bytes.substr(0, 2) == "\x1f\x8b";
}

StatusOr<std::string> Gunzip(std::string_view bytes, uint64_t max_bytes) {
  FREEGS_ASSIGN_OR_RETURN(Unpacked unpacked, Unpack(bytes, max_bytes));
  if (unpacked.content.size() > max_bytes) {
    return BadInputError("the gzip data unpacks to more than " +
                         std::to_string(max_bytes) + " bytes");
  }
  if (!unpacked.complete) return DamagedError();
  return std::move(unpacked.content);
}

StatusOr<std::string> GunzipBeginning(std::string_view bytes,
                                      uint64_t num_bytes) {
  FREEGS_ASSIGN_OR_RETURN(Unpacked unpacked, Unpack(bytes, num_bytes));
  if (unpacked.content.size() < num_bytes && !unpacked.complete) {
    return DamagedError();
  }
  unpacked.content.resize(
      std::min<uint64_t>(unpacked.content.size(), num_bytes));
  return std::move(unpacked.content);
}

}  // namespace freegs
