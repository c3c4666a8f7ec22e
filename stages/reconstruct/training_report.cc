// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_report.h"

#include <algorithm>
#include <utility>

#include "core/number_text.h"
#include "core/quantile.h"

namespace freegs::stages {
namespace {

// Null when there was no search. What it shows is null when it had too few
// photos for a training, or that came to nothing; a number of it, when masks
// left nothing to measure.
nlohmann::json ChoiceJson(const std::optional<splat::ExposureChoice>& choice) {
  if (!choice) return nullptr;
  const auto measured = [](double psnr) -> nlohmann::json {
    if (psnr == 0) return nullptr;
    return psnr;
  };
  const auto psnr = [&](const splat::TrialPsnr& shown) -> nlohmann::json {
    if (shown == splat::TrialPsnr()) return nullptr;
    return {{"trained_psnr", measured(shown.trained)},
            {"others_psnr", measured(shown.held_out)}};
  };
  return {{"learn", choice->learn},
          {"without", psnr(choice->without)},
          {"with", psnr(choice->with)}};
}

}  // namespace

nlohmann::json CourseJson(const std::string& densification,
                          const splat::Trainer* trainer) {
  nlohmann::json course = {{"densification", nullptr},
                           {"budget", nullptr},
                           {"exposure_search", nullptr},
                           {"importance_metric", nullptr},
                           {"milestones", nlohmann::json::array()},
                           {"recoveries", nlohmann::json::array()}};
  if (trainer == nullptr) return course;
  course["densification"] = densification;
  course["budget"] = trainer->options().budget;
  course["exposure_search"] = ChoiceJson(trainer->exposure_choice());
  if (densification == "mini_splatting") {
    const bool outdoor =
        trainer->importance_metric() == splat::ImportanceMetric::kOutdoor;
    course["importance_metric"] = outdoor ? "outdoor" : "indoor";
  }
  for (const splat::MilestoneRecord& record : trainer->milestones()) {
    course["milestones"].push_back(
        {{"iteration", record.iteration},
         {"event", splat::TrainingEventName(record.event)},
         {"gaussians_before", record.gaussians_before},
         {"gaussians_after", record.gaussians_after}});
  }
  for (const splat::Recovery& recovery : trainer->recoveries()) {
    course["recoveries"].push_back({{"iteration", recovery.iteration},
                                    {"reason", recovery.reason},
                                    {"back_to", recovery.back_to},
                                    {"rate_factor", recovery.rate_factor}});
  }
  return course;
}

std::string RecoveryText(const splat::Recovery& recovery) {
  return "training diverged at iteration " +
         std::to_string(recovery.iteration) + " (" + recovery.reason +
         "); back to iteration " + std::to_string(recovery.back_to) +
         ", learning rates now times " +
         FormatSignificant(recovery.rate_factor, 6);
}

std::string MilestoneText(const splat::MilestoneRecord& record) {
  return std::string(splat::TrainingEventName(record.event)) +
         " at iteration " + std::to_string(record.iteration) + ", " +
         std::to_string(record.gaussians_before) + " -> " +
         std::to_string(record.gaussians_after) + " Gaussians";
}

std::string ExposureText(const std::optional<splat::ExposureChoice>& choice) {
  if (!choice) {
    return "the exposure of each photo is not learnt, because the time is up";
  }
  const auto change = [](double without, double with) {
    return FormatFixed(without, 2) + " -> " + FormatFixed(with, 2) + " dB";
  };
  if (choice->without == splat::TrialPsnr()) {
    return "the exposure of each photo is not learnt, because photos are too "
           "few, masks leave too little of them, or the short training that "
           "tells came to nothing";
  }
  if (choice->without.held_out == 0) {
    return "the exposure of each photo is not learnt, because masks leave too "
           "little of the photos to tell";
  }
  return std::string("the exposure of each photo is ") +
         (choice->learn ? "learnt" : "not learnt") +
         "; after a short training with most of the photos, that of "
         "its neighbours changes them from " +
         change(choice->without.trained, choice->with.trained) +
         ", and fitted colours change the others from " +
         change(choice->without.held_out, choice->with.held_out);
}

std::string DisplacementNote(const std::vector<DisplacedView>& views,
                             bool imported_scene) {
  // On eight scenes with right poses half of the photos lay within 0.3 pixels,
  // or 0.04 % of their size, and none beyond 0.6 (docs/stability.md).
  constexpr double kFarShare = 0.005;
  constexpr double kFarPixels = 1.5;
  std::vector<double> all;
  size_t far = 0;
  for (const DisplacedView& view : views) {
    all.push_back(view.pixels);
    if (view.pixels > std::max(kFarPixels, kFarShare * view.longest_side)) {
      ++far;
    }
  }
  if (2 * far <= views.size()) return "";
  return std::to_string(far) + " of " + std::to_string(views.size()) +
         " photos kept from training lie beside what the scene shows from "
         "their poses, by " +
         FormatFixed(Median(all), 1) + " pixels (median): " +
         (imported_scene
              ? "the imported scene seems to have been trained with other "
                "poses; import those, too (sfm.import)"
              : "the poses seem to be wrong, or to belong to other photos. If "
                "they were imported, let structure from motion find them "
                "(without sfm.import); otherwise take more photos");
}

std::string NewViewsNote(double trained_psnr,
                         const std::vector<double>& holdout_psnr) {
  // Errors twice as large. Models of enough photos in right places lay at most
  // 5.5 dB apart (docs/stability.md).
  constexpr double kFarApart = 6;
  const double holdout = Median(holdout_psnr);
  if (holdout_psnr.empty() || trained_psnr - holdout <= kFarApart) return "";
  return "photos kept from training are shown with " + FormatFixed(holdout, 1) +
         " dB (median of " + std::to_string(holdout_psnr.size()) +
         "), and photos that were trained on with " +
         FormatFixed(trained_psnr, 1) +
         " dB: new views will be poor. The photos seem to be too few, too far "
         "apart, or in wrong places; take more in between";
}

}  // namespace freegs::stages
