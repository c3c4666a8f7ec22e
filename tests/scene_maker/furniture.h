// SPDX-License-Identifier: BSD-3-Clause
// Stools, chairs, tables and lamps of random sizes and colours. Each has parts
// of several colours that hardly look as if they belonged together. Boxes and
// balls stand among them.

#ifndef FREEGS_TESTS_SCENE_MAKER_FURNITURE_H_
#define FREEGS_TESTS_SCENE_MAKER_FURNITURE_H_

#include <string>

#include "core/random.h"
#include "core/status.h"
#include "tests/scene_maker/catalogue.h"
#include "tests/scene_maker/scene.h"

namespace freegs::scene_maker {

// kind: stool, chair, table, lamp, box or ball.
CatalogueItem RandomFurniture(const std::string& kind, RandomStream* random);

// Puts up to options.objects pieces on the floor, the kinds by turns. None
// touch. Pieces that find no room are left out, and those with the label of
// another one. Error: kInternal if nothing is left.
Status AddFurniture(Scene* scene);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_FURNITURE_H_
