// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/instance_semantics.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/io/image_io.h"
#include "semantics/crf/dense_crf.h"
#include "semantics/crf/unary_energies.h"
#include "semantics/field/instance_crops.h"
#include "semantics/geometry/directions.h"
#include "semantics/geometry/view_loop.h"

namespace freegs::semantics {
namespace {

// Labels of a view's pixels; -1 for none.
using LabelImage = Image<int32_t>;

// Longest side in pixels at which instances are looked for.
constexpr int kMaxSide = 480;
// Share of a view's pixels below which an instance is too small to be
// recognised there. FreeGS: 300 pixels, whatever the resolution.
constexpr double kMinShare = 0.0005;
// Width of the surroundings that are cut out on each side of an instance, in
// units of its longer side.
constexpr double kMargin = 0.1;
// How sure the rendered labels are before refinement.
constexpr double kLabelConfidence = 0.7;

// Refines labels by a conditional random field that trusts them with
// probability kLabelConfidence. Having no label counts as a label.
StatusOr<LabelImage> RefineLabels(const LabelImage& labels,
                                  const ImageU8& photo,
                                  ThreadPool& pool) {
  std::vector<int32_t> present(labels.data(), labels.data() + labels.size());
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  if (present.size() < 2) return labels;
  ImageU16 numbers(labels.width(), labels.height(), 1);
  for (size_t i = 0; i < labels.size(); ++i) {
    numbers.data()[i] = static_cast<uint16_t>(
        std::lower_bound(present.begin(), present.end(), labels.data()[i]) -
        present.begin());
  }
  FREEGS_ASSIGN_OR_RETURN(
      const ImageF unary,
      UnaryFromLabels(
          numbers, static_cast<int>(present.size()), kLabelConfidence));
  FREEGS_ASSIGN_OR_RETURN(const DenseCrf crf,
                          DenseCrf::Build(ToFloat(photo), {}, pool));
  FREEGS_ASSIGN_OR_RETURN(const DenseCrfResult result, crf.Infer(unary, pool));
  LabelImage refined(labels.width(), labels.height(), 1);
  for (size_t i = 0; i < refined.size(); ++i) {
    refined.data()[i] = present[result.labels.data()[i]];
  }
  return refined;
}

// The instances to cut out of each view.
std::vector<std::vector<int32_t>> InstancesByView(
    std::vector<std::vector<LabelSight>> sights,
    size_t num_views,
    size_t views_per_instance) {
  std::vector<std::vector<int32_t>> result(num_views);
  for (size_t label = 0; label < sights.size(); ++label) {
    for (const LabelSight& sight :
         BestSights(std::move(sights[label]), views_per_instance)) {
      result[sight.view].push_back(static_cast<int32_t>(label));
    }
  }
  return result;
}

// What the encoder makes of the instances that are cut out of one view.
struct ViewVectors {
  std::vector<int32_t> labels;
  std::vector<float> vectors;  // Two for each label.
};

// Leaves out labels that refinement has removed from the view.
StatusOr<ViewVectors> EncodeView(ImageU8 photo,
                                 const LabelImage& map,
                                 const std::vector<int32_t>& wanted,
                                 ClipEncoder& encoder) {
  if (photo.width() != map.width() || photo.height() != map.height()) {
    photo = Resize(photo, map.width(), map.height());
  }
  ViewVectors result;
  for (const int32_t label : wanted) {
    const std::optional<InstanceCrop> crop =
        CropInstance(photo, map, label, kMargin);
    if (!crop) continue;
    result.labels.push_back(label);
    for (const ImageU8* image : {&crop->in_place, &crop->alone}) {
      FREEGS_ASSIGN_OR_RETURN(const std::vector<float> vector,
                              encoder.EncodeImage(*image));
      result.vectors.insert(result.vectors.end(), vector.begin(), vector.end());
    }
  }
  return result;
}

// The mean direction of each instance's vectors, added in the order of views.
InstanceVectors MeanDirections(const std::vector<ViewVectors>& views,
                               int num_instances,
                               int dim) {
  InstanceVectors result;
  result.dim = dim;
  const auto width = static_cast<size_t>(dim);
  std::vector<double> sums(num_instances * width, 0.0);
  for (const ViewVectors& view : views) {
    result.num_crops += view.labels.size();
    for (size_t i = 0; i < view.labels.size(); ++i) {
      const std::span sum =
          std::span(sums).subspan(view.labels[i] * width, width);
      for (const size_t k : {2 * i, 2 * i + 1}) {
        AddDirection(std::span(view.vectors).subspan(k * width, width), 1, sum);
      }
    }
  }
  result.vectors.resize(sums.size());
  for (size_t first = 0; first < sums.size(); first += width) {
    WriteDirection(std::span(sums).subspan(first, width),
                   std::span(result.vectors).subspan(first, width));
  }
  return result;
}

}  // namespace

Status InstanceSemanticsOptions::Check() const {
  if (views_per_instance < 1) {
    return InvalidArgumentError("views_per_instance must be positive");
  }
  return Status();
}

StatusOr<InstanceVectors> EncodeInstances(
    const splat::GaussianModel& model,
    std::span<const View> views,
    const splat::RenderOptions& render,
    std::span<const int32_t> labels,
    int num_instances,
    ViewPhoto photo_of,
    ClipEncoder& encoder,
    const InstanceSemanticsOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    ViewsDone done) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  std::vector<LabelImage> maps;
  std::vector<std::vector<LabelSight>> sights(num_instances);
  for (size_t view = 0; view < views.size(); ++view) {
    const Pinhole camera = views[view].camera.LimitedTo(kMaxSide);
    maps.push_back(splat::RenderLabels(
        model, camera, views[view].cam_from_world, render, pool, labels));
    const auto min_pixels = static_cast<int64_t>(
        kMinShare * static_cast<double>(maps.back().num_pixels()));
    CollectSights(view, maps.back(), min_pixels, sights);
  }
  const std::vector<std::vector<int32_t>> wanted = InstancesByView(
      std::move(sights), views.size(), options.views_per_instance);

  if (options.refine) {
    for (size_t view = 0; view < views.size(); ++view) {
      if (wanted[view].empty()) continue;
      FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, photo_of(view));
      const LabelImage& map = maps[view];
      photo = Resize(photo, map.width(), map.height());
      FREEGS_ASSIGN_OR_RETURN(maps[view], RefineLabels(map, photo, pool));
    }
  }
  std::vector<ViewVectors> encoded(views.size());
  FREEGS_RETURN_IF_ERROR(ForEachView(
      "encoding instances",
      views.size(),
      pool,
      cancellation,
      done,
      [&](size_t view) -> Status {
        if (wanted[view].empty()) return Status();
        FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, photo_of(view));
        FREEGS_ASSIGN_OR_RETURN(
            encoded[view],
            EncodeView(std::move(photo), maps[view], wanted[view], encoder));
        return Status();
      }));
  return MeanDirections(encoded, num_instances, encoder.embedding_dim());
}

}  // namespace freegs::semantics
