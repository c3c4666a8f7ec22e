// SPDX-License-Identifier: BSD-3-Clause
// The thread pool: every index once, and the same ranges for any number of
// threads.

#include "core/parallel.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <optional>
#include <pthread.h>
#include <set>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
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

// One thread throws while the others are at work. The call must not return
// before they are done with what the caller owns.
TEST(ThreadPoolTest, WhatARangeThrowsLeavesOnTheCaller) {
  constexpr int kThreads = 3;
  ThreadPool pool(kThreads);
  for (int thrower = 0; thrower < kThreads; ++thrower) {
    std::atomic<int> begun{0};
    std::atomic<int> at_work{0};
    std::atomic<bool> thrown{false};
    const auto loop = [&] {
      pool.ParallelFor(0, 1000, 1, [&](int64_t, int64_t, int worker) {
        ++begun;
        if (worker == thrower) {
          while (begun < kThreads) std::this_thread::yield();
          thrown = true;
          throw std::bad_alloc();
        }
        ++at_work;
        while (!thrown) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        --at_work;
      });
    };
    EXPECT_THROW(loop(), std::bad_alloc);
    EXPECT_EQ(at_work, 0);
    EXPECT_LE(begun, 2 * kThreads);  // No range begins any more.
    std::atomic<int> count{0};
    pool.ParallelFor(0, 100, 1, [&](int64_t, int64_t, int) { ++count; });
    EXPECT_EQ(count, 100);
  }
}

TEST(ThreadPoolTest, OneThreadThrowsToo) {
  ThreadPool pool(1);
  const auto loop = [&] {
    pool.ParallelFor(
        0, 10, 1, [](int64_t, int64_t, int) { throw std::bad_alloc(); });
  };
  EXPECT_THROW(loop(), std::bad_alloc);
}

// Limits the address space of this process while it lives.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(rlim_t more_bytes) {
    getrlimit(RLIMIT_AS, &usual_);
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t page_bytes = static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
    const rlimit limit = {pages * page_bytes + more_bytes, usual_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  }
  ~AddressSpaceLimit() { setrlimit(RLIMIT_AS, &usual_); }

 private:
  rlimit usual_ = {};
};

// There is room for the stacks of some of the threads.
TEST(ThreadPoolTest, TakesTheThreadsThatTheSystemGives) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need the whole address space";
#endif
  constexpr size_t kStackBytes = size_t{1} << 28;
  pthread_attr_t usual;
  ASSERT_EQ(pthread_getattr_default_np(&usual), 0);
  pthread_attr_t large;
  ASSERT_EQ(pthread_getattr_default_np(&large), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&large, kStackBytes), 0);
  ASSERT_EQ(pthread_setattr_default_np(&large), 0);
  std::optional<AddressSpaceLimit> limit(4 * kStackBytes);
  ThreadPool pool(16);
  limit.reset();
  EXPECT_EQ(pthread_setattr_default_np(&usual), 0);
  EXPECT_GT(pool.num_threads(), 1);
  EXPECT_LT(pool.num_threads(), 16);
  std::atomic<int> count{0};
  pool.ParallelFor(0, 100, 1, [&](int64_t, int64_t, int worker) {
    EXPECT_LT(worker, pool.num_threads());
    ++count;
  });
  EXPECT_EQ(count, 100);
  pthread_attr_destroy(&large);
  pthread_attr_destroy(&usual);
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
