// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/instance_semantics.h"

#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "tests/semantics/clip/color_encoder.h"
#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

// The table around the red ball is taken for a part of the ball. In the
// photographs it has the colour of the table.
TEST(InstanceEncoderTest, RefinedMasksFollowThePhotographs) {
  ThreadPool pool(2);
  const SyntheticGaussians scene = MakeTableScene();
  std::vector<int32_t> labels = scene.truth;
  for (size_t i = 0; i < labels.size(); ++i) {
    const float* mean = scene.model.means.data() + 3 * i;
    if (labels[i] == 0 && std::hypot(mean[0] - 0.5, mean[1] - 0.5) < 0.22) {
      labels[i] = 1;
    }
  }
  const splat::RenderOptions render;
  std::vector<View> views;
  std::vector<ImageU8> photos;
  for (const double heading : {0.3, 0.8, 1.3}) {
    views.push_back(LookAtOrigin(heading));
    views.back().camera = {240, 180, 210, 210, 120, 90};
    photos.push_back(ToU8(splat::RenderView(scene.model,
                                            views.back().camera,
                                            views.back().cam_from_world,
                                            render,
                                            pool)
                              .color));
  }
  const std::vector<float> red = ColorEncoder::Embed({0.8, 0.1, 0.1});
  std::array<float, 2> likeness = {};
  for (const bool refine : {false, true}) {
    ColorEncoder colors;
    InstanceSemanticsOptions options;
    options.refine = refine;
    InstanceEncoder encoder(
        {scene.model,
         views,
         render,
         [&photos](size_t view) -> StatusOr<ImageU8> { return photos[view]; }},
        colors,
        options,
        pool,
        nullptr);
    ASSERT_TRUE(encoder.Look(labels, 5).ok());
    const auto vectors = encoder.Encode(EachAlone(5), [](size_t) {});
    ASSERT_TRUE(vectors.ok()) << vectors.status().message();
    ASSERT_EQ(vectors->vectors.size(), 5 * red.size());
    likeness[refine ? 1 : 0] = std::inner_product(
        red.begin(), red.end(), vectors->vectors.begin() + red.size(), 0.0f);
  }
  EXPECT_GT(likeness[1], likeness[0] + 0.02f);
}

}  // namespace
}  // namespace freegs::semantics
