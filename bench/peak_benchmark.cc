// SPDX-License-Identifier: BSD-3-Clause
// What the machine can do at best, for comparison: multiply-adds per second of
// one thread, and bytes per second to and from memory.

#include <cstddef>
#include <cstdint>
#include <ctime>

#include <benchmark/benchmark.h>

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/peak_benchmark.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Does steps * 12 vectors of multiply-adds and adds the operations to *flops.
// Twelve sums at a time: more than units times latency, and with two factors no
// more than the 16 registers of AVX2.
float MultiplyAdds(int64_t steps, float start, double* flops) {
  const hn::ScalableTag<float> d;
  const auto x = hn::Set(d, 0.999f);
  const auto y = hn::Set(d, 0.001f * start);
  auto s0 = hn::Set(d, start), s1 = hn::Set(d, start + 1);
  auto s2 = hn::Set(d, start + 2), s3 = hn::Set(d, start + 3);
  auto s4 = hn::Set(d, start + 4), s5 = hn::Set(d, start + 5);
  auto s6 = hn::Set(d, start + 6), s7 = hn::Set(d, start + 7);
  auto s8 = hn::Set(d, start + 8), s9 = hn::Set(d, start + 9);
  auto s10 = hn::Set(d, start + 10), s11 = hn::Set(d, start + 11);
  for (int64_t i = 0; i < steps; ++i) {
    s0 = hn::MulAdd(s0, x, y);
    s1 = hn::MulAdd(s1, x, y);
    s2 = hn::MulAdd(s2, x, y);
    s3 = hn::MulAdd(s3, x, y);
    s4 = hn::MulAdd(s4, x, y);
    s5 = hn::MulAdd(s5, x, y);
    s6 = hn::MulAdd(s6, x, y);
    s7 = hn::MulAdd(s7, x, y);
    s8 = hn::MulAdd(s8, x, y);
    s9 = hn::MulAdd(s9, x, y);
    s10 = hn::MulAdd(s10, x, y);
    s11 = hn::MulAdd(s11, x, y);
  }
  *flops +=
      static_cast<double>(steps) * 12 * 2 * static_cast<double>(hn::Lanes(d));
  const auto a = hn::Add(hn::Add(s0, s1), hn::Add(s2, s3));
  const auto b = hn::Add(hn::Add(s4, s5), hn::Add(s6, s7));
  const auto c = hn::Add(hn::Add(s8, s9), hn::Add(s10, s11));
  return hn::GetLane(hn::Add(hn::Add(a, b), c));
}

// out = a + 3 b; n a multiple of 64, arrays aligned to vectors.
void Triad(const float* a, const float* b, size_t n, float* out) {
  const hn::ScalableTag<float> d;
  const auto factor = hn::Set(d, 3.0f);
  for (size_t i = 0; i < n; i += hn::Lanes(d)) {
    hn::Store(
        hn::MulAdd(factor, hn::Load(d, b + i), hn::Load(d, a + i)), d, out + i);
  }
}

// Does what Triad does, with stores that go past the caches.
void StreamingTriad(const float* a, const float* b, size_t n, float* out) {
  const hn::ScalableTag<float> d;
  const auto factor = hn::Set(d, 3.0f);
  for (size_t i = 0; i < n; i += hn::Lanes(d)) {
    hn::Stream(
        hn::MulAdd(factor, hn::Load(d, b + i), hn::Load(d, a + i)), d, out + i);
  }
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace freegs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <hwy/aligned_allocator.h>

namespace freegs {
namespace {

HWY_EXPORT(MultiplyAdds);
HWY_EXPORT(Triad);
HWY_EXPORT(StreamingTriad);
HWY_EXPORT(TargetName);

// Floats per array: 128 MiB each, far more than a share of any L3 cache.
constexpr size_t kArraySize = size_t{32} << 20;

// Operations per second of one thread, a multiply-add counting two, and per
// second of CPU time, which other programs on the machine spoil less.
void BM_FmaPeak(benchmark::State& state) {
  double flops = 0;
  float start = 1;
  const std::clock_t cpu = std::clock();
  for (auto _ : state) {
    benchmark::DoNotOptimize(start);
    float sum = HWY_DYNAMIC_DISPATCH(MultiplyAdds)(1000000, start, &flops);
    benchmark::DoNotOptimize(sum);
  }
  const double cpu_seconds =
      static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  state.counters["GFLOP"] =
      benchmark::Counter(1e-9 * flops, benchmark::Counter::kIsRate);
  state.counters["GFLOP_per_cpu_s"] = 1e-9 * flops / cpu_seconds;
  state.SetLabel(HWY_DYNAMIC_DISPATCH(TargetName)());
}
BENCHMARK(BM_FmaPeak)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// Bytes per second of a triad, counting two reads and one write per element, as
// STREAM does; ordinary stores also read what they overwrite, which is not
// counted. Arguments: streaming stores or not, threads.
void BM_MemoryTriad(benchmark::State& state) {
  const bool streaming = state.range(0) != 0;
  ThreadPool pool(static_cast<int>(state.range(1)));
  const auto a = hwy::AllocateAligned<float>(kArraySize);
  const auto b = hwy::AllocateAligned<float>(kArraySize);
  const auto out = hwy::AllocateAligned<float>(kArraySize);
  if (!a || !b || !out) {
    state.SkipWithError("not enough memory");
    return;
  }
  for (size_t i = 0; i < kArraySize; ++i) {
    a[i] = 1;
    b[i] = 2;
    out[i] = 0;
  }
  constexpr int64_t kGrain = int64_t{1} << 20;
  for (auto _ : state) {
    pool.ParallelFor(
        0, kArraySize, kGrain, [&](int64_t first, int64_t last, int) {
          const auto n = static_cast<size_t>(last - first);
          if (streaming) {
            HWY_DYNAMIC_DISPATCH(StreamingTriad)
            (a.get() + first, b.get() + first, n, out.get() + first);
          } else {
            HWY_DYNAMIC_DISPATCH(Triad)
            (a.get() + first, b.get() + first, n, out.get() + first);
          }
        });
    benchmark::ClobberMemory();
  }
  state.counters["GB"] =
      benchmark::Counter(1e-9 * 3 * sizeof(float) * kArraySize,
                         benchmark::Counter::kIsIterationInvariantRate);
  state.SetLabel(HWY_DYNAMIC_DISPATCH(TargetName)());
}
BENCHMARK(BM_MemoryTriad)
    ->ArgNames({"streaming", "threads"})
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace freegs

#endif  // HWY_ONCE
