// SPDX-License-Identifier: BSD-3-Clause
// Random numbers that are pure functions of a seed, a stream and a counter. So
// they do not depend on the number of threads, on the order of calls, or on
// whether a run was interrupted and continued. Code that uses random numbers
// for several purposes takes another stream for each.

#ifndef FREEGS_CORE_RANDOM_H_
#define FREEGS_CORE_RANDOM_H_

#include <cmath>
#include <cstdint>
#include <numbers>

namespace freegs {

// The finaliser of SplitMix64 (Steele, Lea and Flood, 2014).
constexpr uint64_t MixBits(uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

// 64 independent random bits.
constexpr uint64_t RandomBits(uint64_t seed,
                              uint64_t stream,
                              uint64_t counter) {
  return MixBits(MixBits(MixBits(seed) ^ stream) ^ counter);
}

// Uniform in [0, 1), 53 bits.
constexpr double RandomUniform(uint64_t seed,
                               uint64_t stream,
                               uint64_t counter) {
  return static_cast<double>(RandomBits(seed, stream, counter) >> 11) * 0x1p-53;
}

// Uniform integer in [0, n), n > 0 (bias below n * 2^-64).
constexpr uint64_t RandomIndex(uint64_t seed,
                               uint64_t stream,
                               uint64_t counter,
                               uint64_t n) {
  return static_cast<uint64_t>(
      (static_cast<unsigned __int128>(RandomBits(seed, stream, counter)) * n) >>
      64);
}

// Standard normal (Box-Muller).
inline double RandomNormal(uint64_t seed, uint64_t stream, uint64_t counter) {
  const double u = 1.0 - RandomUniform(seed, stream, 2 * counter);
  const double v = RandomUniform(seed, stream, 2 * counter + 1);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

// The numbers of one stream, one after another:
//
//   RandomStream random(seed, stream);
//   const double x = random.Uniform();  // In [0, 1).
//   const uint64_t i = random.Index(n);  // In [0, n).
class RandomStream {
 public:
  RandomStream(uint64_t seed, uint64_t stream) : seed_(seed), stream_(stream) {}
  uint64_t Bits() { return RandomBits(seed_, stream_, counter_++); }
  double Uniform() { return RandomUniform(seed_, stream_, counter_++); }
  uint64_t Index(uint64_t n) {
    return RandomIndex(seed_, stream_, counter_++, n);
  }
  double Normal() {
    // Counters 2k and 2k + 1 of an own stream: never shared with Uniform.
    return RandomNormal(seed_, ~stream_, counter_++);
  }

 private:
  uint64_t seed_;
  uint64_t stream_;
  uint64_t counter_ = 0;
};

}  // namespace freegs

#endif  // FREEGS_CORE_RANDOM_H_
