// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_preview.h"

#include <algorithm>
#include <utility>

#include "core/cancellation.h"
#include "core/io/image_io.h"

namespace freegs::stages {

TrainingPreview::TrainingPreview(TrainingPreviewOptions options,
                                 const View& view,
                                 const splat::RenderOptions& render,
                                 Clock clock)
    : options_(std::move(options)),
      view_(view),
      render_(render),
      clock_(clock ? std::move(clock) : SteadySeconds),
      next_(clock_()) {
  view_.camera = view_.camera.LimitedTo(options_.max_side);
}

bool TrainingPreview::Due() const {
  return !options_.file.empty() && clock_() >= next_;
}

void TrainingPreview::Write(const splat::GaussianModel& model,
                            ThreadPool& pool,
                            const std::function<void()>& also) {
  const double begin = clock_();
  const splat::RenderedView picture = splat::RenderView(
      model, view_.camera, view_.cam_from_world, render_, pool);
  (void)WriteImage(options_.file, ToU8(picture.color));
  also();
  const double end = clock_();
  next_ = begin + std::max(options_.min_interval,
                           (end - begin) / options_.max_time_share);
}

}  // namespace freegs::stages
