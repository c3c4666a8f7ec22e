// SPDX-License-Identifier: BSD-3-Clause
// Which exceptions mean that memory ran out.

#include "core/out_of_memory.h"

#include <new>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace freegs {
namespace {

TEST(OutOfMemoryTest, OfTheStandardLibrary) {
  EXPECT_TRUE(IsOutOfMemory(std::bad_alloc()));
  EXPECT_FALSE(IsOutOfMemory(std::length_error("too long")));
}

TEST(OutOfMemoryTest, OfOpenCv) {
  const cv::Exception memory(
      cv::Error::StsNoMem, "Failed to allocate 12 bytes", "f", "alloc.cpp", 73);
  EXPECT_TRUE(IsOutOfMemory(memory)) << memory.what();
  const cv::Exception size(cv::Error::StsBadSize, "size", "f", "a.cpp", 1);
  EXPECT_FALSE(IsOutOfMemory(size)) << size.what();
}

}  // namespace
}  // namespace freegs
