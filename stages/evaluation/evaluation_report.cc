// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/evaluation_report.h"

#include <cstdint>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "core/number_text.h"

namespace freegs::stages {
namespace {

using nlohmann::json;

constexpr size_t kNameWidth = 24;  // Width of objects and queries in tables.

json UseJson(TestViewUse use) {
  switch (use) {
    case TestViewUse::kNone:
      return nullptr;
    case TestViewUse::kTraining:
      return "train";
    case TestViewUse::kHoldout:
      return "holdout";
  }
  return nullptr;
}

json ViewsJson(const std::optional<ImageQuality>& quality) {
  json views = json::array();
  if (!quality) return views;
  for (const ImageQuality::ViewQuality& view : quality->views) {
    views.push_back({{"name", view.name},
                     {"psnr", view.psnr},
                     {"ssim", view.ssim},
                     {"given_as", UseJson(view.use)}});
  }
  return views;
}

json CountJson(const std::optional<ImageQuality>& quality, TestViewUse use) {
  return quality ? json(quality->Count(use)) : json();
}

json IdJson(int instance) { return instance < 0 ? json() : json(instance + 1); }

json BoxIouJson(const std::optional<BoxQuality>& boxes,
                double BoxQuality::*figure) {
  return boxes ? json(*boxes.*figure) : json();
}

json LabelJson(const LabelResult& label) {
  return {{"label", label.label},
          {"objects", label.num_objects},
          {"views", label.num_views},
          {"instance", IdJson(label.answer.instance)},
          {"relevancy", label.answer.relevancy},
          {"text_iou", OrNull(label.iou)},
          {"text_boundary_iou", OrNull(label.boundary_iou)},
          {"text_box_iou", OrNull(label.box_iou)}};
}

json PanopticJson(const semantics::PanopticQuality& quality) {
  return {{"pq", OrNull(quality.Quality())},
          {"sq", OrNull(quality.Segmentation())},
          {"rq", OrNull(quality.Recognition())},
          {"true_positives", quality.true_positives},
          {"false_positives", quality.false_positives},
          {"false_negatives", quality.false_negatives}};
}

// The IoU of the label; null when words were not measured.
json TextIou(const std::optional<TextQuality>& text, const std::string& label) {
  if (!text) return nullptr;
  for (const LabelResult& result : text->labels) {
    if (result.label == label) return OrNull(result.iou);
  }
  return nullptr;
}

json ObjectJson(const ObjectResult& object,
                const std::optional<TextQuality>& text) {
  json box = nullptr;
  if (object.box) {
    box = {{"min", VectorJson(object.box->min)},
           {"max", VectorJson(object.box->max)}};
  }
  return {{"id", object.id},
          {"label", object.label},
          {"views", object.num_views},
          {"instance", IdJson(object.instance)},
          {"instance_iou", OrNull(object.instance_iou)},
          {"click_iou", OrNull(object.click_iou)},
          {"text_iou", TextIou(text, object.label)},
          {"box_iou", OrNull(object.box_iou)},
          {"box", box}};
}

// The value in fixed point, or a dash for none.
std::string Text(const std::optional<double>& value, int digits) {
  return value ? FormatFixed(*value, digits) : "-";
}

std::string IdText(int instance) {
  return instance < 0 ? "-" : std::to_string(instance + 1);
}

// UTF-8, cut or filled with blanks to `width` characters.
std::string Cell(const std::string& text, size_t width) {
  size_t characters = 0;
  size_t end = 0;
  for (; end < text.size(); ++end) {
    const bool continues = (static_cast<uint8_t>(text[end]) & 0xC0) == 0x80;
    if (continues) continue;
    if (characters == width) break;
    ++characters;
  }
  return text.substr(0, end) + std::string(width - characters, ' ');
}

void Row(std::ostream& out,
         const std::string& name,
         const std::string& value,
         const std::string& note) {
  char text[64];
  std::snprintf(
      text, sizeof(text), "  %-20s %10s  ", name.c_str(), value.c_str());
  out << text << note << "\n";
}

void PrintObjects(const InstanceQuality& quality, std::ostream& out) {
  char text[128];
  std::snprintf(text,
                sizeof(text),
                " %8s %8s %8s %8s\n",
                "instance",
                "mask IoU",
                "click",
                "box IoU");
  out << "\n  " << Cell("object", kNameWidth) << text;
  for (const ObjectResult& object : quality.objects) {
    std::snprintf(text,
                  sizeof(text),
                  " %8s %8s %8s %8s\n",
                  IdText(object.instance).c_str(),
                  Text(object.instance_iou, 3).c_str(),
                  Text(object.click_iou, 3).c_str(),
                  Text(object.box_iou, 3).c_str());
    out << "  " << Cell(object.label, kNameWidth) << text;
  }
}

void PrintLabels(const TextQuality& quality, std::ostream& out) {
  char text[128];
  std::snprintf(text,
                sizeof(text),
                " %8s %9s %8s %8s %8s\n",
                "instance",
                "relevancy",
                "mask IoU",
                "boundary",
                "box IoU");
  out << "\n  " << Cell("query", kNameWidth) << text;
  for (const LabelResult& label : quality.labels) {
    std::snprintf(text,
                  sizeof(text),
                  " %8s %9.3f %8s %8s %8s\n",
                  IdText(label.answer.instance).c_str(),
                  label.answer.relevancy,
                  Text(label.iou, 3).c_str(),
                  Text(label.boundary_iou, 3).c_str(),
                  Text(label.box_iou, 3).c_str());
    out << "  " << Cell(label.label, kNameWidth) << text;
  }
}

// Says of test views whether the pipeline had their photographs.
std::string TestViewsText(const ImageQuality& test) {
  const std::string views = std::to_string(test.views.size()) + " views";
  const size_t trained = test.Count(TestViewUse::kTraining);
  const size_t holdout = test.Count(TestViewUse::kHoldout);
  if (trained + holdout == 0) return "dB, photos never given, " + views;
  std::string text = "dB, " + views + ", of them ";
  if (trained > 0) text += std::to_string(trained) + " trained on";
  if (trained > 0 && holdout > 0) text += ", ";
  if (holdout > 0) text += std::to_string(holdout) + " given as holdout photos";
  return text;
}

void PrintBoxes(const std::string& name,
                const std::string& note,
                const std::optional<BoxQuality>& boxes,
                std::ostream& out) {
  if (!boxes) return;
  Row(out, name + " mIoU", Text(boxes->miou, 4), note);
  Row(out, name + " recall 0.25", Text(boxes->recall25, 4), "");
  Row(out, name + " recall 0.50", Text(boxes->recall50, 4), "");
}

void PrintInstances(const EvaluationReport& report, std::ostream& out) {
  const InstanceQuality& instances = *report.instances;
  if (instances.instance_miou) {
    Row(out,
        "instance mIoU",
        Text(instances.instance_miou, 4),
        "each true mask against the best instance");
    Row(out,
        "best level mIoU",
        Text(report.best_level_miou, 4),
        "each object against the best part or whole");
    Row(out,
        "click mIoU",
        Text(instances.click_miou, 4),
        "a click at the mask's innermost pixel");
  }
  if (instances.balance) {
    const semantics::SegmentationBalance& balance = *instances.balance;
    Row(out,
        "instances per object",
        Text(balance.instances_per_object, 2),
        "with a tenth of it or more; 1 is best");
    Row(out,
        "objects per instance",
        Text(balance.objects_per_instance, 2),
        "of which it covers more than half; 1 is best");
    Row(out,
        "crumbs",
        std::to_string(balance.num_crumbs),
        "of " + std::to_string(balance.num_instances) +
            " instances seen; objects without an instance: " +
            Text(balance.uncovered, 3) + " of their pixels");
  }
  if (!instances.panoptic.empty()) {
    Row(out,
        "panoptic quality",
        Text(instances.panoptic_sum.Quality(), 4),
        "segmentation " + Text(instances.panoptic_sum.Segmentation(), 3) +
            " x recognition " + Text(instances.panoptic_sum.Recognition(), 3));
  }
  PrintBoxes("box", "axis-aligned", instances.boxes, out);
}

void PrintText(const EvaluationReport& report, std::ostream& out) {
  const TextQuality& text = *report.text;
  const std::string answer = report.text_from_gaussians
                                 ? "all Gaussians relevant to each label"
                                 : "each label's best instance";
  if (text.miou) {
    Row(out,
        "text mIoU",
        Text(text.miou, 4),
        answer + ", mean over views, then labels");
    Row(out,
        "text boundary mIoU",
        Text(text.mbiou, 4),
        "2 % of the diagonal along the outline");
  }
  PrintBoxes("text box", "of " + answer, text.boxes, out);
}

// Figures of instances and words.
void AddSemantics(const EvaluationReport& report, json* result) {
  json& keys = *result;
  if (report.consistency) {
    keys["view_consistency"] = report.consistency->mean;
    keys["view_consistency_pairs"] = report.consistency->num_pairs;
  }
  if (report.instances) {
    const InstanceQuality& instances = *report.instances;
    keys["instance_miou"] = OrNull(instances.instance_miou);
    keys["click_miou"] = OrNull(instances.click_miou);
    keys["box_miou"] = BoxIouJson(instances.boxes, &BoxQuality::miou);
    keys["box_recall25"] = BoxIouJson(instances.boxes, &BoxQuality::recall25);
    keys["box_recall50"] = BoxIouJson(instances.boxes, &BoxQuality::recall50);
    if (instances.balance) {
      const semantics::SegmentationBalance& balance = *instances.balance;
      keys["instances_per_object"] = OrNull(balance.instances_per_object);
      keys["objects_per_instance"] = OrNull(balance.objects_per_instance);
      keys["instances_seen"] = balance.num_instances;
      keys["crumbs"] = balance.num_crumbs;
      keys["uncovered"] = OrNull(balance.uncovered);
    }
    if (!instances.panoptic.empty()) {
      json panoptic = PanopticJson(instances.panoptic_sum);
      keys["pq"] = panoptic["pq"];
      panoptic["views"] = json::array();
      for (const auto& [name, quality] : instances.panoptic) {
        json of_view = PanopticJson(quality);
        of_view["name"] = name;
        panoptic["views"].push_back(std::move(of_view));
      }
      keys["panoptic"] = std::move(panoptic);
    }
    for (const ObjectResult& object : instances.objects) {
      json of_object = ObjectJson(object, report.text);
      if (instances.balance && instances.balance->pieces.contains(object.id)) {
        of_object["pieces"] = instances.balance->pieces.at(object.id);
      }
      keys["objects"].push_back(std::move(of_object));
    }
  }
  if (report.text) {
    const TextQuality& text = *report.text;
    keys["text_miou"] = OrNull(text.miou);
    keys["text_mbiou"] = OrNull(text.mbiou);
    keys["text_box_miou"] = BoxIouJson(text.boxes, &BoxQuality::miou);
    keys["text_box_recall25"] = BoxIouJson(text.boxes, &BoxQuality::recall25);
    keys["text_box_recall50"] = BoxIouJson(text.boxes, &BoxQuality::recall50);
    keys["text_from"] = report.text_from_gaussians ? "gaussians" : "instances";
    keys["text_model"] = report.text_model;
    keys["text_threshold"] = OrNull(report.text_threshold);
    for (const LabelResult& label : text.labels) {
      keys["labels"].push_back(LabelJson(label));
    }
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
      {"test_trained", CountJson(report.test, TestViewUse::kTraining)},
      {"test_holdout", CountJson(report.test, TestViewUse::kHoldout)},
      {"holdout_psnr", report.holdout ? json(report.holdout->psnr) : json()},
      {"holdout_ssim", report.holdout ? json(report.holdout->ssim) : json()},
      {"pose_rotation_deg", nullptr},
      {"pose_translation", nullptr},
      {"instance_miou", nullptr},
      {"best_level_miou", OrNull(report.best_level_miou)},
      {"click_miou", nullptr},
      {"text_miou", nullptr},
      {"text_mbiou", nullptr},
      {"text_box_miou", nullptr},
      {"text_box_recall25", nullptr},
      {"text_box_recall50", nullptr},
      {"pq", nullptr},
      {"view_consistency", nullptr},
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
      {"labels", json::array()},
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
  AddSemantics(report, &result);
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
        TestViewsText(*report.test));
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
  if (report.instances) PrintInstances(report, out);
  if (report.consistency) {
    Row(out,
        "view consistency",
        Text(report.consistency->mean, 4),
        "instances in " + std::to_string(report.consistency->num_pairs) +
            " pairs of neighbouring views");
  }
  if (report.text) PrintText(report, out);
  if (report.instances) PrintObjects(*report.instances, out);
  if (report.text) PrintLabels(*report.text, out);
}

}  // namespace freegs::stages
