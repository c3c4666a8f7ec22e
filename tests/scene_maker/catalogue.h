// SPDX-License-Identifier: BSD-3-Clause
// The objects that can stand on the table, and the chair.

#ifndef FREEGS_TESTS_SCENE_MAKER_CATALOGUE_H_
#define FREEGS_TESTS_SCENE_MAKER_CATALOGUE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "tests/scene_maker/solid.h"

namespace freegs::scene_maker {

// How an object finds its place.
enum class Place {
  kAlone,   // Anywhere free.
  kBeside,  // Touching the +x side of the object before it, side by side.
  kOnTop,   // Standing on the object before it.
};

struct CatalogueItem {
  std::string label;
  std::string kind;
  Place place = Place::kAlone;

  // In the object's frame: z up, standing on z = 0, around x = y = 0.
  std::vector<Solid> parts;
};

// All kMaxObjects of them, in the order in which scenes take them.
std::vector<CatalogueItem> MakeCatalogue(bool textured, uint32_t seed);

// A wooden chair, 0.86 metres high, whose front points to +x.
CatalogueItem MakeChair(bool textured, uint32_t seed);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_CATALOGUE_H_
