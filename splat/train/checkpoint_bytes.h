// SPDX-License-Identifier: BSD-3-Clause
// The bytes of a checkpoint: little-endian numbers, texts, arrays and models,
// one after another.

#ifndef FREEGS_SPLAT_TRAIN_CHECKPOINT_BYTES_H_
#define FREEGS_SPLAT_TRAIN_CHECKPOINT_BYTES_H_

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to little-endian files as they are");

class CheckpointWriter {
 public:
  template <typename T>
  void Put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    content_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  void PutText(std::string_view text) {
    Put<uint64_t>(text.size());
    content_.append(text);
  }
  template <typename T>
  void PutArray(const std::vector<T>& array) {
    content_.append(reinterpret_cast<const char*>(array.data()),
                    array.size() * sizeof(T));
  }
  void PutModel(const GaussianModel& model) {
    Put<uint64_t>(model.size());
    Put<int32_t>(model.sh_degree);
    for (const Parameter parameter : kAllParameters) {
      PutArray(ParameterArray(model, parameter));
    }
  }
  void PutBytes(std::string_view bytes) { content_.append(bytes); }
  std::string& content() { return content_; }

 private:
  std::string content_;
};

// Every Get returns false, and leaves the target as it is, when fewer bytes are
// left; nothing is allocated before that is known.
class CheckpointReader {
 public:
  explicit CheckpointReader(std::string_view bytes) : rest_(bytes) {}

  bool at_end() const { return rest_.empty(); }

  template <typename T>
  bool Get(T* value) {
    static_assert(std::is_arithmetic_v<T>);
    if (rest_.size() < sizeof(T)) return false;
    std::memcpy(value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return true;
  }
  bool GetText(std::string* text) {
    uint64_t size = 0;
    if (!Get(&size) || size > rest_.size()) return false;
    *text = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return true;
  }
  template <typename T>
  bool GetArray(uint64_t count, std::vector<T>* array) {
    if (count > rest_.size() / sizeof(T)) return false;
    array->resize(count);
    if (count > 0) std::memcpy(array->data(), rest_.data(), count * sizeof(T));
    rest_.remove_prefix(count * sizeof(T));
    return true;
  }
  bool GetModel(GaussianModel* model) {
    uint64_t count = 0;
    int32_t degree = 0;
    if (!Get(&count) || !Get(&degree)) return false;
    if (degree < 0 || degree > kMaxShDegree) return false;
    if (count > rest_.size()) return false;  // So that products do not wrap.
    model->sh_degree = degree;
    return std::all_of(
        kAllParameters.begin(), kAllParameters.end(), [&](Parameter p) {
          const auto stride = static_cast<uint64_t>(ParameterStride(*model, p));
          return GetArray(count * stride, &ParameterArray(*model, p));
        });
  }

 private:
  std::string_view rest_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_CHECKPOINT_BYTES_H_
