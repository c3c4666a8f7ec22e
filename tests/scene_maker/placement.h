// SPDX-License-Identifier: BSD-3-Clause
// Items of the catalogue become objects of a scene.

#ifndef FREEGS_TESTS_SCENE_MAKER_PLACEMENT_H_
#define FREEGS_TESTS_SCENE_MAKER_PLACEMENT_H_

#include <vector>

#include <Eigen/Core>

#include "tests/scene_maker/catalogue.h"
#include "tests/scene_maker/scene.h"
#include "tests/scene_maker/solid.h"

namespace freegs::scene_maker {

// Stands an item at `origin` (world, metres) as the object `id`, adds its parts
// to the solids, and measures it. rotation: world_from_item.
void PutDown(const CatalogueItem& item,
             const Eigen::Matrix3d& rotation,
             const Eigen::Vector3d& origin,
             int id,
             SceneObject* object,
             std::vector<Solid>* solids);

// Radius of the circle around an item's axis that holds it (metres).
double ItemRadius(const CatalogueItem& item);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_PLACEMENT_H_
