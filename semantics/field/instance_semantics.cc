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
// A view of more labels is not refined: the field holds three numbers for each
// label and pixel.
constexpr size_t kMostRefinedLabels = 500;

Status Interrupted() {
  return InterruptedError("encoding instances was interrupted");
}

// Refines labels by a conditional random field that trusts them with
// probability kLabelConfidence. Having no label counts as a label.
StatusOr<LabelImage> RefineLabels(const LabelImage& labels,
                                  const ImageU8& photo,
                                  ThreadPool& pool) {
  std::vector<int32_t> present(labels.data(), labels.data() + labels.size());
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  if (present.size() < 2 || present.size() > kMostRefinedLabels) return labels;
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

// How much of a group a view shows, from what it shows of each label.
LabelSight SightOf(size_t view,
                   std::span<const LabelSight> of_label,
                   std::span<const int32_t> group) {
  LabelSight sight{.view = view};
  for (const int32_t label : group) {
    sight.pixels += of_label[label].pixels;
    sight.cut |= of_label[label].cut;
  }
  return sight;
}

// The map with the first label of a group in place of the others.
LabelImage AsOne(const LabelImage& map, std::span<const int32_t> group) {
  LabelImage joined = map;
  for (size_t i = 0; i < joined.size(); ++i) {
    int32_t& label = joined.data()[i];
    if (std::find(group.begin(), group.end(), label) != group.end()) {
      label = group[0];
    }
  }
  return joined;
}

// What the encoder makes of the groups that are cut out of one view.
struct ViewVectors {
  std::vector<size_t> groups;
  std::vector<float> vectors;  // Two for each group.
};

// Leaves out groups that refinement has removed from the view.
StatusOr<ViewVectors> EncodeView(ImageU8 photo,
                                 const LabelImage& map,
                                 std::span<const std::vector<int32_t>> groups,
                                 const std::vector<size_t>& wanted,
                                 ClipEncoder& encoder) {
  if (photo.width() != map.width() || photo.height() != map.height()) {
    photo = Resize(photo, map.width(), map.height());
  }
  ViewVectors result;
  for (const size_t g : wanted) {
    const std::vector<int32_t>& group = groups[g];
    const std::optional<InstanceCrop> crop =
        group.size() == 1
            ? CropInstance(photo, map, group[0], kMargin)
            : CropInstance(photo, AsOne(map, group), group[0], kMargin);
    if (!crop) continue;
    result.groups.push_back(g);
    for (const ImageU8* image : {&crop->in_place, &crop->alone}) {
      FREEGS_ASSIGN_OR_RETURN(const std::vector<float> vector,
                              encoder.EncodeImage(*image));
      result.vectors.insert(result.vectors.end(), vector.begin(), vector.end());
    }
  }
  return result;
}

// The mean direction of each group's vectors, added in the order of views.
InstanceVectors MeanDirections(const std::vector<ViewVectors>& views,
                               size_t num_groups,
                               int dim) {
  InstanceVectors result;
  result.dim = dim;
  const auto width = static_cast<size_t>(dim);
  std::vector<double> sums(num_groups * width, 0.0);
  for (const ViewVectors& view : views) {
    result.num_crops += view.groups.size();
    for (size_t i = 0; i < view.groups.size(); ++i) {
      const std::span sum =
          std::span(sums).subspan(view.groups[i] * width, width);
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

Status InstanceEncoder::Look(std::span<const int32_t> labels,
                             int num_instances) {
  FREEGS_RETURN_IF_ERROR(options_.Check());
  maps_.clear();
  sights_.assign(photos_.views.size(), {});
  refined_.assign(photos_.views.size(), 0);
  for (size_t view = 0; view < photos_.views.size(); ++view) {
    if (IsCancelled(cancellation_)) return Interrupted();
    const View& seen = photos_.views[view];
    maps_.push_back(splat::RenderLabels(photos_.model,
                                        seen.camera.LimitedTo(kMaxSide),
                                        seen.cam_from_world,
                                        photos_.render,
                                        pool_,
                                        labels));
    sights_[view] = SightsOf(view, maps_.back(), num_instances);
  }
  return Status();
}

Status InstanceEncoder::Refine(size_t view) {
  if (!options_.refine || refined_[view] != 0) return Status();
  refined_[view] = 1;
  LabelImage& map = maps_[view];
  FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, photos_.photo_of(view));
  photo = Resize(photo, map.width(), map.height());
  FREEGS_ASSIGN_OR_RETURN(map, RefineLabels(map, photo, pool_));
  return Status();
}

StatusOr<InstanceVectors> InstanceEncoder::Encode(
    std::span<const std::vector<int32_t>> groups, ViewsDone done) {
  std::vector<std::vector<size_t>> wanted(maps_.size());
  for (size_t g = 0; g < groups.size(); ++g) {
    std::vector<LabelSight> sights;
    for (size_t view = 0; view < maps_.size(); ++view) {
      const LabelSight sight = SightOf(view, sights_[view], groups[g]);
      const auto min_pixels = static_cast<int64_t>(
          kMinShare * static_cast<double>(maps_[view].num_pixels()));
      if (sight.pixels >= std::max<int64_t>(1, min_pixels)) {
        sights.push_back(sight);
      }
    }
    for (const LabelSight& sight :
         BestSights(std::move(sights),
                    static_cast<size_t>(options_.views_per_instance))) {
      wanted[sight.view].push_back(g);
    }
  }
  for (size_t view = 0; view < maps_.size(); ++view) {
    if (IsCancelled(cancellation_)) return Interrupted();
    if (!wanted[view].empty()) FREEGS_RETURN_IF_ERROR(Refine(view));
  }
  std::vector<ViewVectors> encoded(maps_.size());
  FREEGS_RETURN_IF_ERROR(ForEachView(
      "encoding instances",
      maps_.size(),
      pool_,
      cancellation_,
      done,
      [&](size_t view) -> Status {
        if (wanted[view].empty()) return Status();
        FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, photos_.photo_of(view));
        FREEGS_ASSIGN_OR_RETURN(
            encoded[view],
            EncodeView(
                std::move(photo), maps_[view], groups, wanted[view], encoder_));
        return Status();
      }));
  return MeanDirections(encoded, groups.size(), encoder_.embedding_dim());
}

std::vector<std::vector<int32_t>> EachAlone(int num_instances) {
  std::vector<std::vector<int32_t>> groups;
  for (int32_t label = 0; label < num_instances; ++label) {
    groups.push_back({label});
  }
  return groups;
}

}  // namespace freegs::semantics
