// SPDX-License-Identifier: BSD-3-Clause
// Packing, for tests of what unpacks.

#ifndef FREEGS_TESTS_SEMANTICS_CLIP_GZIP_H_
#define FREEGS_TESTS_SEMANTICS_CLIP_GZIP_H_

#include <string>
#include <zlib.h>

namespace freegs::semantics {

inline std::string Gzip(std::string text) {
  z_stream stream = {};
  deflateInit2(&stream,
               Z_DEFAULT_COMPRESSION,
               Z_DEFLATED,
               16 + MAX_WBITS,
               8,
               Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(text.data());
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CLIP_GZIP_H_
