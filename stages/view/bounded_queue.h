// SPDX-License-Identifier: BSD-3-Clause
// Threads that work off a queue of bounded length.

#ifndef FREEGS_STAGES_VIEW_BOUNDED_QUEUE_H_
#define FREEGS_STAGES_VIEW_BOUNDED_QUEUE_H_

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace freegs::stages {

class BoundedQueue {
 public:
  BoundedQueue(int num_threads, int max_waiting);
  ~BoundedQueue() { Finish(); }
  BoundedQueue(const BoundedQueue&) = delete;
  BoundedQueue& operator=(const BoundedQueue&) = delete;

  // Adds a task for one of the threads. When the queue is full, the task is
  // called at once, by the calling thread and with Overflows() true: it shall
  // only clean up.
  void Push(std::function<void()> task);

  // Whether the task that this thread calls found the queue full.
  static bool Overflows();

  // Returns when all tasks have been called and the threads have ended.
  void Finish();

 private:
  void Work();

  const size_t max_waiting_;
  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> tasks_;
  bool done_ = false;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_BOUNDED_QUEUE_H_
