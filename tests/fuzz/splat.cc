// SPDX-License-Identifier: BSD-3-Clause
// Files of Gaussians.

#include "core/io/files.h"
#include "core/io/gzip.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/spz_format.h"
#include "splat/train/checkpoint.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

splat::GaussianModel SmallModel(int sh_degree) {
  splat::GaussianModel model;
  model.sh_degree = sh_degree;
  model.Resize(3);
  for (size_t i = 0; i < model.means.size(); ++i) {
    model.means[i] = 0.5f * static_cast<float>(i);
  }
  return model;
}

constexpr size_t kHashDigits = 32;

}  // namespace

Reader Ply() {
  return {[](std::string_view bytes) {
            const auto model = splat::ParsePly(bytes);
            if (model.ok()) {
              Require(splat::ParsePly(
                          splat::SerializePly(model->model, model->offset))
                          .ok());
            }
          },
          [] {
            return std::vector<std::string>{
                splat::SerializePly(SmallModel(0)),
                splat::SerializePly(SmallModel(1)),
                "ply\nformat ascii 1.0\ncomment x\nelement face 1\n"
                "property list uchar int vertex_indices\nelement vertex 1\n"
                "property float x\nproperty double y\nproperty float z\n"
                "property float f_dc_0\nproperty float f_dc_1\n"
                "property float f_dc_2\nproperty float opacity\n"
                "property float scale_0\nproperty float scale_1\n"
                "property float scale_2\nproperty float rot_0\n"
                "property float rot_1\nproperty float rot_2\n"
                "property float rot_3\nend_header\n3 0 0 0\n"
                "1 2 3 0 0 0 4 -1 -1 -1 1 0 0 0\n"};
          }};
}

// A fuzzer does not guess what unpacks, so the program packs its bytes.
Reader Spz() {
  return {[](std::string_view bytes) {
            (void)splat::ParseSpz(bytes);
            const auto model = splat::ParseSpz(Gzip(bytes).value());
            if (model.ok()) Require(splat::SerializeSpz(*model).ok());
          },
          [] {
            std::vector<std::string> seeds;
            for (const int degree : {0, 1}) {
              const std::string packed =
                  splat::SerializeSpz(SmallModel(degree)).value();
              seeds.push_back(packed);
              seeds.push_back(Gunzip(packed, 1 << 20).value());
            }
            return seeds;
          }};
}

Reader TrainingCheckpoint() {
  return {[](std::string_view bytes) {
            const auto checkpoint =
                splat::ParseCheckpoint(std::string(bytes) + HashBytes(bytes));
            if (!checkpoint.ok()) return;
            const std::string written = splat::SerializeCheckpoint(*checkpoint);
            Require(splat::ParseCheckpoint(written).ok());
          },
          [] {
            splat::TrainingCheckpoint checkpoint;
            checkpoint.iteration = 12;
            checkpoint.model = SmallModel(1);
            checkpoint.adam.first_moments = SmallModel(1);
            checkpoint.adam.second_moments = SmallModel(1);
            checkpoint.history.milestones.resize(1);
            checkpoint.history.recoveries.push_back({7, "NaN", 5, 0.5});
            checkpoint.history.exposure_choice.emplace();
            checkpoint.history.colors.entries.resize(2);
            checkpoint.history.last_good.emplace();
            checkpoint.history.last_good->model = SmallModel(0);
            checkpoint.history.last_good->colors = checkpoint.history.colors;
            checkpoint.facts = {{"seed", "1"}};
            std::string content = splat::SerializeCheckpoint(checkpoint);
            content.resize(content.size() - kHashDigits);
            return std::vector<std::string>{content};
          }};
}

}  // namespace freegs::fuzz
