// SPDX-License-Identifier: BSD-3-Clause

#ifndef FREEGS_TESTS_SCENE_MAKER_THING_BUILDER_H_
#define FREEGS_TESTS_SCENE_MAKER_THING_BUILDER_H_

#include <utility>

#include <Eigen/Core>

#include "core/random.h"
#include "tests/scene_maker/catalogue.h"
#include "tests/scene_maker/solid.h"

namespace freegs::scene_maker {

// Builds a thing part by part.
class ThingBuilder {
 public:
  explicit ThingBuilder(RandomStream* random) : random_(random) {}

  void Part(Shape shape,
            const Eigen::Vector3d& size,
            const Eigen::Vector3d& centre,
            Texture texture,
            const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
    Solid solid;
    solid.shape = shape;
    solid.size = size;
    solid.centre = centre;
    solid.rotation = rotation;
    solid.texture = std::move(texture);
    solid.gloss = static_cast<float>(0.3 * random_->Uniform());
    item.parts.push_back(std::move(solid));
  }

  CatalogueItem item;

 private:
  RandomStream* random_;
};

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_THING_BUILDER_H_
