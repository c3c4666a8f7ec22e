// SPDX-License-Identifier: BSD-3-Clause
// The file of a feature decoder.

#ifndef FREEGS_SEMANTICS_LOSSES_DECODER_FILE_H_
#define FREEGS_SEMANTICS_LOSSES_DECODER_FILE_H_

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/status.h"
#include "semantics/losses/array_adam.h"
#include "semantics/losses/feature_decoder.h"

namespace freegs::semantics {

// A decoder, and the state of its Adam if its training is to go on.
struct StoredDecoder {
  FeatureDecoder decoder;
  std::optional<ArrayAdamState> adam;
};

// The file, little-endian:
//   8 bytes   "FREEGSDC"
//   uint32    version, 1
//   uint32    kind: 0 linear, 1 MLP
//   uint32    D, H (0 for linear), C
//   uint32    1 when the state of Adam follows, else 0
//   float32   linear: basis C x D, mean C;
//             MLP: parameters (see PartsOf), running means H, variances H
//   int64     Adam: steps, then
//   float32   its first and its second moments, of the size of the parameters
//   uint64    XXH3 of everything before
// kInvalidArgument when the arrays' sizes disagree or values are not finite,
// and for a linear decoder with a state of Adam.
Status WriteDecoder(const std::filesystem::path& path,
                    const StoredDecoder& stored);
StatusOr<std::string> SerializeDecoder(const StoredDecoder& stored);

// kBadInput, which names the file and the fault, for anything but a complete
// file of a known version with a matching checksum and valid values.
StatusOr<StoredDecoder> ReadDecoder(const std::filesystem::path& path);
StatusOr<StoredDecoder> ParseDecoder(std::string_view content);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_DECODER_FILE_H_
