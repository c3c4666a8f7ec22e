// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/field_checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/io/byte_stream.h"
#include "core/io/files.h"
#include "semantics/losses/decoder_file.h"

namespace freegs::semantics {
namespace {

constexpr std::string_view kCheckpointMagic = "FREEGSFT";
constexpr uint32_t kCheckpointVersion = 1;

template <typename T>
void PutSized(const std::vector<T>& array, ByteWriter* writer) {
  writer->Put<uint64_t>(array.size());
  writer->PutArray(array);
}

template <typename T>
bool GetSized(ByteReader* reader, std::vector<T>* array) {
  uint64_t count = 0;
  return reader->Get(&count) && reader->GetArray(count, array);
}

void PutLosses(const FieldLosses& losses, ByteWriter* writer) {
  writer->Put(losses.pixel);
  writer->Put(losses.instance);
  writer->Put(losses.smoothing);
  writer->Put(losses.contrastive);
}

bool GetLosses(ByteReader* reader, FieldLosses* losses) {
  return reader->Get(&losses->pixel) && reader->Get(&losses->instance) &&
         reader->Get(&losses->smoothing) && reader->Get(&losses->contrastive);
}

bool GetRounds(ByteReader* reader, std::vector<ClusteringRound>* rounds) {
  uint64_t count = 0;
  if (!reader->Get(&count)) return false;
  for (uint64_t i = 0; i < count; ++i) {
    ClusteringRound round;
    if (!reader->Get(&round.step) || !reader->Get(&round.num_instances) ||
        !reader->Get(&round.agreement)) {
      return false;
    }
    rounds->push_back(round);
  }
  return true;
}

bool GetHistory(ByteReader* reader, std::vector<LossRecord>* history) {
  uint64_t count = 0;
  if (!reader->Get(&count)) return false;
  for (uint64_t i = 0; i < count; ++i) {
    LossRecord record;
    if (!reader->Get(&record.step) || !GetLosses(reader, &record.losses)) {
      return false;
    }
    history->push_back(record);
  }
  return true;
}

bool IsFinite(const std::vector<float>& values) {
  return std::all_of(
      values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

// Whether the parts are those of one scene and one decoder.
bool Fits(const FieldState& state) {
  const auto dim = static_cast<size_t>(state.dim());
  const size_t size = state.features.size();
  const InstanceTeachers& teachers = state.teachers;
  const auto in_range = [&](int32_t label) {
    return label >= -1 && label < teachers.num_instances;
  };
  return state.step >= 0 && size % dim == 0 && state.feature_adam.InRange() &&
         state.feature_adam.first_moments.size() == size &&
         state.feature_adam.second_moments.size() == size &&
         teachers.num_instances >= 0 &&
         (teachers.labels.empty() || teachers.labels.size() == size / dim) &&
         teachers.vectors.size() ==
             static_cast<size_t>(teachers.num_instances) *
                 state.decoder.feature_dim() &&
         std::all_of(
             teachers.labels.begin(), teachers.labels.end(), in_range) &&
         IsFinite(state.features) && IsFinite(teachers.vectors);
}

}  // namespace

StatusOr<std::string> SerializeFieldState(const FieldState& state) {
  FREEGS_ASSIGN_OR_RETURN(
      const std::string decoder,
      SerializeDecoder({state.decoder, state.decoder_adam}));
  // The arrays have most of the bytes. Without room for all of them the text
  // would be copied while it grows, and two copies would be held.
  constexpr size_t kSingleNumbers = 256;  // Bytes; more than these take.
  ByteWriter writer;
  writer.Reserve(kSingleNumbers + decoder.size() +
                 sizeof(float) * (state.features.size() +
                                  state.feature_adam.first_moments.size() +
                                  state.feature_adam.second_moments.size() +
                                  state.teachers.vectors.size()) +
                 sizeof(int32_t) * state.teachers.labels.size() +
                 sizeof(ClusteringRound) * state.rounds.size() +
                 sizeof(LossRecord) * state.history.size());
  writer.PutBytes(kCheckpointMagic);
  writer.Put(kCheckpointVersion);
  writer.PutText(decoder);
  writer.Put(state.step);
  PutSized(state.features, &writer);
  writer.Put(state.feature_adam.steps);
  PutSized(state.feature_adam.first_moments, &writer);
  PutSized(state.feature_adam.second_moments, &writer);
  writer.Put<int32_t>(state.teachers.num_instances);
  PutSized(state.teachers.labels, &writer);
  PutSized(state.teachers.vectors, &writer);
  writer.Put<uint64_t>(state.rounds.size());
  for (const ClusteringRound& round : state.rounds) {
    writer.Put(round.step);
    writer.Put(round.num_instances);
    writer.Put(round.agreement);
  }
  writer.Put<uint64_t>(state.history.size());
  for (const LossRecord& record : state.history) {
    writer.Put(record.step);
    PutLosses(record.losses, &writer);
  }
  PutLosses(state.sums, &writer);
  PutLosses(state.counts, &writer);
  writer.PutChecksum();
  return std::move(writer).content();
}

Status WriteFieldState(const std::filesystem::path& path,
                       const FieldState& state) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content,
                          SerializeFieldState(state));
  return WriteFileAtomic(path, content);
}

StatusOr<FieldState> ParseFieldState(std::string_view content) {
  const Status damaged = BadInputError(
      "not a whole checkpoint of a semantic field; remove it to begin anew");
  if (!HasChecksum(content)) return damaged;
  ByteReader reader(WithoutChecksum(content));
  if (!reader.SkipBytes(kCheckpointMagic)) return damaged;
  uint32_t version = 0;
  if (!reader.Get(&version) || version != kCheckpointVersion) {
    return BadInputError(
        "a checkpoint of another version of the program; remove it to begin "
        "anew");
  }
  std::string decoder_bytes;
  if (!reader.GetText(&decoder_bytes)) return damaged;
  FREEGS_ASSIGN_OR_RETURN(StoredDecoder decoder, ParseDecoder(decoder_bytes));
  if (!decoder.adam) return damaged;
  FieldState state{.step = 0,
                   .features = {},
                   .feature_adam = {},
                   .decoder = std::move(decoder.decoder),
                   .decoder_adam = *std::move(decoder.adam),
                   .teachers = {},
                   .rounds = {},
                   .history = {},
                   .sums = {},
                   .counts = {}};
  const bool complete =
      reader.Get(&state.step) && GetSized(&reader, &state.features) &&
      reader.Get(&state.feature_adam.steps) &&
      GetSized(&reader, &state.feature_adam.first_moments) &&
      GetSized(&reader, &state.feature_adam.second_moments) &&
      reader.Get(&state.teachers.num_instances) &&
      GetSized(&reader, &state.teachers.labels) &&
      GetSized(&reader, &state.teachers.vectors) &&
      GetRounds(&reader, &state.rounds) &&
      GetHistory(&reader, &state.history) && GetLosses(&reader, &state.sums) &&
      GetLosses(&reader, &state.counts) && reader.at_end();
  if (!complete || !Fits(state)) return damaged;
  return state;
}

StatusOr<FieldState> ReadFieldState(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(path));
  StatusOr<FieldState> state = ParseFieldState(content);
  if (!state.ok()) return state.status().Annotated(path.string());
  return state;
}

}  // namespace freegs::semantics
