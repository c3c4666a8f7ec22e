// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_report.h"

#include <utility>

#include "core/number_text.h"

namespace freegs::stages {
namespace {

// Null when there was no search.
nlohmann::json ChoiceJson(const std::optional<splat::ExposureChoice>& choice) {
  if (!choice) return nullptr;
  const auto psnr = [](const splat::HoldoutPsnr& trial) -> nlohmann::json {
    return {{"psnr", trial.plain}, {"psnr_fitted", trial.fitted}};
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

std::string ExposureText(const splat::ExposureChoice& choice) {
  const auto change = [](double without, double with) {
    return FormatFixed(without, 2) + " -> " + FormatFixed(with, 2) + " dB";
  };
  return std::string("the exposure of each photo is ") +
         (choice.learn ? "learnt" : "not learnt") +
         "; in short trainings it changed the holdout from " +
         change(choice.without.plain, choice.with.plain) +
         ", with fitted colours from " +
         change(choice.without.fitted, choice.with.fitted);
}

}  // namespace freegs::stages
