// SPDX-License-Identifier: BSD-3-Clause

#include "core/out_of_memory.h"

#include <new>
#include <string_view>

namespace freegs {

bool IsOutOfMemory(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return true;
  // cv::Exception with the code StsNoMem. Its text is compared, so that
  // programs that read no image need not load OpenCV.
  return std::string_view(error.what()).find("(-4:Insufficient memory)") !=
         std::string_view::npos;
}

Status OutOfMemoryError() {
  return InternalError(
      "out of memory; close other programs, or try smaller images or fewer "
      "threads (--threads)");
}

}  // namespace freegs
