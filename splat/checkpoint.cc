// SPDX-License-Identifier: BSD-3-Clause

#include "splat/checkpoint.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <functional>
#include <system_error>
#include <type_traits>
#include <utility>

#include "core/files.h"

namespace freegs::splat {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to little-endian files as they are");

constexpr std::string_view kMagic = "FGSTRAIN";
constexpr uint32_t kVersion = 2;  // 2: max_dominant_share.
constexpr size_t kHashBytes = 32;

constexpr std::string_view kPrefix = "iteration_";
constexpr std::string_view kSuffix = ".ckpt";
constexpr std::string_view kPartSuffix = ".ckpt.part";

class Writer {
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
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

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

bool Fits(const GaussianModel& moments, const GaussianModel& model) {
  return moments.empty() || (moments.size() == model.size() &&
                             moments.sh_degree == model.sh_degree);
}

bool ReadPayload(Reader* reader, TrainingCheckpoint* checkpoint) {
  DensificationStatistics& statistics = checkpoint->statistics;
  uint64_t num_statistics = 0;
  uint64_t num_facts = 0;
  if (!reader->Get(&checkpoint->iteration) ||
      !reader->Get(&checkpoint->elapsed_seconds) ||
      !reader->GetModel(&checkpoint->model) ||
      !reader->Get(&checkpoint->adam.steps) ||
      !reader->GetModel(&checkpoint->adam.first_moments) ||
      !reader->GetModel(&checkpoint->adam.second_moments) ||
      !reader->Get(&num_statistics) ||
      !reader->GetArray(num_statistics, &statistics.gradient_sum) ||
      !reader->GetArray(num_statistics, &statistics.visible_steps) ||
      !reader->GetArray(num_statistics, &statistics.max_radius) ||
      !reader->GetArray(num_statistics, &statistics.max_dominant_share) ||
      !reader->Get(&num_facts)) {
    return false;
  }
  for (uint64_t i = 0; i < num_facts; ++i) {
    std::string name;
    std::string value;
    if (!reader->GetText(&name) || !reader->GetText(&value)) return false;
    checkpoint->facts[name] = value;
  }
  return reader->at_end() && checkpoint->iteration >= 0 &&
         Fits(checkpoint->adam.first_moments, checkpoint->model) &&
         Fits(checkpoint->adam.second_moments, checkpoint->model) &&
         (num_statistics == 0 || num_statistics == checkpoint->model.size());
}

// Checkpoint files of a folder, the newest first.
std::vector<std::pair<int64_t, fs::path>> ListCheckpoints(
    const fs::path& folder) {
  std::vector<std::pair<int64_t, fs::path>> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) continue;
    const char* const first = name.data() + kPrefix.size();
    const char* const last = name.data() + name.size() - kSuffix.size();
    int64_t iteration = 0;
    const auto [stop, failure] = std::from_chars(first, last, iteration);
    if (failure != std::errc() || stop != last) continue;
    found.emplace_back(iteration, it->path());
  }
  std::sort(found.begin(), found.end(), std::greater<>());
  return found;
}

// What a killed writer left behind.
void RemoveParts(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> parts;
  for (fs::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.starts_with(kPrefix) && name.ends_with(kPartSuffix)) {
      parts.push_back(it->path());
    }
  }
  for (const fs::path& part : parts) fs::remove(part, error);
}

}  // namespace

std::string SerializeCheckpoint(const TrainingCheckpoint& checkpoint) {
  Writer writer;
  writer.PutBytes(kMagic);
  writer.Put(kVersion);
  writer.Put(checkpoint.iteration);
  writer.Put(checkpoint.elapsed_seconds);
  writer.PutModel(checkpoint.model);
  writer.Put(checkpoint.adam.steps);
  writer.PutModel(checkpoint.adam.first_moments);
  writer.PutModel(checkpoint.adam.second_moments);
  writer.Put<uint64_t>(checkpoint.statistics.size());
  writer.PutArray(checkpoint.statistics.gradient_sum);
  writer.PutArray(checkpoint.statistics.visible_steps);
  writer.PutArray(checkpoint.statistics.max_radius);
  writer.PutArray(checkpoint.statistics.max_dominant_share);
  writer.Put<uint64_t>(checkpoint.facts.size());
  for (const auto& [name, value] : checkpoint.facts) {
    writer.PutText(name);
    writer.PutText(value);
  }
  writer.PutBytes(HashBytes(writer.content()));
  return std::move(writer.content());
}

StatusOr<TrainingCheckpoint> ParseCheckpoint(std::string_view content) {
  if (!content.starts_with(kMagic)) {
    return BadInputError("not a training checkpoint");
  }
  if (content.size() < kMagic.size() + sizeof(kVersion) + kHashBytes) {
    return BadInputError("training checkpoint is cut short");
  }
  const std::string_view body = content.substr(0, content.size() - kHashBytes);
  if (HashBytes(body) != content.substr(body.size())) {
    return BadInputError(
        "training checkpoint is damaged (its checksum does not match)");
  }
  Reader reader(body.substr(kMagic.size()));
  uint32_t version = 0;
  if (!reader.Get(&version) || version != kVersion) {
    return BadInputError("training checkpoint is of format " +
                         std::to_string(version) + ", this program reads " +
                         std::to_string(kVersion) +
                         ": go on with the program that wrote it, or start "
                         "training afresh");
  }
  TrainingCheckpoint checkpoint;
  if (!ReadPayload(&reader, &checkpoint)) {
    return BadInputError("training checkpoint is malformed");
  }
  return checkpoint;
}

Status SaveCheckpoint(const fs::path& folder,
                      const TrainingCheckpoint& checkpoint,
                      int keep) {
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
  char name[64];
  std::snprintf(name,
                sizeof(name),
                "iteration_%08lld.ckpt",
                static_cast<long long>(checkpoint.iteration));
  FREEGS_RETURN_IF_ERROR(
      WriteFileAtomic(folder / name, SerializeCheckpoint(checkpoint)));
  RemoveParts(folder);
  const auto found = ListCheckpoints(folder);
  for (size_t i = static_cast<size_t>(std::max(1, keep)); i < found.size();
       ++i) {
    // A file that stays costs disk only.
    std::error_code ignored;
    fs::remove(found[i].second, ignored);
  }
  return Status();
}

StatusOr<TrainingCheckpoint> LoadCheckpoint(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(path));
  StatusOr<TrainingCheckpoint> checkpoint = ParseCheckpoint(content);
  if (!checkpoint.ok()) return checkpoint.status().Annotated(path.string());
  return checkpoint;
}

std::optional<TrainingCheckpoint> LatestCheckpoint(
    const fs::path& folder, std::vector<std::string>* problems) {
  for (const auto& [iteration, path] : ListCheckpoints(folder)) {
    StatusOr<TrainingCheckpoint> checkpoint = LoadCheckpoint(path);
    if (checkpoint.ok()) return std::move(checkpoint).value();
    if (problems != nullptr) {
      problems->push_back(checkpoint.status().message());
    }
  }
  return std::nullopt;
}

}  // namespace freegs::splat
