// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/turns.h"

#include <chrono>
#include <future>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(TurnsTest, OneWorksSomeWaitAndTheRestIsSentAway) {
  Turns turns(3);
  std::optional<Turns::Turn> first(std::in_place, &turns);
  ASSERT_TRUE(*first);
  // Two of the three wait. One does not, while the first still works.
  std::promise<void> sent_away;
  int worked = 0;  // Only who has the turn counts.
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&] {
      const Turns::Turn turn(&turns);
      if (turn) {
        ++worked;
      } else {
        sent_away.set_value();  // Throws if a second one is sent away.
      }
    });
  }
  EXPECT_EQ(sent_away.get_future().wait_for(std::chrono::seconds(10)),
            std::future_status::ready);
  first.reset();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(worked, 2);
  // All have given back their places.
  const Turns::Turn next(&turns);
  EXPECT_TRUE(next);
}

TEST(TurnsTest, WithoutPlacesAllAreSentAway) {
  Turns turns(0);
  const Turns::Turn turn(&turns);
  EXPECT_FALSE(turn);
}

}  // namespace
}  // namespace freegs::stages
