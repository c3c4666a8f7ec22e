// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/reference.h"

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "stages/bench/child_outcome.h"

namespace freegs::stages {
namespace {

// Figures of eval of which more is better, and of which none is zero.
constexpr std::array<const char*, 12> kAccuracies = {"holdout_psnr",
                                                     "holdout_ssim",
                                                     "psnr",
                                                     "ssim",
                                                     "instance_miou",
                                                     "best_level_miou",
                                                     "click_miou",
                                                     "pq",
                                                     "text_miou",
                                                     "text_mbiou",
                                                     "text_box_miou",
                                                     "box_miou"};

// What the reference cells of a scene gave.
struct Reference {
  std::set<std::string> kinds;
  std::map<std::string, std::pair<double, int>> sums;  // And counts.
};

void Add(const CellResult& result, Reference* reference) {
  for (const SaidLine& line : result.kinds) {
    reference->kinds.insert(KindOfLine(line.text));
  }
  for (const char* name : kAccuracies) {
    const auto value = result.values.find(name);
    if (value == result.values.end()) continue;
    auto& [sum, count] = reference->sums[name];
    sum += value->second;
    ++count;
  }
}

void Compare(const Reference& reference,
             bool is_reference,
             CellResult* result) {
  result->told = {};
  for (const SaidLine& line : result->kinds) {
    if (!is_reference && reference.kinds.contains(KindOfLine(line.text))) {
      continue;
    }
    result->told = line;
    break;
  }
  for (const auto& [name, of_reference] : reference.sums) {
    const auto value = result->values.find(name);
    const double mean = of_reference.first / of_reference.second;
    if (value == result->values.end() || !(mean > 0)) continue;
    result->values[kKeptPrefix + name] = 100 * value->second / mean;
  }
}

}  // namespace

void CompareWithReference(const Suite& suite,
                          const std::vector<SuiteCell>& cells,
                          std::vector<CellResult>* results) {
  std::vector<Reference> references(suite.scenes.size());
  for (size_t i = 0; i < cells.size(); ++i) {
    if (!suite.reference.empty() && cells[i].grid == suite.reference) {
      Add((*results)[i], &references[cells[i].scene]);
    }
  }
  for (size_t i = 0; i < cells.size(); ++i) {
    Compare(references[cells[i].scene],
            cells[i].grid == suite.reference,
            &(*results)[i]);
  }
}

}  // namespace freegs::stages
