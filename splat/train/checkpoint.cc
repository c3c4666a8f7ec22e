// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/checkpoint.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <system_error>
#include <utility>

#include "core/io/byte_stream.h"
#include "core/io/files.h"

namespace freegs::splat {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "FGSTRAIN";
constexpr uint32_t kVersion = 8;  // 8: the good state has colours.
constexpr size_t kHashBytes = 32;

// Room for 2e9 Gaussians, twice the largest budget that can be asked for, at
// 1200 bytes each: with two moments, the last good state and the mean. A file
// takes no more memory than it has bytes, whatever its counts say.
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 42;

constexpr std::string_view kPrefix = "iteration_";
constexpr std::string_view kSuffix = ".ckpt";
constexpr std::string_view kPartSuffix = ".ckpt.part";

bool Fits(const GaussianModel& moments, const GaussianModel& model) {
  return moments.empty() || (moments.size() == model.size() &&
                             moments.sh_degree == model.sh_degree);
}

void PutModel(const GaussianModel& model, PieceWriter* writer) {
  writer->Put<uint64_t>(model.size());
  writer->Put<int32_t>(model.sh_degree);
  for (const Parameter parameter : kAllParameters) {
    writer->PutArray(ParameterArray(model, parameter));
  }
}

bool GetModel(ByteReader* reader, GaussianModel* model) {
  uint64_t count = 0;
  int32_t degree = 0;
  // So small a count that the products below do not overflow.
  if (!reader->GetCount(1, &count) || !reader->Get(&degree) || degree < 0 ||
      degree > kMaxShDegree) {
    return false;
  }
  model->sh_degree = degree;
  return std::all_of(
      kAllParameters.begin(), kAllParameters.end(), [&](Parameter p) {
        const auto stride = static_cast<uint64_t>(ParameterStride(*model, p));
        return reader->GetArray(count * stride, &ParameterArray(*model, p));
      });
}

// Records are read one by one, so a wrong count takes no more memory than the
// file has content.
bool ReadMilestones(ByteReader* reader,
                    std::vector<MilestoneRecord>* milestones) {
  uint64_t count = 0;
  if (!reader->Get(&count)) return false;
  for (uint64_t i = 0; i < count; ++i) {
    MilestoneRecord record;
    uint8_t event = 0;
    if (!reader->Get(&record.iteration) || !reader->Get(&event) ||
        !reader->Get(&record.gaussians_before) ||
        !reader->Get(&record.gaussians_after) || event >= kNumTrainingEvents) {
      return false;
    }
    record.event = static_cast<TrainingEvent>(event);
    milestones->push_back(record);
  }
  return true;
}

bool ReadRecoveries(ByteReader* reader, std::vector<Recovery>* recoveries) {
  uint64_t count = 0;
  if (!reader->Get(&count)) return false;
  for (uint64_t i = 0; i < count; ++i) {
    Recovery recovery;
    if (!reader->Get(&recovery.iteration) ||
        !reader->GetText(&recovery.reason) || !reader->Get(&recovery.back_to) ||
        !reader->Get(&recovery.rate_factor)) {
      return false;
    }
    recoveries->push_back(recovery);
  }
  return true;
}

bool ReadExposureChoice(ByteReader* reader,
                        std::optional<ExposureChoice>* choice) {
  uint8_t present = 0;
  if (!reader->Get(&present) || present > 1) return false;
  if (present == 0) return true;
  ExposureChoice& read = choice->emplace();
  uint8_t learn = 0;
  if (!reader->Get(&learn) || learn > 1) return false;
  read.learn = learn == 1;
  for (TrialPsnr* psnr : {&read.without, &read.with}) {
    if (!reader->Get(&psnr->trained) || !reader->Get(&psnr->held_out)) {
      return false;
    }
  }
  return true;
}

void WriteExposureChoice(const std::optional<ExposureChoice>& choice,
                         PieceWriter* writer) {
  writer->Put<uint8_t>(choice ? 1 : 0);
  if (!choice) return;
  writer->Put<uint8_t>(choice->learn ? 1 : 0);
  for (const TrialPsnr* psnr : {&choice->without, &choice->with}) {
    writer->Put(psnr->trained);
    writer->Put(psnr->held_out);
  }
}

bool ReadColors(ByteReader* reader, PhotoColors* colors) {
  uint64_t count = 0;
  if (!reader->Get(&count)) return false;
  for (uint64_t i = 0; i < count; ++i) {
    PhotoColors::Entry entry;
    for (std::array<float, 12>* values :
         {&entry.color.values, &entry.first_moment, &entry.second_moment}) {
      for (float& value : *values) {
        if (!reader->Get(&value) || !std::isfinite(value)) return false;
      }
    }
    if (!reader->Get(&entry.steps) || entry.steps < 0) return false;
    colors->entries.push_back(entry);
  }
  return true;
}

void WriteColors(const PhotoColors& colors, PieceWriter* writer) {
  writer->Put<uint64_t>(colors.entries.size());
  for (const PhotoColors::Entry& entry : colors.entries) {
    for (const std::array<float, 12>* values :
         {&entry.color.values, &entry.first_moment, &entry.second_moment}) {
      for (const float value : *values) writer->Put(value);
    }
    writer->Put(entry.steps);
  }
}

bool ReadHistory(ByteReader* reader, TrainingHistory* history) {
  uint8_t has_last_good = 0;
  if (!ReadMilestones(reader, &history->milestones) ||
      !ReadRecoveries(reader, &history->recoveries) ||
      !reader->Get(&history->rate_factor) ||
      !reader->Get(&history->loss.steps) || !reader->Get(&history->loss.sum) ||
      !reader->Get(&history->loss.best) ||
      !ReadExposureChoice(reader, &history->exposure_choice) ||
      !ReadColors(reader, &history->colors) || !reader->Get(&has_last_good)) {
    return false;
  }
  if (!(history->rate_factor > 0 && history->rate_factor <= 1) ||
      history->loss.steps < 0 || !std::isfinite(history->loss.sum) ||
      !std::isfinite(history->loss.best) || has_last_good > 1) {
    return false;
  }
  if (has_last_good == 1) {
    GoodState& good = history->last_good.emplace();
    if (!reader->Get(&good.iteration) || !GetModel(reader, &good.model) ||
        !ReadColors(reader, &good.colors)) {
      return false;
    }
  }
  ModelAverage& average = history->average;
  return reader->Get(&average.count) && average.count >= 0 &&
         GetModel(reader, &average.mean) &&
         (average.count > 0 || average.mean.empty());
}

void WriteHistory(const TrainingHistory& history, PieceWriter* writer) {
  writer->Put<uint64_t>(history.milestones.size());
  for (const MilestoneRecord& record : history.milestones) {
    writer->Put(record.iteration);
    writer->Put(static_cast<uint8_t>(record.event));
    writer->Put(record.gaussians_before);
    writer->Put(record.gaussians_after);
  }
  writer->Put<uint64_t>(history.recoveries.size());
  for (const Recovery& recovery : history.recoveries) {
    writer->Put(recovery.iteration);
    writer->PutText(recovery.reason);
    writer->Put(recovery.back_to);
    writer->Put(recovery.rate_factor);
  }
  writer->Put(history.rate_factor);
  writer->Put(history.loss.steps);
  writer->Put(history.loss.sum);
  writer->Put(history.loss.best);
  WriteExposureChoice(history.exposure_choice, writer);
  WriteColors(history.colors, writer);
  writer->Put<uint8_t>(history.last_good ? 1 : 0);
  if (history.last_good) {
    writer->Put(history.last_good->iteration);
    PutModel(history.last_good->model, writer);
    WriteColors(history.last_good->colors, writer);
  }
  writer->Put(history.average.count);
  PutModel(history.average.mean, writer);
}

// The last good state must not be ahead of the checkpoint.
bool LiesBehind(const TrainingCheckpoint& checkpoint) {
  const std::optional<GoodState>& good = checkpoint.history.last_good;
  return !good ||
         (good->iteration >= 0 && good->iteration <= checkpoint.iteration);
}

bool ReadPayload(ByteReader* reader, TrainingCheckpoint* checkpoint) {
  DensificationStatistics& statistics = checkpoint->statistics;
  uint64_t num_statistics = 0;
  uint64_t num_facts = 0;
  if (!reader->Get(&checkpoint->iteration) ||
      !reader->Get(&checkpoint->elapsed_seconds) ||
      !GetModel(reader, &checkpoint->model) ||
      !reader->Get(&checkpoint->adam.steps) ||
      !GetModel(reader, &checkpoint->adam.first_moments) ||
      !GetModel(reader, &checkpoint->adam.second_moments) ||
      !reader->Get(&num_statistics) ||
      !reader->GetArray(num_statistics, &statistics.gradient_sum) ||
      !reader->GetArray(num_statistics, &statistics.visible_steps) ||
      !reader->GetArray(num_statistics, &statistics.max_dominant_share) ||
      !ReadHistory(reader, &checkpoint->history) || !reader->Get(&num_facts)) {
    return false;
  }
  for (uint64_t i = 0; i < num_facts; ++i) {
    std::string name;
    std::string value;
    if (!reader->GetText(&name) || !reader->GetText(&value)) return false;
    checkpoint->facts[name] = value;
  }
  return reader->at_end() && checkpoint->iteration >= 0 &&
         LiesBehind(*checkpoint) &&
         Fits(checkpoint->adam.first_moments, checkpoint->model) &&
         Fits(checkpoint->adam.second_moments, checkpoint->model) &&
         (num_statistics == 0 || num_statistics == checkpoint->model.size());
}

void WriteCheckpoint(const TrainingCheckpointView& checkpoint,
                     PieceWriter* writer) {
  writer->PutBytes(kMagic);
  writer->Put(kVersion);
  writer->Put(checkpoint.iteration);
  writer->Put(checkpoint.elapsed_seconds);
  PutModel(*checkpoint.model, writer);
  writer->Put(checkpoint.adam->steps);
  PutModel(checkpoint.adam->first_moments, writer);
  PutModel(checkpoint.adam->second_moments, writer);
  const DensificationStatistics& statistics = *checkpoint.statistics;
  writer->Put<uint64_t>(statistics.size());
  writer->PutArray(statistics.gradient_sum);
  writer->PutArray(statistics.visible_steps);
  writer->PutArray(statistics.max_dominant_share);
  WriteHistory(*checkpoint.history, writer);
  writer->Put<uint64_t>(checkpoint.facts.size());
  for (const auto& [name, value] : checkpoint.facts) {
    writer->PutText(name);
    writer->PutText(value);
  }
  writer->PutBytes(HashBytes(writer->Pieces()));
}

// The checkpoint files of a folder, the newest first.
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

// Removes unfinished files of a program that was killed while writing.
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

// Whether all arrays are those of as many Gaussians.
bool HasAllParameters(const GaussianModel& model) {
  return std::ranges::all_of(kAllParameters, [&](Parameter parameter) {
    return ParameterArray(model, parameter).size() ==
           model.size() * ParameterStride(model, parameter);
  });
}

}  // namespace

bool IsWhole(const TrainingCheckpoint& checkpoint) {
  const GaussianModel& model = checkpoint.model;
  const TrainingHistory& history = checkpoint.history;
  const auto is_like = [&model](const GaussianModel& other) {
    return other.size() == model.size() && other.sh_degree == model.sh_degree &&
           HasAllParameters(other);
  };
  const DensificationStatistics& statistics = checkpoint.statistics;
  if (!HasAllParameters(model) || !is_like(checkpoint.adam.first_moments) ||
      !is_like(checkpoint.adam.second_moments) ||
      statistics.gradient_sum.size() != model.size() ||
      statistics.visible_steps.size() != model.size() ||
      statistics.max_dominant_share.size() != model.size() ||
      (history.average.count > 0 && !is_like(history.average.mean))) {
    return false;
  }
  const std::optional<GoodState>& good = history.last_good;
  return !good ||
         (good->iteration >= 0 && good->iteration <= checkpoint.iteration &&
          HasAllParameters(good->model) &&
          good->colors.entries.size() == history.colors.entries.size());
}

TrainingCheckpointView ViewOf(const TrainingCheckpoint& checkpoint) {
  return {.iteration = checkpoint.iteration,
          .elapsed_seconds = checkpoint.elapsed_seconds,
          .model = &checkpoint.model,
          .adam = &checkpoint.adam,
          .statistics = &checkpoint.statistics,
          .history = &checkpoint.history,
          .facts = checkpoint.facts};
}

std::string SerializeCheckpoint(const TrainingCheckpoint& checkpoint) {
  PieceWriter writer;
  WriteCheckpoint(ViewOf(checkpoint), &writer);
  std::string content;
  for (const std::string_view piece : writer.Pieces()) content.append(piece);
  return content;
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
  ByteReader reader(body.substr(kMagic.size()));
  uint32_t version = 0;
  if (!reader.Get(&version) || version != kVersion) {
    return BadInputError("training checkpoint is of format " +
                         std::to_string(version) + ", this program reads " +
                         std::to_string(kVersion));
  }
  TrainingCheckpoint checkpoint;
  if (!ReadPayload(&reader, &checkpoint)) {
    return BadInputError("training checkpoint is malformed");
  }
  return checkpoint;
}

fs::path CheckpointPath(const fs::path& folder, int64_t iteration) {
  char name[64];
  std::snprintf(name,
                sizeof(name),
                "iteration_%08lld.ckpt",
                static_cast<long long>(iteration));
  return folder / name;
}

Status SaveCheckpoint(const fs::path& folder,
                      const TrainingCheckpointView& checkpoint,
                      int keep) {
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
  PieceWriter writer;
  WriteCheckpoint(checkpoint, &writer);
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(
      CheckpointPath(folder, checkpoint.iteration), writer.Pieces()));
  RemoveParts(folder);
  int kept = 0;
  for (const auto& [iteration, path] : ListCheckpoints(folder)) {
    if (iteration <= checkpoint.iteration && kept < std::max(1, keep)) {
      ++kept;
      continue;
    }
    // A file that cannot be removed does no harm but for the disk space.
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  return Status();
}

StatusOr<TrainingCheckpoint> LoadCheckpoint(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content,
                          ReadFile(path, kMaxFileBytes));
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
