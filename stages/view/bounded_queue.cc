// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/bounded_queue.h"

#include <utility>

namespace freegs::stages {
namespace {

// Whether the task that this thread calls found the queue full.
bool& OverflowFlag() {
  thread_local bool overflows = false;
  return overflows;
}

}  // namespace

BoundedQueue::BoundedQueue(int num_threads, int max_waiting)
    : max_waiting_(static_cast<size_t>(max_waiting)) {
  for (int i = 0; i < num_threads; ++i) {
    threads_.emplace_back([this] { Work(); });
  }
}

bool BoundedQueue::Overflows() { return OverflowFlag(); }

void BoundedQueue::Push(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    if (tasks_.size() < max_waiting_) {
      tasks_.push_back(std::move(task));
      wake_.notify_one();
      return;
    }
  }
  OverflowFlag() = true;
  task();
  OverflowFlag() = false;
}

void BoundedQueue::Finish() {
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void BoundedQueue::Work() {
  for (;;) {
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return done_ || !tasks_.empty(); });
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

}  // namespace freegs::stages
