// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_options.h"

#include <cstdint>

#include "core/number_text.h"

namespace freegs::stages {
namespace {

void RegisterSemanticOptions(BootstrapStageOptions& options,
                             pipeline::OptionTable& table) {
  semantics::BootstrappingOptions& method = options.method;
  table.Add(
      "bootstrap.model",
      &options.model,
      {.help = "Folder of a CLIP model as the command model makes it; empty "
               "for the small one that comes with the program.",
       .is_path = true});
  table.Add("bootstrap.dense_size",
            &method.features.dense_size,
            {.help = "Image size in pixels of the features of places; 0 is the "
                     "model's default.",
             .min = 0,
             .max = 8192});
  table.Add("bootstrap.feature_dim",
            &method.features.dim,
            {.help = "Numbers of a semantic vector; 0 takes as many as the "
                     "scene's features need (the paper: 128).",
             .min = 0,
             .max = 4096});
  table.Add("bootstrap.weights_memory_gb",
            &options.weights_memory_gb,
            {.help = "Memory for blending weights, in GB (10^9 bytes).",
             .min = 0,
             .max = 1000000,
             .affects_result = false});
}

void RegisterTrainingOptions(BootstrapStageOptions& options,
                             pipeline::OptionTable& table) {
  semantics::FieldTrainingOptions& training = options.method.training;
  table.Add("bootstrap.iterations",
            &training.iterations,
            {.help = "Steps of training, with mode paper.",
             .min = 0,
             .max = 10000000});
  table.Add("bootstrap.random_start",
            &options.method.random_start,
            {.help = "Training begins with random vectors, not with lifted "
                     "ones."});
  table.Add("bootstrap.instance_weight",
            &training.instance_weight,
            {.help = "Weight of the loss of instances' features (gamma); 0 "
                     "leaves it out.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.smoothing_weight",
            &training.smoothing_weight,
            {.help = "Weight of the smoothing loss (lambda_S); 0 leaves it "
                     "out.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.contrastive_weight",
            &training.contrastive_weight,
            {.help = "Weight of the contrastive loss (lambda_C); 0 leaves it "
                     "out.",
             .min = 0,
             .max = 1000});
}

// Adds the options of clustering in the union space.
void RegisterUnionOptions(BootstrapStageOptions& options,
                          pipeline::OptionTable& table) {
  semantics::UnionClusteringOptions& clustering =
      options.method.clustering.union_space;
  table.Add("bootstrap.min_samples",
            &clustering.hdbscan.min_samples,
            {.help = "With clustering union: neighbours that make a "
                     "neighbourhood dense; more gives rounder clusters and "
                     "more noise.",
             .min = 1,
             .max = 10000});
  table.Add("bootstrap.min_cluster_size",
            &clustering.hdbscan.min_cluster_size,
            {.help = "With clustering union: fewest Gaussians of a cluster; 0 "
                     "takes 0.3 % of those that take part, but at least 30.",
             .min = 0,
             .max = 100000000});
  table.Add("bootstrap.semantic_weight",
            &clustering.space.semantic_weight,
            {.help = "With clustering union: weight of semantics (0 to 1) when "
                     "Gaussians are compared.",
             .min = 0,
             .max = 1000});
}

}  // namespace

void RegisterBootstrapOptions(BootstrapStageOptions& options,
                              pipeline::OptionTable& table) {
  table.AddSection("bootstrap",
                   "Phase 2: what Gaussians mean, and which belong together.");
  table.Add("bootstrap.mode",
            &options.mode,
            {.help = "Semantics averaged from the photographs' features in one "
                     "pass (lift), trained from there (paper), or none: "
                     "geometry and colour only (geometry).",
             .choices = {"lift", "paper", "geometry"}});
  table.Add("bootstrap.clustering",
            &options.clustering,
            {.help = "Instances from evidence in photographs and space, or by "
                     "HDBSCAN in the paper's union space.",
             .choices = {"evidence", "union"}});
  table.Add("bootstrap.granularity",
            &options.method.clustering.evidence.granularity,
            {.help = "Above 0 more and smaller instances, below 0 fewer and "
                     "larger ones.",
             .min = -100,
             .max = 100});
  RegisterSemanticOptions(options, table);
  RegisterTrainingOptions(options, table);
  RegisterUnionOptions(options, table);
}

StatusOr<semantics::BootstrappingOptions> MakeBootstrappingOptions(
    const BootstrapStageOptions& options) {
  semantics::BootstrappingOptions method = options.method;
  method.method = options.mode == "paper" ? semantics::FieldMethod::kTrain
                                          : semantics::FieldMethod::kLift;
  method.clustering.method = options.clustering == "union"
                                 ? semantics::ClusteringMethod::kUnion
                                 : semantics::ClusteringMethod::kEvidence;
  // Only the method as published refines masks; docs/crf.md.
  method.instances.refine = method.method == semantics::FieldMethod::kTrain;
  method.weights.max_memory_bytes =
      static_cast<uint64_t>(options.weights_memory_gb * double{kGigabyte});
  FREEGS_RETURN_IF_ERROR(method.Check());
  return method;
}

}  // namespace freegs::stages
