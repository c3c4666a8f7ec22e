// SPDX-License-Identifier: BSD-3-Clause
// A small thread pool. Results must not depend on the number of threads: give
// each index its own output, and reduce in index order afterwards.

#ifndef FREEGS_CORE_PARALLEL_H_
#define FREEGS_CORE_PARALLEL_H_

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "core/function_ref.h"

namespace freegs {

class ThreadPool {
 public:
  // num_threads <= 0 takes one per available core.
  explicit ThreadPool(int num_threads = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int num_threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls body(first, last, worker) for consecutive ranges of at most `grain`
  // indices that cover [begin, end); the calling thread works too and the call
  // returns when all ranges are done. worker is in [0, num_threads()). Ranges
  // begin at begin + k * grain whatever the thread count. Not reentrant: body
  // must not call ParallelFor of the same pool. body must not throw.
  void ParallelFor(int64_t begin,
                   int64_t end,
                   int64_t grain,
                   FunctionRef<void(int64_t, int64_t, int)> body);

 private:
  void WorkerLoop(int worker);
  void RunRanges(int worker);

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  uint64_t generation_ = 0;
  int active_ = 0;
  bool stop_ = false;

  // The loop in progress.
  const FunctionRef<void(int64_t, int64_t, int)>* body_ = nullptr;
  int64_t begin_ = 0;
  int64_t end_ = 0;
  int64_t grain_ = 1;
  std::atomic<int64_t> next_{0};
};

}  // namespace freegs

#endif  // FREEGS_CORE_PARALLEL_H_
