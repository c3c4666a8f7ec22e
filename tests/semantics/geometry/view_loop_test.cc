// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/view_loop.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(ViewLoopTest, DoesEveryViewOnceAndCounts) {
  for (const int threads : {1, 4}) {
    ThreadPool pool(threads);
    std::vector<int> visits(37, 0);
    std::vector<size_t> counts;
    const Status status = ForEachView(
        "counting",
        visits.size(),
        pool,
        nullptr,
        [&](size_t count) { counts.push_back(count); },
        [&](size_t view) {
          ++visits[view];
          return Status();
        });
    EXPECT_TRUE(status.ok());
    EXPECT_EQ(visits, std::vector<int>(37, 1));
    ASSERT_EQ(counts.size(), 37u);
    for (size_t i = 0; i < counts.size(); ++i) EXPECT_EQ(counts[i], i + 1);
  }
}

TEST(ViewLoopTest, ReturnsAnErrorAndBeginsNothingAfterIt) {
  ThreadPool pool(1);
  int visits = 0;
  const Status status = ForEachView(
      "counting",
      10,
      pool,
      nullptr,
      [](size_t) {},
      [&](size_t view) {
        ++visits;
        return view == 3 ? BadInputError("view 3") : Status();
      });
  EXPECT_EQ(status.message(), "view 3");
  EXPECT_EQ(visits, 4);
}

TEST(ViewLoopTest, StopsWhenCancelled) {
  ThreadPool pool(2);
  CancellationToken cancellation;
  std::atomic<int> visits = 0;
  const Status status = ForEachView(
      "counting",
      1000,
      pool,
      &cancellation,
      [](size_t) {},
      [&](size_t) {
        const int visit = ++visits;
        if (visit == 5) cancellation.Cancel();
        // The other thread may be here before the flag is set. It goes on only
        // when it can see it.
        while (visit > 5 && !cancellation.cancelled()) {
          std::this_thread::yield();
        }
        return Status();
      });
  EXPECT_EQ(status.code(), StatusCode::kInterrupted);
  EXPECT_EQ(status.message(), "counting was interrupted");
  EXPECT_LE(visits, 6);  // The fifth, and one of the other thread.
}

}  // namespace
}  // namespace freegs::semantics
