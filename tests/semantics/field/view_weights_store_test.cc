// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/view_weights_store.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <sys/resource.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

using splat::RandomSceneModel;
using splat::TestCamera;
using splat::TestPose;

std::vector<View> TestViews(int count) {
  std::vector<View> views(count);
  for (int v = 0; v < count; ++v) {
    views[v].name = "view" + std::to_string(v) + ".jpg";
    views[v].camera = TestCamera(90 + v, 70);
    views[v].cam_from_world = TestPose();
    views[v].cam_from_world.translation[0] += 0.1 * v;
  }
  return views;
}

ViewWeightsOptions OptionsFor(uint64_t max_memory_bytes,
                              const std::filesystem::path& scratch_folder,
                              uint64_t max_scratch_bytes = 1 << 30) {
  ViewWeightsOptions options;
  options.max_side = 60;
  options.max_memory_bytes = max_memory_bytes;
  options.scratch_folder = scratch_folder;
  options.max_scratch_bytes = max_scratch_bytes;
  options.min_free_disk_bytes = 0;
  return options;
}

template <typename T>
bool Same(std::span<const T> a, std::span<const T> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

class ViewWeightsStoreTest : public testing::Test {
 protected:
  StatusOr<ViewWeightsStore> Make(const ViewWeightsOptions& options) const {
    return ViewWeightsStore::Create(
        model_, views_, splat::RenderOptions(), options);
  }

  // All views twice: as computed, then as kept.
  void ExpectRightWeights(ViewWeightsStore& store) {
    for (int round = 0; round < 2; ++round) {
      for (size_t v = 0; v < views_.size(); ++v) {
        const StatusOr<splat::BlendingWeights> computed =
            splat::ComputeBlendingWeights(model_,
                                          views_[v].camera.LimitedTo(60),
                                          views_[v].cam_from_world,
                                          splat::RenderOptions(),
                                          pool_);
        ASSERT_TRUE(computed.ok());
        const splat::WeightMatrix expected = computed.value().matrix();
        const StatusOr<ViewWeights> kept = store.Weights(v, pool_);
        ASSERT_TRUE(kept.ok()) << kept.status().message();
        const splat::WeightMatrix& matrix = kept.value().matrix();
        EXPECT_EQ(matrix.width, store.camera(v).width);
        EXPECT_EQ(matrix.height, store.camera(v).height);
        EXPECT_EQ(matrix.num_gaussians, model_.size());
        EXPECT_TRUE(Same(matrix.pixel_begin, expected.pixel_begin));
        EXPECT_TRUE(Same(matrix.gaussians, expected.gaussians));
        EXPECT_TRUE(Same(matrix.weights, expected.weights));
      }
    }
  }

  // How many views the store hands out again without computing them: two
  // handles held at a time then share their arrays.
  int NumKept(ViewWeightsStore& store) {
    int kept = 0;
    for (size_t v = 0; v < views_.size(); ++v) {
      const ViewWeights once = store.Weights(v, pool_).value();
      const ViewWeights again = store.Weights(v, pool_).value();
      kept += once.matrix().weights.data() == again.matrix().weights.data();
    }
    return kept;
  }

  uint64_t BytesOfView(size_t view) {
    StatusOr<ViewWeightsStore> store = Make(OptionsFor(0, ""));
    return store.value().Weights(view, pool_).value().matrix().num_bytes();
  }

  ThreadPool pool_{2};
  const splat::GaussianModel model_ = RandomSceneModel(300, 0, 3);
  const std::vector<View> views_ = TestViews(4);
  const TemporaryFolder folder_;
};

TEST_F(ViewWeightsStoreTest, KeepsWhatFitsInMemory) {
  StatusOr<ViewWeightsStore> store = Make(OptionsFor(1 << 30, folder_.path()));
  ASSERT_TRUE(store.ok());
  EXPECT_EQ(store->camera(0).width, 60);
  EXPECT_EQ(store->name(3), "view3.jpg");
  EXPECT_EQ(store->num_gaussians(), 300u);
  ExpectRightWeights(*store);
  EXPECT_EQ(NumKept(*store), 4);
}

TEST_F(ViewWeightsStoreTest, MovesTheRestToTheDisk) {
  const uint64_t first = BytesOfView(0);
  StatusOr<ViewWeightsStore> memory_only = Make(OptionsFor(first, ""));
  ASSERT_TRUE(memory_only.ok());
  ExpectRightWeights(*memory_only);
  EXPECT_EQ(NumKept(*memory_only), 1);

  StatusOr<ViewWeightsStore> store = Make(OptionsFor(first, folder_.path()));
  ASSERT_TRUE(store.ok());
  ExpectRightWeights(*store);
  EXPECT_EQ(NumKept(*store), 4);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(ViewWeightsStoreTest, ComputesAgainWhatFitsNowhere) {
  StatusOr<ViewWeightsStore> store = Make(OptionsFor(0, ""));
  ASSERT_TRUE(store.ok());
  ExpectRightWeights(*store);
  EXPECT_EQ(NumKept(*store), 0);

  // One view in memory, one on the disk, two nowhere.
  const uint64_t largest = std::max(
      {BytesOfView(0), BytesOfView(1), BytesOfView(2), BytesOfView(3)});
  StatusOr<ViewWeightsStore> mixed =
      Make(OptionsFor(largest, folder_.path(), largest));
  ASSERT_TRUE(mixed.ok());
  ExpectRightWeights(*mixed);
  EXPECT_EQ(NumKept(*mixed), 2);
}

TEST_F(ViewWeightsStoreTest, LeavesRoomOnTheDisk) {
  ViewWeightsOptions options = OptionsFor(0, folder_.path());
  options.min_free_disk_bytes = uint64_t{1} << 62;
  StatusOr<ViewWeightsStore> store = Make(options);
  ASSERT_TRUE(store.ok());
  ExpectRightWeights(*store);
  EXPECT_EQ(NumKept(*store), 0);
}

TEST_F(ViewWeightsStoreTest, WeightsOutliveTheStore) {
  std::vector<ViewWeights> weights;
  {
    StatusOr<ViewWeightsStore> store =
        Make(OptionsFor(BytesOfView(0), folder_.path()));
    ASSERT_TRUE(store.ok());
    for (const size_t view : {0, 1}) {
      weights.push_back(store->Weights(view, pool_).value());
    }
  }
  for (const ViewWeights& view : weights) {
    EXPECT_EQ(view.matrix().pixel_begin.back(), view.matrix().num_weights());
  }
}

TEST_F(ViewWeightsStoreTest, GoesOnWithoutADiskThatIsFull) {
  StatusOr<ViewWeightsStore> store = Make(OptionsFor(0, folder_.path()));
  ASSERT_TRUE(store.ok());
  // A limit on the size of files stands in for the full disk.
  rlimit old_limit;
  ASSERT_EQ(0, getrlimit(RLIMIT_FSIZE, &old_limit));
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {1 << 12, old_limit.rlim_max};
  ASSERT_EQ(0, setrlimit(RLIMIT_FSIZE, &limit));
  ExpectRightWeights(*store);
  ASSERT_EQ(0, setrlimit(RLIMIT_FSIZE, &old_limit));
  std::signal(SIGXFSZ, old_handler);
  // The disk is not tried again, also when it has room.
  EXPECT_EQ(NumKept(*store), 0);
}

TEST_F(ViewWeightsStoreTest, RefusesWhatCannotWork) {
  const StatusOr<ViewWeightsStore> no_folder =
      Make(OptionsFor(0, folder_ / "missing"));
  ASSERT_FALSE(no_folder.ok());
  EXPECT_NE(no_folder.status().message().find("missing"), std::string::npos);

  for (const int side : {-1, 1 << 20}) {
    ViewWeightsOptions options;
    options.max_side = side;
    EXPECT_EQ(Make(options).status().code(), StatusCode::kInvalidArgument);
  }

  StatusOr<ViewWeightsStore> store = Make(OptionsFor(0, ""));
  ASSERT_TRUE(store.ok());
  EXPECT_EQ(store->Weights(4, pool_).status().code(),
            StatusCode::kInvalidArgument);

  std::vector<View> views = TestViews(1);
  views[0].camera.width = 0;
  StatusOr<ViewWeightsStore> flat = ViewWeightsStore::Create(
      model_, views, splat::RenderOptions(), ViewWeightsOptions());
  ASSERT_TRUE(flat.ok());
  const Status status = flat->Weights(0, pool_).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("view0.jpg"), std::string::npos);
}

}  // namespace
}  // namespace freegs::semantics
