// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/exposure_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "core/text.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using splat::AffineColor;

constexpr size_t kRows = 3;
constexpr size_t kColumns = 4;

// Where AffineColor has the number that stands in row `r` and column `c` of the
// file. 3DGS multiplies a colour, as a row, from the left with the first three
// columns, so in the file these are transposed. The fourth column is what is
// added to the channel of its row, in both.
size_t PlaceOf(size_t r, size_t c) {
  return c < kRows ? c * kColumns + r : r * kColumns + c;
}

json RowsOf(const AffineColor& color) {
  json rows = json::array();
  for (size_t r = 0; r < kRows; ++r) {
    json row = json::array();
    for (size_t c = 0; c < kColumns; ++c) {
      row.push_back(color.values[PlaceOf(r, c)]);
    }
    rows.push_back(row);
  }
  return rows;
}

// Nothing unless it is 3 rows of 4 finite numbers.
std::optional<AffineColor> ColorOf(const json& rows) {
  if (!rows.is_array() || rows.size() != kRows) return std::nullopt;
  AffineColor color;
  for (size_t r = 0; r < kRows; ++r) {
    if (!rows[r].is_array() || rows[r].size() != kColumns) return std::nullopt;
    for (size_t c = 0; c < kColumns; ++c) {
      if (!rows[r][c].is_number()) return std::nullopt;
      const float value = rows[r][c].get<float>();
      if (!std::isfinite(value)) return std::nullopt;
      color.values[PlaceOf(r, c)] = value;
    }
  }
  return color;
}

}  // namespace

Status WriteExposures(const fs::path& path,
                      std::span<const splat::PhotoExposure> exposures) {
  json photos = json::object();
  for (const splat::PhotoExposure& exposure : exposures) {
    photos[exposure.photo] = RowsOf(exposure.color);
  }
  return WriteFileAtomic(path, JsonText(photos, 1));
}

ImageF InExposureOf(std::string_view photo,
                    std::span<const splat::PhotoExposure> exposures,
                    ImageF picture,
                    ThreadPool& pool) {
  if (exposures.empty()) return picture;
  const auto learnt =
      std::ranges::find(exposures, photo, &splat::PhotoExposure::photo);
  ImageF exposed;
  splat::ApplyColor(learnt != exposures.end()
                        ? learnt->color
                        : splat::ExposureBetween(exposures, photo),
                    picture,
                    pool,
                    &exposed);
  return exposed;
}

StatusOr<std::vector<splat::PhotoExposure>> ReadExposures(
    const fs::path& path) {
  std::vector<splat::PhotoExposure> exposures;
  std::error_code error;
  if (!fs::exists(path, error)) return exposures;
  FREEGS_ASSIGN_OR_RETURN(const json photos, ReadJson(path));
  if (!photos.is_object()) {
    return BadInputError(path.string() + ": not an object of photos");
  }
  for (const auto& [photo, rows] : photos.items()) {
    const std::optional<AffineColor> color = ColorOf(rows);
    if (!color) {
      return BadInputError(path.string() + ": the exposure of " + photo +
                           " is not 3 rows of 4 numbers");
    }
    exposures.push_back({photo, *color});
  }
  std::ranges::sort(exposures, NaturalLess, &splat::PhotoExposure::photo);
  return exposures;
}

}  // namespace freegs::stages
