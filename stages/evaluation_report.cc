// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation_report.h"

#include <cstdio>
#include <utility>

namespace freegs::stages {
namespace {

using nlohmann::json;

json OrNull(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

json VectorJson(const Eigen::Vector3d& v) {
  return json::array({v.x(), v.y(), v.z()});
}

json ViewsJson(const std::optional<ImageQuality>& quality) {
  json views = json::array();
  if (!quality) return views;
  for (const ImageQuality::ViewQuality& view : quality->views) {
    views.push_back(
        {{"name", view.name}, {"psnr", view.psnr}, {"ssim", view.ssim}});
  }
  return views;
}

json ObjectJson(const ObjectResult& object) {
  json box = nullptr;
  if (object.box) {
    box = {{"min", VectorJson(object.box->min)},
           {"max", VectorJson(object.box->max)}};
  }
  return {
      {"id", object.id},
      {"label", object.label},
      {"views", object.num_views},
      {"instance", object.instance < 0 ? json() : json(object.instance + 1)},
      {"instance_iou", OrNull(object.instance_iou)},
      {"click_iou", OrNull(object.click_iou)},
      {"text_iou", nullptr},
      {"box_iou", OrNull(object.box_iou)},
      {"box", box}};
}

// Fixed-point text, or a dash.
std::string Text(const std::optional<double>& value, int digits) {
  if (!value) return "-";
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, *value);
  return text;
}

void Row(std::ostream& out,
         const std::string& name,
         const std::string& value,
         const std::string& note) {
  char text[64];
  std::snprintf(
      text, sizeof(text), "  %-18s %10s  ", name.c_str(), value.c_str());
  out << text << note << "\n";
}

void PrintObjects(const InstanceQuality& quality, std::ostream& out) {
  char text[128];
  std::snprintf(text,
                sizeof(text),
                "\n  %-24s %8s %8s %8s %8s\n",
                "object",
                "instance",
                "mask IoU",
                "click",
                "box IoU");
  out << text;
  for (const ObjectResult& object : quality.objects) {
    std::snprintf(
        text,
        sizeof(text),
        "  %-24.24s %8s %8s %8s %8s\n",
        object.label.c_str(),
        object.instance < 0 ? "-" : std::to_string(object.instance + 1).c_str(),
        Text(object.instance_iou, 3).c_str(),
        Text(object.click_iou, 3).c_str(),
        Text(object.box_iou, 3).c_str());
    out << text;
  }
}

}  // namespace

json ToJson(const EvaluationReport& report) {
  const std::optional<ImageQuality>& quality =
      report.test ? report.test : report.holdout;
  json result = {
      {"psnr", quality ? json(quality->psnr) : json()},
      {"ssim", quality ? json(quality->ssim) : json()},
      {"psnr_views",
       report.test ? json("test")
       : quality   ? json("holdout")
                   : json()},
      {"holdout_psnr", report.holdout ? json(report.holdout->psnr) : json()},
      {"holdout_ssim", report.holdout ? json(report.holdout->ssim) : json()},
      {"pose_rotation_deg", nullptr},
      {"pose_translation", nullptr},
      {"instance_miou", nullptr},
      {"click_miou", nullptr},
      // Nothing answers to words yet.
      {"text_miou", nullptr},
      {"text_mbiou", nullptr},
      {"box_miou", nullptr},
      {"box_recall25", nullptr},
      {"box_recall50", nullptr},
      {"num_gaussians", report.num_gaussians},
      {"registered", report.num_photos},
      {"workspace", report.workspace},
      {"gt", report.truth.empty() ? json() : json(report.truth)},
      {"test_views", ViewsJson(report.test)},
      {"holdout_views", ViewsJson(report.holdout)},
      {"objects", json::array()},
  };
  if (report.poses) {
    const sfm::PoseAlignment& poses = *report.poses;
    result["pose_rotation_deg"] = poses.median_rotation_deg;
    result["pose_rotation_deg_max"] = poses.max_rotation_deg;
    result["pose_translation"] = poses.median_centre;
    result["pose_translation_max"] = poses.max_centre;
    result["pose_translation_relative"] =
        report.camera_extent > 0
            ? json(poses.median_centre / report.camera_extent)
            : json();
    result["poses_compared"] = poses.residuals.size();
    result["poses_true"] = report.num_true_poses;
    result["gt_units_per_scene_unit"] = poses.target_from_source.scale;
  }
  if (report.instances) {
    const InstanceQuality& instances = *report.instances;
    result["instance_miou"] = OrNull(instances.instance_miou);
    result["click_miou"] = OrNull(instances.click_miou);
    result["box_miou"] = OrNull(instances.box_miou);
    result["box_recall25"] = OrNull(instances.box_recall25);
    result["box_recall50"] = OrNull(instances.box_recall50);
    for (const ObjectResult& object : instances.objects) {
      result["objects"].push_back(ObjectJson(object));
    }
  }
  return result;
}

void PrintTable(const EvaluationReport& report, std::ostream& out) {
  const auto views = [](const std::optional<ImageQuality>& quality) {
    return std::to_string(quality->views.size()) + " views";
  };
  out << report.workspace << ": " << report.num_photos << " photos, "
      << report.num_gaussians << " Gaussians\n";
  if (report.holdout) {
    const std::string note = "dB, holdout photos, " + views(report.holdout);
    Row(out, "holdout PSNR", Text(report.holdout->psnr, 2), note);
    Row(out, "holdout SSIM", Text(report.holdout->ssim, 4), "");
  }
  if (report.test) {
    Row(out,
        "test PSNR",
        Text(report.test->psnr, 2),
        "dB, photos never given, " + views(report.test));
    Row(out, "test SSIM", Text(report.test->ssim, 4), "");
  }
  if (!report.holdout && !report.test) {
    out << "  no holdout photos and no photos of test views: no PSNR\n";
  }
  if (report.poses) {
    const sfm::PoseAlignment& poses = *report.poses;
    Row(out,
        "pose rotation",
        Text(poses.median_rotation_deg, 4),
        "degrees, median of " + std::to_string(poses.residuals.size()) +
            " cameras; largest " + Text(poses.max_rotation_deg, 4));
    Row(out,
        "pose translation",
        Text(poses.median_centre, 5),
        "units of the truth, median; largest " + Text(poses.max_centre, 5));
  }
  if (report.instances) {
    const InstanceQuality& instances = *report.instances;
    Row(out,
        "instance mIoU",
        Text(instances.instance_miou, 4),
        "each true mask against the best instance");
    Row(out,
        "click mIoU",
        Text(instances.click_miou, 4),
        "a click at the mask's innermost pixel");
    Row(out, "box mIoU", Text(instances.box_miou, 4), "axis-aligned");
    Row(out, "box recall 0.25", Text(instances.box_recall25, 4), "");
    Row(out, "box recall 0.50", Text(instances.box_recall50, 4), "");
    PrintObjects(instances, out);
  }
}

}  // namespace freegs::stages
