// SPDX-License-Identifier: BSD-3-Clause

#include "core/parallel.h"

#include <algorithm>
#include <utility>

namespace freegs {
namespace {

// A thread that has nothing to do looks for work so many times before it
// sleeps. To wake a sleeping thread takes about as long as a short loop, and
// loops mostly follow each other at once.
constexpr int kSpins = 2000;

// Tells the processor that this thread only waits.
void Pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

template <class Condition>
void SpinUntil(const Condition& condition) {
  for (int i = 0; i < kSpins && !condition(); ++i) Pause();
}

}  // namespace

ThreadPool::ThreadPool(int num_threads) {
  if (num_threads <= 0) {
    num_threads =
        static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  }
  workers_.reserve(num_threads - 1);
  try {
    for (int worker = 1; worker < num_threads; ++worker) {
      workers_.emplace_back([this, worker] { WorkerLoop(worker); });
    }
  } catch (const std::exception&) {
    // A limit on threads, or no memory for one more stack. Results do not
    // depend on the number of threads, so those that were started will do.
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    generation_.fetch_add(1, std::memory_order_release);
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::ParallelFor(int64_t begin,
                             int64_t end,
                             int64_t grain,
                             FunctionRef<void(int64_t, int64_t, int)> body) {
  if (begin >= end) return;
  grain = std::max<int64_t>(1, grain);
  if (workers_.empty() || end - begin <= grain) {
    for (int64_t first = begin; first < end; first += grain) {
      body(first, std::min(end, first + grain), 0);
    }
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    body_ = &body;
    begin_ = begin;
    end_ = end;
    grain_ = grain;
    next_.store(0, std::memory_order_relaxed);
    active_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
    generation_.fetch_add(1, std::memory_order_release);
  }
  wake_.notify_all();
  RunRanges(0);
  const auto done = [this] {
    return active_.load(std::memory_order_acquire) == 0;
  };
  SpinUntil(done);
  std::unique_lock lock(mutex_);
  done_.wait(lock, done);
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

void ThreadPool::RunRanges(int worker) noexcept {
  try {
    for (;;) {
      const int64_t index = next_.fetch_add(1, std::memory_order_relaxed);
      const int64_t first = begin_ + index * grain_;
      if (first >= end_) return;
      (*body_)(first, std::min(end_, first + grain_), worker);
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    if (!thrown_) thrown_ = std::current_exception();
    // The other threads find no range left.
    next_.store((end_ - begin_ + grain_ - 1) / grain_,
                std::memory_order_relaxed);
  }
}

void ThreadPool::WorkerLoop(int worker) {
  uint64_t seen = 0;
  const auto has_work = [&] {
    return generation_.load(std::memory_order_acquire) != seen;
  };
  for (;;) {
    SpinUntil(has_work);
    if (!has_work()) {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, has_work);
    }
    if (stop_) return;
    // It changes again only when this loop is done.
    seen = generation_.load(std::memory_order_relaxed);
    RunRanges(worker);
    if (active_.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      const std::lock_guard lock(mutex_);
      done_.notify_one();
    }
  }
}

}  // namespace freegs
