// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_metrics.h"

#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "stages/bootstrap/instance_doubts.h"

namespace freegs::stages {
namespace {

Status WriteLosses(const std::vector<semantics::LossRecord>& losses,
                   const pipeline::StageContext& context) {
  std::ostringstream csv;
  csv << "iteration,pixel,instance,smoothing,contrastive\n";
  for (const semantics::LossRecord& record : losses) {
    csv << record.step << ',' << record.losses.pixel << ','
        << record.losses.instance << ',' << record.losses.smoothing << ','
        << record.losses.contrastive << '\n';
  }
  return WriteFileAtomic(context.output / "progress.csv", csv.str());
}

}  // namespace

Status WriteBootstrapMetrics(const BootstrapStageOptions& options,
                             size_t num_gaussians,
                             const semantics::SemanticField& field,
                             const std::vector<semantics::Instance>& instances,
                             int num_words_withheld,
                             const pipeline::ResourceMeter& meter,
                             pipeline::StageContext& context) {
  const semantics::InstanceLabels& labels = field.instances;
  int num_background = 0;
  nlohmann::json sizes = nlohmann::json::array();
  for (const semantics::Instance& instance : instances) {
    num_background += instance.background;
    sizes.push_back(instance.num_gaussians);
  }
  const pipeline::ResourceUsage usage = meter.Elapsed();
  nlohmann::json metrics = {
      {"mode", options.mode},
      {"clustering", options.clustering},
      {"num_gaussians", num_gaussians},
      {"num_instances", labels.num_instances},
      {"num_background", num_background},
      {"mean_score", MeanScore(labels)},
      {"agreement",
       options.clustering == "evidence" ? nlohmann::json(labels.agreement)
                                        : nlohmann::json()},
      {"scene_radius", labels.scene_radius},
      {"num_clustered", labels.num_clustered},
      {"noise_after", labels.noise_after},
      {"seconds", context.earlier_seconds + usage.wall_seconds},
      {"cpu_seconds", context.earlier_cpu_seconds + usage.cpu_seconds},
      {"peak_memory_bytes", usage.peak_memory_bytes}};
  if (options.clustering == "union") {
    metrics["hdbscan"] = {
        {"min_cluster_size", labels.min_cluster_size},
        {"min_samples",
         options.method.clustering.union_space.hdbscan.min_samples}};
  }
  if (options.mode != "geometry") {
    for (const auto& [step, seconds] : field.seconds) {
      metrics["step_seconds"][step] = seconds;
    }
    metrics["feature_dim"] = field.decoder.latent_dim();
    metrics["num_unseen"] = field.num_unseen;
    metrics["num_crops"] = field.vectors.num_crops;
    metrics["num_words_withheld"] = num_words_withheld;
  }
  if (options.mode == "paper") {
    metrics["iterations"] = field.steps;
    metrics["clusterings"] = nlohmann::json::array();
    for (const semantics::ClusteringRound& round : field.rounds) {
      metrics["clusterings"].push_back({{"iteration", round.step},
                                        {"num_instances", round.num_instances},
                                        {"agreement", round.agreement}});
    }
  }
  context.summary = metrics;
  if (options.mode == "paper") {
    FREEGS_RETURN_IF_ERROR(WriteLosses(field.losses, context));
  }
  metrics["instance_sizes"] = std::move(sizes);
  return WriteFileAtomic(context.output / "metrics.json", JsonText(metrics, 1));
}

}  // namespace freegs::stages
