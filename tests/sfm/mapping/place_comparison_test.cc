// SPDX-License-Identifier: BSD-3-Clause
// Which photos models have in the same place.

#include "sfm/mapping/place_comparison.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/moved_photos.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

Reconstruction Ring(int photos) { return SyntheticModel(photos, 10); }

TEST(ComparePlaces, TheWorldDoesNotMatter) {
  const Reconstruction ring = Ring(12);
  const PlaceComparison places = ComparePlaces(ring, InAnotherWorld(ring));
  EXPECT_THAT(places.alike, SizeIs(12));
  EXPECT_THAT(places.elsewhere, IsEmpty());
}

TEST(ComparePlaces, FindsWhatMoved) {
  const Reconstruction ring = Ring(12);
  Reconstruction moved = InAnotherWorld(ring);
  MovePhoto(3, &moved);
  MovePhoto(7, &moved);
  TurnPhoto(9, 10, &moved);
  TurnPhoto(10, 2, &moved);  // Little.
  const PlaceComparison places = ComparePlaces(ring, moved);
  EXPECT_THAT(places.elsewhere,
              ElementsAre(PhotoName(3), PhotoName(7), PhotoName(9)));
  EXPECT_THAT(places.alike, SizeIs(9));
}

TEST(ComparePlaces, OnlyCommonPhotosCount) {
  const Reconstruction ring = Ring(12);
  Reconstruction part = InAnotherWorld(ring);
  part.images.resize(5);
  EXPECT_THAT(ComparePlaces(ring, part).alike, SizeIs(5));
  part.images.resize(2);
  const PlaceComparison places = ComparePlaces(ring, part);
  EXPECT_THAT(places.alike, IsEmpty());
  EXPECT_THAT(places.elsewhere, IsEmpty());
}

TEST(ComparePlaces, OnePlaceOfAllTellsNothing) {
  const Reconstruction ring = Ring(5);
  Reconstruction still = ring;
  for (PosedImage& image : still.images) {
    image.cam_from_world.translation.setZero();
  }
  const PlaceComparison places = ComparePlaces(ring, still);
  EXPECT_THAT(places.alike, IsEmpty());
  EXPECT_THAT(places.elsewhere, IsEmpty());
}

TEST(FindConsensus, OneModelHasNoWitness) {
  const Consensus consensus = FindConsensus({Ring(10)});
  EXPECT_EQ(consensus.best, 0u);
  EXPECT_FALSE(consensus.witnessed);
  EXPECT_THAT(consensus.uncertain, IsEmpty());
}

TEST(FindConsensus, WitnessesMakePhotosUncertain) {
  const Reconstruction ring = Ring(10);
  Reconstruction moved = InAnotherWorld(ring);
  EXPECT_TRUE(FindConsensus({ring, moved}).witnessed);
  EXPECT_THAT(FindConsensus({ring, moved}).uncertain, IsEmpty());
  MovePhoto(2, &moved);
  // Others cannot outvote a witness.
  for (const auto& models :
       {std::vector{ring, moved}, std::vector{ring, moved, ring, ring}}) {
    const Consensus consensus = FindConsensus(models);
    EXPECT_EQ(consensus.best, 0u);
    EXPECT_TRUE(consensus.witnessed);
    EXPECT_THAT(consensus.uncertain, ElementsAre(PhotoName(2)));
  }
}

TEST(FindConsensus, AThirdModelOutvotesABadOne) {
  const Reconstruction ring = Ring(10);
  Reconstruction bad = InAnotherWorld(ring);
  for (const size_t i : {1, 2, 5, 7}) MovePhoto(i, &bad);
  Consensus consensus = FindConsensus({bad, ring});
  EXPECT_FALSE(consensus.witnessed);
  EXPECT_EQ(consensus.best, 0u);
  EXPECT_THAT(consensus.uncertain, SizeIs(4));
  consensus = FindConsensus({bad, ring, InAnotherWorld(ring)});
  EXPECT_TRUE(consensus.witnessed);
  EXPECT_EQ(consensus.best, 1u);
  EXPECT_THAT(consensus.uncertain, IsEmpty());
}

TEST(FindConsensus, PhotosThatOthersLackAreNotUncertain) {
  const Reconstruction ring = Ring(10);
  Reconstruction part = InAnotherWorld(ring);
  part.images.resize(6);
  const Consensus consensus = FindConsensus({ring, part});
  EXPECT_EQ(consensus.best, 0u);
  EXPECT_FALSE(consensus.witnessed);
  EXPECT_THAT(consensus.uncertain, IsEmpty());
}

}  // namespace
}  // namespace freegs::sfm
