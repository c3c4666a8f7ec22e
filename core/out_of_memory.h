// SPDX-License-Identifier: BSD-3-Clause
// What to do when memory runs out. Code of this project returns errors, but the
// standard library and OpenCV throw then, and nearly every line may be the one.
// So nothing catches this where it happens: it goes up to the program, or to
// the runner of stages, which turns it into OutOfMemoryError().

#ifndef FREEGS_CORE_OUT_OF_MEMORY_H_
#define FREEGS_CORE_OUT_OF_MEMORY_H_

#include <exception>

#include "core/status.h"

namespace freegs {

// Whether an exception says that memory ran out. Code that reads files with
// other libraries, and takes what they throw as a fault of the file, asks
// first:
//
//   } catch (const std::exception& error) {
//     if (IsOutOfMemory(error)) throw;
//     return BadInputError(path.string() + ": " + error.what());
//   }
bool IsOutOfMemory(const std::exception& error);

Status OutOfMemoryError();

}  // namespace freegs

#endif  // FREEGS_CORE_OUT_OF_MEMORY_H_
