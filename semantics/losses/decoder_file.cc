// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/decoder_file.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/io/byte_stream.h"
#include "core/io/files.h"

namespace freegs::semantics {
namespace {

constexpr std::string_view kMagic = "FREEGSDC";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 8 + 6 * 4;

enum Kind : uint32_t { kLinear = 0, kMlp = 1 };

struct Header {
  uint32_t kind = 0;
  uint32_t latent_dim = 0;
  uint32_t hidden_dim = 0;
  uint32_t feature_dim = 0;
  uint32_t has_adam = 0;
};

Status DamagedError() {
  return BadInputError("the file is truncated or its header is damaged");
}

Status CheckAdam(const ArrayAdamState& adam, const MlpDecoder* mlp) {
  if (!mlp) {
    return InvalidArgumentError("a linear decoder has no state of Adam");
  }
  const size_t size = mlp->parameters.size();
  if (adam.first_moments.size() != size || adam.second_moments.size() != size) {
    return InvalidArgumentError("Adam's state is of another decoder");
  }
  if (!adam.InRange()) {
    return InvalidArgumentError("Adam's state is out of range");
  }
  return Status();
}

Status Check(const StoredDecoder& stored) {
  const MlpDecoder* mlp = stored.decoder.mlp();
  FREEGS_RETURN_IF_ERROR(mlp ? mlp->Check() : stored.decoder.linear()->Check());
  return stored.adam ? CheckAdam(*stored.adam, mlp) : Status();
}

// The dimensions are within int, or they would not pass for a decoder's.
bool DimensionsInRange(const Header& header) {
  const bool mlp = header.kind == kMlp;
  const auto in_range = [](uint32_t size) {
    return size <= INT32_MAX && CheckDecoderSize(static_cast<int>(size)).ok();
  };
  return in_range(header.latent_dim) && in_range(header.feature_dim) &&
         (mlp ? in_range(header.hidden_dim) : header.hidden_dim == 0) &&
         header.has_adam <= (mlp ? 1u : 0u);
}

std::optional<LinearDecoder> TakeLinear(const Header& header,
                                        ByteReader& reader) {
  LinearDecoder linear;
  linear.latent_dim = static_cast<int>(header.latent_dim);
  linear.feature_dim = static_cast<int>(header.feature_dim);
  const uint64_t channels = header.feature_dim;
  if (!reader.GetArray(channels * header.latent_dim, &linear.basis) ||
      !reader.GetArray(channels, &linear.mean)) {
    return std::nullopt;
  }
  return linear;
}

std::optional<MlpDecoder> TakeMlp(const Header& header, ByteReader& reader) {
  MlpDecoder mlp;
  mlp.shape = {.latent_dim = static_cast<int>(header.latent_dim),
               .hidden_dim = static_cast<int>(header.hidden_dim),
               .feature_dim = static_cast<int>(header.feature_dim)};
  if (!reader.GetArray(mlp.shape.num_parameters(), &mlp.parameters) ||
      !reader.GetArray(header.hidden_dim, &mlp.running_means) ||
      !reader.GetArray(header.hidden_dim, &mlp.running_variances)) {
    return std::nullopt;
  }
  return mlp;
}

bool TakeAdam(size_t size, ByteReader& reader, ArrayAdamState* adam) {
  return reader.Get(&adam->steps) &&
         reader.GetArray(size, &adam->first_moments) &&
         reader.GetArray(size, &adam->second_moments);
}

std::optional<StoredDecoder> TakeDecoder(const Header& header,
                                         ByteReader& reader) {
  if (header.kind == kLinear) {
    std::optional<LinearDecoder> linear = TakeLinear(header, reader);
    if (!linear) return std::nullopt;
    return StoredDecoder{FeatureDecoder(*std::move(linear)), std::nullopt};
  }
  std::optional<MlpDecoder> mlp = TakeMlp(header, reader);
  if (!mlp) return std::nullopt;
  const size_t size = mlp->parameters.size();
  StoredDecoder stored{FeatureDecoder(*std::move(mlp)), std::nullopt};
  if (header.has_adam && !TakeAdam(size, reader, &stored.adam.emplace())) {
    return std::nullopt;
  }
  return stored;
}

}  // namespace

StatusOr<std::string> SerializeDecoder(const StoredDecoder& stored) {
  FREEGS_RETURN_IF_ERROR(Check(stored));
  const MlpDecoder* mlp = stored.decoder.mlp();
  ByteWriter writer;
  writer.PutBytes(kMagic);
  writer.Put(kVersion);
  writer.Put<uint32_t>(mlp ? kMlp : kLinear);
  writer.Put<uint32_t>(stored.decoder.latent_dim());
  writer.Put<uint32_t>(mlp ? mlp->shape.hidden_dim : 0);
  writer.Put<uint32_t>(stored.decoder.feature_dim());
  writer.Put<uint32_t>(stored.adam ? 1 : 0);
  if (mlp) {
    writer.PutArray(mlp->parameters);
    writer.PutArray(mlp->running_means);
    writer.PutArray(mlp->running_variances);
  } else {
    writer.PutArray(stored.decoder.linear()->basis);
    writer.PutArray(stored.decoder.linear()->mean);
  }
  if (stored.adam) {
    writer.Put(stored.adam->steps);
    writer.PutArray(stored.adam->first_moments);
    writer.PutArray(stored.adam->second_moments);
  }
  writer.PutChecksum();
  return std::move(writer).content();
}

Status WriteDecoder(const std::filesystem::path& path,
                    const StoredDecoder& stored) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, SerializeDecoder(stored));
  return WriteFileAtomic(path, content);
}

StatusOr<StoredDecoder> ParseDecoder(std::string_view content) {
  if (content.size() < kHeaderSize + kChecksumBytes ||
      !content.starts_with(kMagic)) {
    return BadInputError("this is not a feature decoder");
  }
  ByteReader reader(WithoutChecksum(content).substr(kMagic.size()));
  uint32_t version = 0;
  Header header;
  if (!reader.Get(&version)) return DamagedError();
  if (version != kVersion) {
    return BadInputError("version " + std::to_string(version) +
                         " of the file is not known; another version of the "
                         "program wrote it");
  }
  if (!reader.Get(&header.kind) || !reader.Get(&header.latent_dim) ||
      !reader.Get(&header.hidden_dim) || !reader.Get(&header.feature_dim) ||
      !reader.Get(&header.has_adam) || header.kind > kMlp ||
      !DimensionsInRange(header)) {
    return DamagedError();
  }
  std::optional<StoredDecoder> stored = TakeDecoder(header, reader);
  if (!stored || !reader.at_end()) return DamagedError();
  if (!HasChecksum(content)) {
    return BadInputError("the checksum does not match; the file is damaged");
  }
  const Status good = Check(*stored);
  if (!good.ok()) return BadInputError(good.message());
  return *std::move(stored);
}

StatusOr<StoredDecoder> ReadDecoder(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(path));
  StatusOr<StoredDecoder> stored = ParseDecoder(content);
  if (!stored.ok()) return stored.status().Annotated(path.string());
  return stored;
}

}  // namespace freegs::semantics
