// SPDX-License-Identifier: BSD-3-Clause
// Work on many photographs that is done on several at once.

#ifndef FREEGS_SEMANTICS_GEOMETRY_VIEW_LOOP_H_
#define FREEGS_SEMANTICS_GEOMETRY_VIEW_LOOP_H_

#include <cstddef>
#include <string>

#include "core/cancellation.h"
#include "core/function_ref.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Returns the photograph of a view, RGB. May be called on several threads at
// once.
using ViewPhoto = FunctionRef<StatusOr<ImageU8>(size_t view)>;

// Called after each view with the number of views that are done.
using ViewsDone = FunctionRef<void(size_t count)>;

// Calls body(view) for each view 0 .. num_views - 1, on all threads of the
// pool, and `done` with the number of views that are ready, never on two
// threads at once. The body must not use the pool. After an error or when
// cancelled (`cancellation` may be null), views that have not begun are left
// out. Returns the error of the first view in their order that has one, or
// kInterrupted with the name of the work.
Status ForEachView(const std::string& work,
                   size_t num_views,
                   ThreadPool& pool,
                   const CancellationToken* cancellation,
                   ViewsDone done,
                   FunctionRef<Status(size_t view)> body);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_VIEW_LOOP_H_
