// SPDX-License-Identifier: BSD-3-Clause
// The file of a semantic field in training.

#ifndef FREEGS_SEMANTICS_FIELD_FIELD_CHECKPOINT_H_
#define FREEGS_SEMANTICS_FIELD_FIELD_CHECKPOINT_H_

#include <filesystem>
#include <string>
#include <string_view>

#include "core/status.h"
#include "semantics/field/field_training.h"

namespace freegs::semantics {

// The file holds the complete state, so that training continues as if it had
// not stopped. Little-endian: "FREEGSFT", uint32 version, the parts of
// FieldState one after another, uint64 XXH3 of everything before.
StatusOr<std::string> SerializeFieldState(const FieldState& state);
Status WriteFieldState(const std::filesystem::path& path,
                       const FieldState& state);

// kBadInput, which names the file and the fault, for anything but a complete
// file of a known version with a matching checksum, whose parts fit each other.
StatusOr<FieldState> ParseFieldState(std::string_view content);
StatusOr<FieldState> ReadFieldState(const std::filesystem::path& path);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FIELD_CHECKPOINT_H_
