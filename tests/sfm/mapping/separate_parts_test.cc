// SPDX-License-Identifier: BSD-3-Clause
// Models taken apart when nothing makes them one.

#include "sfm/mapping/separate_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "sfm/scene/model_io.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/twin_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class SeparatePartsTest : public testing::Test {
 protected:
  explicit SeparatePartsTest(int photos = 23) : scene_(photos) {
    input_.work_folder = folder_ / "work";
    EXPECT_TRUE(CreateFolders(input_.work_folder / "logs").ok());
    for (int i = 0; i < photos; ++i) {
      input_.photos.emplace_back().name = PhotoName(i);
    }
    scene_.WriteMatches((folder_ / "a.db").string());
    // A mapper that makes no models.
    options_.colmap =
        MakeFakeColmap(folder_.path(), {{"FAKE_COLMAP_MODELS", ""}});
  }

  // `others` are models beside the first one.
  StatusOr<SeparatedParts> Run(const Reconstruction& model,
                               const std::vector<Reconstruction>& others = {}) {
    std::vector<Reconstruction> models = {model};
    models.insert(models.end(), others.begin(), others.end());
    FREEGS_ASSIGN_OR_RETURN(ColmapProgram colmap,
                            ColmapProgram::Find(options_.colmap, nullptr));
    const StepContext context{input_, options_, colmap};
    StepRecord record(input_.work_folder, colmap.version());
    AttemptStore store(input_.work_folder, &record);
    return SeparateParts(context, folder_ / "a.db", models, &store);
  }

  TemporaryFolder folder_;
  TwinScene scene_;
  SfmInput input_;
  SfmOptions options_;
};

TEST_F(SeparatePartsTest, RightModelsAreLeftAlone) {
  const auto parts = Run(scene_.Model(false));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  EXPECT_THAT(parts->models, SizeIs(0));
  EXPECT_THAT(parts->attempts, SizeIs(0));
  EXPECT_EQ(parts->groups, 1u);
  EXPECT_GT(parts->score, 0.6);
}

TEST_F(SeparatePartsTest, GluedModelsAreTakenApart) {
  const auto parts = Run(scene_.Model(true));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  ASSERT_THAT(parts->models, SizeIs(2));
  EXPECT_LT(parts->score, 0.4);
  // The second half of 23 has one photo more.
  EXPECT_THAT(parts->models[0].images, SizeIs(12));
  EXPECT_THAT(parts->models[1].images, SizeIs(11));
  ASSERT_THAT(parts->unplaced, SizeIs(11));
  EXPECT_EQ(parts->unplaced[0], PhotoName(0));
  ASSERT_THAT(parts->attempts, SizeIs(1));
  EXPECT_FALSE(parts->attempts[0].kept);
  EXPECT_THAT(parts->attempts[0].why, HasSubstr("groups of 12 and 11 photos"));
  EXPECT_EQ(parts->attempts[0].name, "without look-alike parts");
  EXPECT_EQ(parts->attempts[0].models, 0);
}

TEST_F(SeparatePartsTest, TheModelStaysWhenColmapCrashes) {
  options_.colmap = MakeFakeColmap(
      folder_.path(),
      {{"FAKE_COLMAP_FAIL", "mapper"}, {"FAKE_COLMAP_SIGNAL", "6"}});
  const auto parts = Run(scene_.Model(true));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  EXPECT_THAT(parts->models, SizeIs(2));
  ASSERT_THAT(parts->attempts, SizeIs(1));
  EXPECT_THAT(parts->attempts[0].problem, HasSubstr("signal 6"));
}

TEST_F(SeparatePartsTest, OtherModelsStay) {
  // One is of other photos and larger than any part, one is not of others only.
  Reconstruction elsewhere = SyntheticModel(13, 20);
  for (PosedImage& image : elsewhere.images) image.name = "b/" + image.name;
  Reconstruction mixed = SyntheticModel(4, 20);
  for (size_t i = 1; i < 4; ++i) {
    mixed.images[i].name = "c/" + mixed.images[i].name;
  }
  const auto parts = Run(scene_.Model(true), {mixed, elsewhere});
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  ASSERT_THAT(parts->models, SizeIs(3));
  EXPECT_THAT(parts->models[0].images, SizeIs(12));
  EXPECT_THAT(parts->models[1].images, SizeIs(11));
  EXPECT_EQ(parts->models[2].images[0].name, "b/" + PhotoName(0));
  EXPECT_THAT(parts->unplaced, SizeIs(11));

  const auto right = Run(scene_.Model(false), {elsewhere});
  ASSERT_TRUE(right.ok()) << right.status().message();
  EXPECT_THAT(right->models, SizeIs(0));
}

// Enough photos to keep a part of the model.
class SeparateManyPartsTest : public SeparatePartsTest {
 protected:
  SeparateManyPartsTest() : SeparatePartsTest(51) {}
};

TEST_F(SeparateManyPartsTest, PhotosThatFindNoPlaceAreMappedAnew) {
  // The mapper places no photo again, and makes no model when it begins anew.
  const auto parts = Run(scene_.Model(true));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  EXPECT_THAT(parts->models, SizeIs(2));
  ASSERT_THAT(parts->attempts, SizeIs(2));
  EXPECT_FALSE(parts->attempts[0].kept);
  EXPECT_EQ(parts->attempts[0].name, "misplaced photos once more");
  EXPECT_EQ(parts->attempts[0].problem, "it places no more photos");
  EXPECT_EQ(parts->attempts[0].registered, 26);
  EXPECT_EQ(parts->attempts[1].name, "without look-alike parts");
}

TEST_F(SeparateManyPartsTest, MisplacedPhotosArePlacedOnceMore) {
  const std::filesystem::path right = folder_ / "right";
  ASSERT_TRUE(WriteModel(right, scene_.Model(false)).ok());
  options_.colmap =
      MakeFakeColmap(folder_.path(), {{"FAKE_COLMAP_CONTINUED", right}});
  const auto parts = Run(scene_.Model(true));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  ASSERT_THAT(parts->models, SizeIs(1));
  EXPECT_THAT(parts->models[0].images, SizeIs(51));
  EXPECT_THAT(parts->unplaced, SizeIs(0));
  ASSERT_THAT(parts->attempts, SizeIs(1));
  EXPECT_TRUE(parts->attempts[0].kept);
}

TEST_F(SeparateManyPartsTest, AFailureIsNoVerdict) {
  // Without a folder of this name the fake mapper fails, but not when it begins
  // anew.
  options_.colmap =
      MakeFakeColmap(folder_.path(),
                     {{"FAKE_COLMAP_CONTINUED", folder_ / "nothing"},
                      {"FAKE_COLMAP_MODELS", ""}});
  const auto parts = Run(scene_.Model(true));
  ASSERT_TRUE(parts.ok()) << parts.status().message();
  EXPECT_THAT(parts->models, SizeIs(2));
  ASSERT_THAT(parts->attempts, SizeIs(2));
  EXPECT_THAT(parts->attempts[0].problem, HasSubstr("mapper"));
}

}  // namespace
}  // namespace freegs::sfm
