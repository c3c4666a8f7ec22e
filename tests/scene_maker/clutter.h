// SPDX-License-Identifier: BSD-3-Clause
// Scenes that all differ, from which the evidence for instances is learnt:
// things of random shapes, materials and colours that stand, lie, lean on and
// touch one another, on a table in a room whose surfaces are random too.

#ifndef FREEGS_TESTS_SCENE_MAKER_CLUTTER_H_
#define FREEGS_TESTS_SCENE_MAKER_CLUTTER_H_

#include <cstdint>
#include <string>

#include "core/random.h"
#include "core/status.h"
#include "tests/scene_maker/catalogue.h"
#include "tests/scene_maker/scene.h"

namespace freegs::scene_maker {

inline double Between(double low, double high, RandomStream* random) {
  return low + (high - low) * random->Uniform();
}

// Colours as things have them: greys and pale ones as often as strong ones.
Color RandomColor(RandomStream* random);

// One colour with the faint blotches that all real surfaces have. scale:
// metres.
Texture Worn(Color color, float strength, float scale, uint32_t seed);

// Fur of one or two colours, for a part of about `size` metres.
Texture RandomFur(double size, RandomStream* random);

// A material of any kind and colours, for a part of about `size` metres.
Texture RandomMaterial(double size, RandomStream* random);

// A thing at most about `reach` metres from its axis: a sheet, a box, a ball,
// a bottle, a cup, a figure of several colours, a plant of thin leaves, ...
// `flat` asks for a sheet, a mat or a book, on which others can stand.
CatalogueItem RandomThing(double reach, bool flat, RandomStream* random);

// How large table, things and distances of this scene are, relative to those of
// a table of small things: 1, or up to 2.4, where the table is rather a carpet
// between the walls, on which pieces of furniture stand.
double ClutterScale(uint64_t seed);

// Walls and floor of random materials, and for clutter a table.
void AddRandomRoom(Scene* scene);

// About options.objects things on the table: some flat, some on top of others,
// some touching. Things that find no room are left out, but never all.
Status AddClutter(Scene* scene);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_CLUTTER_H_
