// SPDX-License-Identifier: BSD-3-Clause
// The dense CRF and the permutohedral lattice below it, on a picture of 640 x
// 480 pixels with soft blobs, an edge and a photograph's noise.

#include <cmath>
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/image.h"
#include "core/parallel.h"
#include "core/random.h"
#include "semantics/crf/dense_crf.h"
#include "semantics/crf/permutohedral_lattice.h"

namespace freegs::semantics {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kLabels = 10;

ImageF BenchmarkImage() {
  ImageF image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double slow =
            std::sin(9.0 * x / kWidth + c) * std::cos(7.0 * y / kHeight - c);
        const double edge = 3 * x + y > 2 * kWidth ? 0.2 : -0.1;
        const auto counter = static_cast<uint64_t>(x + y * kWidth) * 3 + c;
        image(x, y, c) = static_cast<float>(0.5 + 0.2 * slow + edge * (c - 1) +
                                            0.01 * RandomNormal(1, 0, counter));
      }
    }
  }
  return image;
}

std::vector<float> RandomValues(size_t count) {
  std::vector<float> values(count);
  for (size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(RandomUniform(2, 0, i));
  }
  return values;
}

// What DenseCrf makes of the picture with its default sigmas.
std::vector<float> AppearanceFeatures(const ImageF& image) {
  const DenseCrfOptions options;
  const double side = std::sqrt(static_cast<double>(image.num_pixels()));
  const double per_pixel = 1 / (options.appearance_position_sigma * side);
  std::vector<float> features;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      features.push_back(static_cast<float>(x * per_pixel));
      features.push_back(static_cast<float>(y * per_pixel));
      for (int c = 0; c < 3; ++c) {
        features.push_back(static_cast<float>(image(x, y, c) /
                                              options.appearance_color_sigma));
      }
    }
  }
  return features;
}

void BM_LatticeBuild(benchmark::State& state) {
  ThreadPool pool(static_cast<int>(state.range(0)));
  const std::vector<float> features = AppearanceFeatures(BenchmarkImage());
  size_t vertices = 0;
  for (auto _ : state) {
    const auto lattice = PermutohedralLattice::Build(features, 5, pool);
    vertices = lattice->num_vertices();
  }
  state.counters["vertices"] = static_cast<double>(vertices);
}
BENCHMARK(BM_LatticeBuild)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void BM_LatticeFilter(benchmark::State& state) {
  const auto channels = static_cast<int>(state.range(0));
  ThreadPool pool(static_cast<int>(state.range(1)));
  const auto lattice = PermutohedralLattice::Build(
      AppearanceFeatures(BenchmarkImage()), 5, pool);
  const std::vector<float> values =
      RandomValues(lattice->num_points() * channels);
  std::vector<float> result(values.size());
  LatticeBuffers buffers;
  for (auto _ : state) {
    const Status status =
        lattice->AddFiltered(values, channels, 1, pool, &buffers, result);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
  }
}
BENCHMARK(BM_LatticeFilter)
    ->ArgNames({"channels", "threads"})
    ->ArgsProduct({{8, 32}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// Times the making of both lattices, and ten iterations.
void BM_DenseCrf(benchmark::State& state) {
  ThreadPool pool(static_cast<int>(state.range(0)));
  const ImageF image = BenchmarkImage();
  ImageF unary(kWidth, kHeight, kLabels);
  for (size_t i = 0; i < unary.size(); ++i) {
    unary.data()[i] = static_cast<float>(2 * RandomUniform(3, 0, i));
  }
  for (auto _ : state) {
    const auto crf = DenseCrf::Build(image, {}, pool);
    const auto result = crf->Infer(unary, pool);
    benchmark::DoNotOptimize(result->labels.data());
  }
}
BENCHMARK(BM_DenseCrf)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace freegs::semantics
