// SPDX-License-Identifier: BSD-3-Clause
// A small pool of threads for loops over independent work.

#ifndef FREEGS_CORE_PARALLEL_H_
#define FREEGS_CORE_PARALLEL_H_

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/function_ref.h"

namespace freegs {

// Runs loops on several threads:
//
//   ThreadPool pool;  // One thread per core.
//   std::vector<double> squares(n);
//   pool.ParallelFor(0, n, 1024, [&](int64_t first, int64_t last, int) {
//     for (int64_t i = first; i < last; ++i) squares[i] = i * i;
//   });
//
// Results must not depend on the number of threads. So each index writes only
// to its own output, and sums are taken afterwards, in the order of the
// indices.
class ThreadPool {
 public:
  // num_threads <= 0 takes one thread per core that the process may use. Where
  // the system does not start as many, the pool has those that it did start.
  explicit ThreadPool(int num_threads = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int num_threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls body(first, last, worker) for ranges of `grain` indices that cover
  // [begin, end); the last range may be shorter. Range k begins at
  // begin + k * grain, whatever the number of threads. `worker`, in
  // [0, num_threads()), tells which thread runs the range, for memory that each
  // thread reuses. The calling thread works too, and the call returns when all
  // ranges are done. body must not call ParallelFor of this pool.
  //
  // Code of this project returns errors, but memory can run out in `body`. No
  // range begins after one has thrown; what was thrown first leaves this call
  // when no thread is at work any more.
  void ParallelFor(int64_t begin,
                   int64_t end,
                   int64_t grain,
                   FunctionRef<void(int64_t, int64_t, int)> body);

 private:
  void WorkerLoop(int worker);
  void RunRanges(int worker) noexcept;

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  // The number of the loop in progress. Whoever sees it change sees what was
  // written before it.
  std::atomic<uint64_t> generation_{0};
  std::atomic<int> active_{0};  // Workers that have not finished the loop.
  bool stop_ = false;

  // The loop in progress.
  const FunctionRef<void(int64_t, int64_t, int)>* body_ = nullptr;
  int64_t begin_ = 0;
  int64_t end_ = 0;
  int64_t grain_ = 1;
  std::atomic<int64_t> next_{0};  // The number of the next range.
  std::exception_ptr thrown_;     // Guarded by mutex_.
};

}  // namespace freegs

#endif  // FREEGS_CORE_PARALLEL_H_
