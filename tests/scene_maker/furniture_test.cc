// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/furniture.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/scene_maker/free_space.h"

namespace freegs::scene_maker {
namespace {

SceneMakerOptions Furniture(uint64_t seed) {
  SceneMakerOptions options;
  options.subject = Subject::kFurniture;
  options.seed = seed;
  return options;
}

TEST(Furniture, PiecesStandOnTheFloorAndApart) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const auto scene = BuildScene(Furniture(seed));
    ASSERT_TRUE(scene.ok()) << seed << ": " << scene.status().message();
    EXPECT_GE(scene->objects.size(), 4u) << seed;
    std::set<std::string> labels;
    for (const SceneObject& object : scene->objects) {
      EXPECT_TRUE(labels.insert(object.label).second) << object.label;
      EXPECT_EQ(object.id, static_cast<int>(labels.size()));
      EXPECT_NEAR(object.aabb.min.z(), 0, 1e-3) << object.label;
      EXPECT_LT(object.aabb.max.head<2>().cwiseAbs().maxCoeff(), 1.2);
      for (const SceneObject& other : scene->objects) {
        if (other.id == object.id) continue;
        // Circles around them are placed 6 cm apart.
        EXPECT_GT(FreeSpace(*scene, object.id, other.id), 0.058)
            << seed << ": " << object.label << " and " << other.label;
      }
    }
  }
}

TEST(Furniture, PiecesHaveParts) {
  RandomStream random(3, 1);
  for (const char* kind : {"stool", "chair", "table", "lamp"}) {
    const CatalogueItem item = RandomFurniture(kind, &random);
    EXPECT_GE(item.parts.size(), 3u) << kind;
    EXPECT_TRUE(item.label.ends_with(std::string(" ") + kind)) << item.label;
  }
  EXPECT_EQ(RandomFurniture("box", &random).parts.size(), 1u);
}

TEST(Furniture, TheSameSeedGivesTheSameScene) {
  const Scene a = *BuildScene(Furniture(7));
  const Scene b = *BuildScene(Furniture(7));
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].aabb.min, b.objects[i].aabb.min);
    EXPECT_EQ(a.objects[i].label, b.objects[i].label);
  }
}

}  // namespace
}  // namespace freegs::scene_maker
