// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/view_loop.h"

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

namespace freegs::semantics {

Status ForEachView(const std::string& work,
                   size_t num_views,
                   ThreadPool& pool,
                   const CancellationToken* cancellation,
                   ViewsDone done,
                   FunctionRef<Status(size_t view)> body) {
  std::vector<Status> results(num_views);
  std::atomic<bool> failed = false;
  std::mutex mutex;
  size_t num_done = 0;
  pool.ParallelFor(0,
                   static_cast<int64_t>(num_views),
                   1,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t view = first; view < last; ++view) {
                       if (failed || IsCancelled(cancellation)) return;
                       results[view] = body(view);
                       if (!results[view].ok()) failed = true;
                       const std::lock_guard lock(mutex);
                       done(++num_done);
                     }
                   });
  for (const Status& result : results) FREEGS_RETURN_IF_ERROR(result);
  if (IsCancelled(cancellation)) {
    return InterruptedError(work + " was interrupted");
  }
  return Status();
}

}  // namespace freegs::semantics
