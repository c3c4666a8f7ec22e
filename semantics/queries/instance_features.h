// SPDX-License-Identifier: BSD-3-Clause
// The vectors of the instances in CLIP's space, with which queries are
// compared: the mean features of proposals in FreeGS ("Testing").

#ifndef FREEGS_SEMANTICS_QUERIES_INSTANCE_FEATURES_H_
#define FREEGS_SEMANTICS_QUERIES_INSTANCE_FEATURES_H_

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

struct InstanceFeatures {
  int dim = 0;             // D of the CLIP model.
  std::string model;       // Its folder, or its name where that is enough.
  std::string model_hash;  // ClipEncoder::model_hash() of it.

  // Instances x dim, row-major; row i belongs to instance id i + 1. A row has
  // length 1, or is zero if nothing is known of the instance.
  std::vector<float> features;

  // The number of instances.
  size_t size() const {
    return dim > 0 ? features.size() / static_cast<size_t>(dim) : 0;
  }
  std::span<const float> row(size_t i) const {
    return std::span(features).subspan(i * static_cast<size_t>(dim),
                                       static_cast<size_t>(dim));
  }
  // False if row i is zero.
  bool known(size_t i) const;
};

// {"model": "...", "model_hash": "...", "dim": 512,
//  "features": [[0.1, ...], ...]}    one list per instance, in order of the ids
// Values come back as the same bits. kInvalidArgument for sizes that disagree
// and for rows that are not finite or of another length than 0 and 1.
Status WriteInstanceFeatures(const std::filesystem::path& path,
                             const InstanceFeatures& features);
StatusOr<std::string> SerializeInstanceFeatures(
    const InstanceFeatures& features);

// kBadInput, which names the file and the fault, for malformed JSON, missing
// members, rows of another size than dim, and everything that writing refuses.
// Unknown members are ignored.
StatusOr<InstanceFeatures> ReadInstanceFeatures(
    const std::filesystem::path& path);
StatusOr<InstanceFeatures> ParseInstanceFeatures(std::string_view text);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_INSTANCE_FEATURES_H_
