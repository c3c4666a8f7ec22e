// SPDX-License-Identifier: BSD-3-Clause
// A picture of the model while it is trained, for those who look on.

#ifndef FREEGS_STAGES_RECONSTRUCT_TRAINING_PREVIEW_H_
#define FREEGS_STAGES_RECONSTRUCT_TRAINING_PREVIEW_H_

#include <filesystem>
#include <functional>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

struct TrainingPreviewOptions {
  // The JPEG file; empty: no pictures.
  std::filesystem::path file;

  int max_side = 640;             // Longest side of the picture in pixels.
  double min_interval = 5;        // Seconds between two pictures.
  double max_time_share = 0.005;  // Share of all time that pictures may take.
};

// Renders one view again and again. The model is only read, so that a training
// that is looked at has the result of one that is not.
class TrainingPreview {
 public:
  using Clock = std::function<double()>;  // Seconds; never goes back.

  // `view` is at the photograph's own size. Without a clock it uses the steady
  // clock.
  TrainingPreview(TrainingPreviewOptions options,
                  const View& view,
                  const splat::RenderOptions& render,
                  Clock clock = {});

  // Whether the time for another picture has come.
  bool Due() const;

  // Writes a picture. A disk that is full is no error. The next picture comes
  // the later the longer this one took. `also` is called within that time: what
  // else shall be written as often.
  void Write(const splat::GaussianModel& model,
             ThreadPool& pool,
             const std::function<void()>& also);

 private:
  const TrainingPreviewOptions options_;
  View view_;
  const splat::RenderOptions render_;
  const Clock clock_;
  double next_ = 0;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_TRAINING_PREVIEW_H_
