// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturbance.h"

#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

#include "core/number_text.h"

namespace freegs::stages {
namespace {

struct KnownDisturbance {
  DisturbanceKind kind;
  std::string_view name;
  std::string_view unit;  // What the amount is called; empty without one.
  double min = 0;
  double max = 0;
  bool whole = false;
};

using Kind = DisturbanceKind;

constexpr KnownDisturbance kKnown[] = {
    {Kind::kNone, "none", ""},
    {Kind::kNoise, "noise", "SIGMA", 0, 255},
    {Kind::kBlur, "blur", "PIXELS", 0, 100},
    {Kind::kJpeg, "jpeg", "QUALITY", 1, 100, true},
    {Kind::kExposure, "exposure", "STOPS", -10, 10},
    {Kind::kWhiteBalance, "white_balance", "STOPS", -10, 10},
    {Kind::kTexture, "texture", "AMOUNT", 0, 1},
    {Kind::kMover, "mover", "SIZE", 0, 1},
    {Kind::kDrop, "drop", "SHARE", 0, 1},
    {Kind::kViews, "views", "N", 1, 1e6, true},
    {Kind::kShuffle, "shuffle", ""},
    {Kind::kFocal, "focal", "FACTOR", 0.01, 100},
    {Kind::kJitter, "jitter", "PIXELS", 0, 1000},
    {Kind::kScale, "scale", "FACTOR", 1e-9, 1e9},
    {Kind::kMove, "move", "DISTANCE", 0, 1e9},
};

std::string Usage(const KnownDisturbance& known) {
  std::string text(known.name);
  if (!known.unit.empty()) text += ":" + std::string(known.unit);
  return text;
}

Status Unknown(const std::string& text) {
  std::string all;
  for (const KnownDisturbance& known : kKnown) {
    all += (all.empty() ? "" : ", ") + Usage(known);
  }
  return InvalidArgumentError("unknown disturbance '" + text + "'; there are " +
                              all);
}

}  // namespace

bool Disturbance::ChangesPoses() const {
  return kind == Kind::kJitter || kind == Kind::kScale || kind == Kind::kMove;
}

StatusOr<Disturbance> ParseDisturbance(const std::string& text) {
  const size_t colon = text.find(':');
  const std::string_view name = std::string_view(text).substr(0, colon);
  for (const KnownDisturbance& known : kKnown) {
    if (name != known.name) continue;
    if (known.unit.empty()) {
      if (colon == std::string::npos) return Disturbance{known.kind, 0};
      return InvalidArgumentError("'" + text + "': it is just " + Usage(known));
    }
    const auto fault = [&] {
      return InvalidArgumentError(
          "'" + text + "': it is " + Usage(known) + " with " +
          (known.whole ? "a whole number" : "a number") + " from " +
          FormatSignificant(known.min, 9) + " to " +
          FormatSignificant(known.max, 9));
    };
    if (colon == std::string::npos) return fault();
    Disturbance disturbance{known.kind, 0};
    const char* const end = text.data() + text.size();
    const auto [rest, error] =
        std::from_chars(text.data() + colon + 1, end, disturbance.amount);
    const double amount = disturbance.amount;
    if (error != std::errc() || rest != end || !(amount >= known.min) ||
        !(amount <= known.max) ||
        (known.whole && amount != std::floor(amount))) {
      return fault();
    }
    return disturbance;
  }
  return Unknown(text);
}

}  // namespace freegs::stages
