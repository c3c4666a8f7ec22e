// SPDX-License-Identifier: BSD-3-Clause
// Procedural surfaces for the solids of a scene. They carry detail at several
// scales that does not repeat, as feature matching needs.

#ifndef FREEGS_TESTS_SCENE_MAKER_TEXTURES_H_
#define FREEGS_TESTS_SCENE_MAKER_TEXTURES_H_

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "tests/scene_maker/solid.h"

namespace freegs::scene_maker {

// Linear-light colour of an sRGB value 0xRRGGBB.
Color FromSrgb(uint32_t rgb);

// Lengths below are metres. `seed` varies the details.

Texture Plain(Color color);

// Planks of `plank_width` along the local x axis (across y or z), with grain.
Texture WoodPlanks(Color light, Color dark, float plank_width, uint32_t seed);

// A box of wooden slats in a frame, with a stencil on its +-y faces.
Texture Crate(Eigen::Vector3f half_extents, uint32_t seed);

// Running-bond bricks on every face.
Texture Bricks(uint32_t seed);

// A book lying flat: printed covers on +-z, spine on -x, pages elsewhere.
Texture Book(Eigen::Vector3f half_extents,
             Color cover,
             Color accent,
             uint32_t seed);

// A ball with `stripes` pairs of meridian stripes and scattered prints.
Texture StripedBall(Color first, Color second, int stripes, uint32_t seed);

// Glazed colour with painted blossoms; the upper and lower rims plain.
Texture Blossoms(Color base, Color petals, Color heart, uint32_t seed);

// White porcelain with irregular patches of a glaze colour.
Texture Porcelain(Color glaze, uint32_t seed);

// A ring: dough below, icing with sprinkles above.
Texture Doughnut(Color icing, uint32_t seed);

// Bands around z with grime, of a cone `height` tall.
Texture BandedCone(Color base, Color band, float height, uint32_t seed);

// Squares of `size` in two colours, each with its own random sign.
Texture Checks(Color first, Color second, float size, uint32_t seed);

// A tin: printed paper label with lines of random letters, metal lids.
Texture TinCan(Color label, Color print, float half_height, uint32_t seed);

// Veined stone.
Texture Marble(Color base, Color vein, uint32_t seed);

// The floor: boards and a round rug of `rug_radius` about the local z axis.
Texture FloorWithRug(float rug_radius, uint32_t seed);

// A wall of plaster above wainscot, with framed pictures; or one of
// bookshelves. `half_width` and `half_height` are those of the wall in its uv
// coordinates.
Texture PictureWall(Color paint,
                    float half_width,
                    float half_height,
                    uint32_t seed);
Texture BookShelves(float half_width, float half_height, uint32_t seed);

// Square tiles of `size` with grout between them. They carry the same painting,
// to the last speck.
Texture Tiles(float size, uint32_t seed);

// One random bit of a made-up 5 x 7 letter; x in 0..4, y in 0..6.
bool LetterBit(uint32_t letter, int x, int y);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_TEXTURES_H_
