// SPDX-License-Identifier: BSD-3-Clause
// What a run says of other holdout photos than those of the run before.

#include "stages/ingest/ingest_holdout.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/stages/ingest_test_fixture.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class IngestHoldoutTest : public IngestTestFixture {
 protected:
  // What the runner does with the output of a stage.
  void Finish() {
    fs::remove_all(workspace_.path() / "ingest");
    fs::rename(workspace_.path() / "ingest.partial",
               workspace_.path() / "ingest");
  }
};

TEST_F(IngestHoldoutTest, APhotoMoreShiftsWhichOnesAreHeldOut) {
  WritePhotos(9);
  ASSERT_TRUE(Run().ok());
  Finish();
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, IsEmpty());
  Finish();
  fs::rename(images_.path() / "img8.jpg", images_.path() / "a.jpg");
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("not those of the last run")));
}

}  // namespace
}  // namespace freegs::stages
