// SPDX-License-Identifier: BSD-3-Clause
// Bounds how many threads wait for the same work.

#ifndef FREEGS_STAGES_VIEW_TURNS_H_
#define FREEGS_STAGES_VIEW_TURNS_H_

#include <mutex>

namespace freegs::stages {

// One thread at a time has the turn. Only a few others wait for it; the rest is
// sent away at once, so that it can do something else.
//
//   const Turns::Turn turn(&turns);  // Waits here.
//   if (!turn) return TooMany();
//   Work();  // Alone.
class Turns {
 public:
  // `max_threads`: the one that has the turn and those that wait. With 0 all
  // are sent away.
  explicit Turns(int max_threads) : max_threads_(max_threads) {}
  Turns(const Turns&) = delete;
  Turns& operator=(const Turns&) = delete;

  // The turn is given back at the end of its life.
  class Turn {
   public:
    explicit Turn(Turns* turns) : turns_(turns->Take() ? turns : nullptr) {}
    ~Turn() {
      if (turns_ != nullptr) turns_->GiveBack();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    // False for a thread that was sent away.
    explicit operator bool() const { return turns_ != nullptr; }

   private:
    Turns* const turns_;
  };

 private:
  bool Take() {
    {
      const std::lock_guard lock(count_mutex_);
      if (num_threads_ >= max_threads_) return false;
      ++num_threads_;
    }
    turn_.lock();
    return true;
  }

  void GiveBack() {
    turn_.unlock();
    const std::lock_guard lock(count_mutex_);
    --num_threads_;
  }

  const int max_threads_;
  std::mutex count_mutex_;
  int num_threads_ = 0;
  std::mutex turn_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_TURNS_H_
