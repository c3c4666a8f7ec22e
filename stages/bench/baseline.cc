// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/baseline.h"

#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "core/number_text.h"
#include "pipeline/exit_code.h"

namespace freegs::stages {
namespace {

using nlohmann::json;

constexpr double kLargest = std::numeric_limits<double>::max();
constexpr int kDigits = 6;

void CompareFigures(const std::string& id,
                    const Baseline& then,
                    const BaselineCell& was,
                    const BaselineCell& is,
                    std::vector<std::string>* moved) {
  for (const auto& [figure, tolerance] : then.tolerances) {
    const auto old_value = was.values.find(figure);
    const auto new_value = is.values.find(figure);
    const bool had = old_value != was.values.end();
    const bool has = new_value != is.values.end();
    const std::string what = id + ": " + figure;
    if (had != has) {
      moved->push_back(what + (has ? " is new" : " is gone"));
    }
    if (!had || !has) continue;
    const double allowed =
        tolerance.absolute + tolerance.relative * std::abs(old_value->second);
    const double change = new_value->second - old_value->second;
    if (std::abs(change) <= allowed) continue;
    moved->push_back(what + " " +
                     FormatSignificant(old_value->second, kDigits) + " -> " +
                     FormatSignificant(new_value->second, kDigits) +
                     ", by more than " + FormatSignificant(allowed, kDigits));
  }
}

}  // namespace

std::map<std::string, Tolerance> DefaultTolerances() {
  // The PSNR of a few holdout photos of a short training is left out: it
  // differs by up to 0.9 dB between sets of instructions, that of drawn views
  // by up to 0.13 dB.
  return {{"sfm.registered", {0, 0}},
          {"sfm.pairs.pairs", {0, 0}},
          {"sfm.num_points", {0, 0.1}},
          {"pose_rotation_deg", {0.03, 0}},
          {"num_gaussians", {0, 0.12}},
          {"scene_bytes", {0, 0.12}},
          {"reconstruct.holdout_tile_pairs", {0, 0.12}},
          {"holdout_ssim", {0.02, 0}},
          {"psnr", {0.7, 0}},
          {"instance_miou", {0.06, 0}},
          {"text_miou", {0.15, 0}},
          {"box_miou", {0.12, 0}},
          {"view_consistency", {0.05, 0}}};
}

Baseline MakeBaseline(const BenchResults& bench,
                      std::map<std::string, Tolerance> tolerances) {
  Baseline baseline;
  baseline.tolerances = std::move(tolerances);
  for (size_t i = 0; i < bench.cells.size(); ++i) {
    const CellResult& result = bench.results[i];
    BaselineCell& cell = baseline.cells[ValidUtf8(bench.cells[i].id)];
    cell.status = CellStatusName(result.status);
    cell.exit_code = result.exit_code;
    cell.verdict = ValidUtf8(result.verdict);
    for (const auto& [figure, tolerance] : baseline.tolerances) {
      const auto value = result.values.find(figure);
      if (value != result.values.end()) cell.values[figure] = value->second;
    }
  }
  return baseline;
}

Status CheckForBaseline(const BenchResults& bench) {
  for (size_t i = 0; i < bench.cells.size(); ++i) {
    const int code = bench.results[i].exit_code;
    if (code != -1 && code != pipeline::ExitCode(StatusCode::kInternal) &&
        code != pipeline::ExitCode(StatusCode::kMissingDependency)) {
      continue;
    }
    return UnusableResultError(
        "no baseline is written, because " + bench.cells[i].id +
        " ended with exit code " + std::to_string(code) +
        "; remove the cause and repeat the bench: " + bench.results[i].reason);
  }
  return Status();
}

std::vector<std::string> WhatMoved(const Baseline& then, const Baseline& now) {
  std::vector<std::string> moved;
  for (const auto& [id, was] : then.cells) {
    const auto found = now.cells.find(id);
    if (found == now.cells.end()) {
      moved.push_back(id + ": the suite has no such cell any more");
      continue;
    }
    const BaselineCell& is = found->second;
    const auto compare = [&, &id = id](const std::string& what,
                                       const std::string& before,
                                       const std::string& after) {
      if (before != after) {
        moved.push_back(id + ": " + what + " '" + before + "' -> '" + after +
                        "'");
      }
    };
    compare("status", was.status, is.status);
    compare("exit code",
            std::to_string(was.exit_code),
            std::to_string(is.exit_code));
    compare("verdict", was.verdict, is.verdict);
    CompareFigures(id, then, was, is, &moved);
  }
  for (const auto& [id, is] : now.cells) {
    if (!then.cells.contains(id)) {
      moved.push_back(id + ": the baseline has no such cell");
    }
  }
  return moved;
}

json ToJson(const Baseline& baseline) {
  json document = {{"tolerances", json::object()}, {"cells", json::object()}};
  for (const auto& [figure, tolerance] : baseline.tolerances) {
    document["tolerances"][figure] = {{"absolute", tolerance.absolute},
                                      {"relative", tolerance.relative}};
  }
  for (const auto& [id, cell] : baseline.cells) {
    document["cells"][id] = {{"status", cell.status},
                             {"exit_code", cell.exit_code},
                             {"verdict", cell.verdict},
                             {"values", cell.values}};
  }
  return document;
}

StatusOr<Baseline> BaselineFromJson(const json& document,
                                    const std::string& source) {
  Baseline baseline;
  Status status;
  JsonObjectReader reader(document, source, "", &status);
  for (const auto& [figure, value] : reader.Object("tolerances").items()) {
    JsonObjectReader tolerance(value, source, "tolerances." + figure, &status);
    baseline.tolerances[figure] = {tolerance.Number("absolute", 0, kLargest),
                                   tolerance.Number("relative", 0, kLargest)};
  }
  for (const auto& [id, value] : reader.Object("cells").items()) {
    const std::string path = "cells." + id;
    JsonObjectReader cell_reader(value, source, path, &status);
    BaselineCell cell;
    cell.status = cell_reader.Text("status");
    cell.exit_code = cell_reader.Integer("exit_code", -1, 255);
    cell.verdict = cell_reader.Text("verdict");
    const json& values = cell_reader.Object("values");
    JsonObjectReader figures(values, source, path + ".values", &status);
    for (const auto& [figure, number] : values.items()) {
      cell.values[figure] = figures.Number(figure.c_str(), -kLargest, kLargest);
    }
    baseline.cells[id] = std::move(cell);
  }
  FREEGS_RETURN_IF_ERROR(status);
  return baseline;
}

}  // namespace freegs::stages
