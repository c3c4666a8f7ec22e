// SPDX-License-Identifier: BSD-3-Clause
// The thread pool: every index once, and the same ranges for any number of
// threads.

#include "core/parallel.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs {
namespace {

TEST(ThreadPoolTest, EveryIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.num_threads(), threads);
    for (const int64_t grain : {0, 1, 3, 7, 1000}) {
      std::vector<std::atomic<int>> counts(101);
      pool.ParallelFor(
          0, 101, grain, [&](int64_t first, int64_t last, int worker) {
            EXPECT_GE(worker, 0);
            EXPECT_LT(worker, threads);
            for (int64_t i = first; i < last; ++i) ++counts[i];
          });
      for (const auto& count : counts) EXPECT_EQ(count, 1);
    }
  }
}

TEST(ThreadPoolTest, RangesDoNotDependOnThreads) {
  const auto ranges = [](int threads) {
    ThreadPool pool(threads);
    std::mutex mutex;
    std::set<std::pair<int64_t, int64_t>> seen;
    pool.ParallelFor(5, 100, 8, [&](int64_t first, int64_t last, int) {
      const std::lock_guard lock(mutex);
      seen.emplace(first, last);
    });
    return seen;
  };
  const auto one = ranges(1);
  EXPECT_EQ(one.size(), 12u);
  EXPECT_EQ(*one.begin(), std::make_pair(int64_t{5}, int64_t{13}));
  EXPECT_EQ(one, ranges(2));
  EXPECT_EQ(one, ranges(4));
}

TEST(ThreadPoolTest, EmptyRangeCallsNothing) {
  ThreadPool pool(2);
  for (const int64_t end : {0, -5}) {
    pool.ParallelFor(0, end, 1, [](int64_t, int64_t, int) { FAIL(); });
  }
}

TEST(ThreadPoolTest, ManyLoopsInARow) {
  ThreadPool pool(3);
  std::atomic<int64_t> sum{0};
  for (int k = 0; k < 2000; ++k) {
    pool.ParallelFor(0, 10, 1, [&](int64_t first, int64_t last, int) {
      for (int64_t i = first; i < last; ++i) sum += i;
    });
  }
  EXPECT_EQ(sum, 2000 * 45);
}

// The pattern all of the project uses: a sum per range, added up in order.
TEST(ThreadPoolTest, OrderedReductionHasTheSameBytes) {
  const auto sum = [](int threads) {
    ThreadPool pool(threads);
    constexpr int64_t kCount = 10000;
    constexpr int64_t kGrain = 64;
    std::vector<float> parts((kCount + kGrain - 1) / kGrain);
    pool.ParallelFor(0, kCount, kGrain, [&](int64_t first, int64_t last, int) {
      float part = 0;
      for (int64_t i = first; i < last; ++i) {
        part += std::sin(static_cast<float>(RandomUniform(1, 1, i)));
      }
      parts[first / kGrain] = part;
    });
    float total = 0;
    for (const float part : parts) total += part;
    return total;
  };
  const float one = sum(1);
  for (const int threads : {2, 3, 8}) {
    const float other = sum(threads);
    EXPECT_EQ(std::memcmp(&one, &other, sizeof(one)), 0);
  }
}

TEST(ThreadPoolTest, DefaultTakesAtLeastOneThread) {
  ThreadPool pool;
  EXPECT_GE(pool.num_threads(), 1);
}

}  // namespace
}  // namespace freegs
