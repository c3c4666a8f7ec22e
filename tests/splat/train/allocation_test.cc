// SPDX-License-Identifier: BSD-3-Clause
// A training step between densifications asks for no memory. A program of its
// own, because it counts what goes through malloc: operator new does, and so do
// aligned allocations.

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/splat/training_fixture.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define FREEGS_COUNTS_ALLOCATIONS 1
#else
#define FREEGS_COUNTS_ALLOCATIONS 0
#endif

namespace {

std::atomic<int64_t> num_allocations = 0;

}  // namespace

#if FREEGS_COUNTS_ALLOCATIONS
// The C library's own, which these stand in front of; free stays as it is.
extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

void* malloc(size_t size) {
  ++num_allocations;
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  ++num_allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, size_t size) {
  ++num_allocations;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  ++num_allocations;
  return __libc_memalign(alignment, size);
}
void* memalign(size_t alignment, size_t size) {
  ++num_allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, size_t alignment, size_t size) {
  ++num_allocations;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}
#endif

namespace freegs::splat {
namespace {

// Half of the photos are portraits, and their names are too long for a string
// to hold within itself.
class AllocationTest : public TrainingFixture {
 protected:
  void SetUp() override {
    TrainingFixture::SetUp();
    ThreadPool pool(2);
    for (size_t k = 0; k < views_.size(); ++k) {
      views_[k].name = "a photo with quite a long name, number " +
                       std::to_string(k) + ".png";
      if (k % 2 == 1) {
        views_[k].camera = TestCamera(80, 104);
        photos_[k] = ToU8(RenderView(truth_,
                                     views_[k].camera,
                                     views_[k].cam_from_world,
                                     RenderOptions(),
                                     pool)
                              .color);
      }
      WritePhoto(k);
    }
  }

  // One resolution and SH degree throughout; densifications, but not within the
  // first 100 steps; the state to come back to is renewed on the way. The
  // Gaussians stay where they are, for a view that shows more of them than any
  // before may well need more memory.
  static TrainerOptions SteadyOptions(DensificationMethod method) {
    TrainerOptions options = Options(1000, method);
    options.schedule.resolution_steps = {};
    options.schedule.sh_degree_interval = 0;
    options.schedule.densify_interval = 100;
    options.mini_splatting.blur_split_share = 1.0 / 5000;
    options.snapshot_interval = 5;
    options.exposure.learn = true;
    options.exposure.start = 0;
    LearningRateOptions& rates = options.learning_rates;
    rates.mean_initial = rates.mean_final = 1e-30;
    rates.log_scale = rates.rotation = rates.opacity_logit = 0;
    rates.sh_dc = rates.sh_rest = 0;
    return options;
  }
};

TEST_F(AllocationTest, AStepAllocatesNothing) {
#if !FREEGS_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "allocations cannot be counted with this C library, or "
                  "under a sanitizer";
#endif
  for (const DensificationMethod method :
       {DensificationMethod::kNone,
        DensificationMethod::kGradient,
        DensificationMethod::kMiniSplatting}) {
    for (const int threads : {1, 2}) {
      ThreadPool pool(threads);
      TrainingImages images = Images(pool);
      Trainer trainer(SteadyOptions(method), Start(), 2.0, &images, pool);
      const auto steps = 2 * static_cast<int64_t>(images.size());
      while (trainer.iteration() < steps) ASSERT_TRUE(trainer.Step().ok());
      ASSERT_GT(num_allocations, 0);

      while (trainer.iteration() < 2 * steps) {
        const int64_t before = num_allocations;
        const bool ok = trainer.Step().ok();
        const int64_t after = num_allocations;
        ASSERT_TRUE(ok);
        EXPECT_EQ(after - before, 0)
            << "method " << static_cast<int>(method) << ", " << threads
            << " threads, iteration " << trainer.iteration();
      }
    }
  }
}

}  // namespace
}  // namespace freegs::splat
