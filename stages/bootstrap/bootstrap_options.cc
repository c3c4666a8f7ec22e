// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_options.h"

#include <cstdint>

namespace freegs::stages {
namespace {

void RegisterSemanticOptions(BootstrapStageOptions& options,
                             pipeline::OptionTable& table) {
  semantics::BootstrappingOptions& method = options.method;
  table.Add("bootstrap.model",
            &options.model,
            {.help = "Folder of a CLIP model (scripts/export_clip.py); empty "
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
  table.Add("bootstrap.kept_energy",
            &method.features.kept_energy,
            {.help = "Share of what varies between features that as many "
                     "numbers must keep.",
             .min = 0.01,
             .max = 1});
  table.Add("bootstrap.feature_size",
            &method.weights.max_side,
            {.help = "Longest side in pixels of the images that features are "
                     "lifted from.",
             .min = 16,
             .max = 8192});
  table.Add("bootstrap.views_per_instance",
            &method.instances.views_per_instance,
            {.help = "Photographs of each instance that are looked at as a "
                     "whole.",
             .min = 1,
             .max = 100000});
  table.Add("bootstrap.refine_masks",
            &method.instances.refine,
            {.help = "Refines the masks of instances that are looked at by a "
                     "conditional random field."});
  table.Add("bootstrap.instance_share",
            &method.instance_share,
            {.help = "How much of an instance's meaning is what it looks like "
                     "as a whole; the rest is that of its parts.",
             .min = 0,
             .max = 1});
  table.Add("bootstrap.weights_memory_gb",
            &options.weights_memory_gb,
            {.help = "Memory for blending weights.",
             .min = 0,
             .max = 1000000,
             .affects_result = false});
  table.Add("bootstrap.weights_disk_gb",
            &options.weights_disk_gb,
            {.help = "Disk space for blending weights beyond that; what does "
                     "not fit is computed again when needed.",
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
  table.Add("bootstrap.pixels_per_step",
            &training.pixels_per_step,
            {.help = "Pixels whose features are compared in a step.",
             .min = 1,
             .max = 1000000});
  table.Add("bootstrap.learning_rate",
            &training.learning_rate,
            {.help = "Of semantic vectors.", .min = 0, .max = 1000});
  table.Add("bootstrap.random_start",
            &options.method.random_start,
            {.help = "Training begins with random vectors, as the paper's "
                     "does, not with lifted ones."});
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
  table.Add("bootstrap.cluster_start",
            &training.cluster_start,
            {.help = "Steps before Gaussians are first clustered; 0: not "
                     "before the end.",
             .min = 0,
             .max = 10000000});
  table.Add("bootstrap.cluster_interval",
            &training.cluster_interval,
            {.help = "Steps from one clustering to the next.",
             .min = 1,
             .max = 10000000});
  table.Add("bootstrap.settled_index",
            &training.settled_index,
            {.help = "Training ends when two clusterings in a row agree to "
                     "this adjusted Rand index; above 1 never.",
             .min = 0,
             .max = 2});
}

// How Gaussians are compared, and which of them are a cluster.
void RegisterClusteringOptions(BootstrapStageOptions& options,
                               pipeline::OptionTable& table) {
  semantics::InstanceClusteringOptions& clustering = options.method.clustering;
  table.Add("bootstrap.min_samples",
            &clustering.hdbscan.min_samples,
            {.help = "Neighbours that make a neighbourhood dense: more gives "
                     "rounder clusters and more noise.",
             .min = 1,
             .max = 10000});
  table.Add("bootstrap.min_cluster_size",
            &clustering.hdbscan.min_cluster_size,
            {.help = "Fewest Gaussians of a cluster; 0 takes 0.3 % of all.",
             .min = 0,
             .max = 100000000});
  table.Add("bootstrap.min_gap_ratio",
            &clustering.hdbscan.min_gap_ratio,
            {.help = "Clusters are split across gaps of this many times their "
                     "inner distances; 0 leaves HDBSCAN's choice.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.cluster_selection_epsilon",
            &clustering.hdbscan.cluster_selection_epsilon,
            {.help = "Clusters that split at less than this distance stay "
                     "together (scene radii times the weights); 0 always "
                     "splits.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.max_cluster_size",
            &clustering.hdbscan.max_cluster_size,
            {.help = "Clusters of more Gaussians are split; 0 is no limit.",
             .min = 0});
  table.Add("bootstrap.method",
            &options.selection,
            {.help = "Which clusters of the hierarchy are taken: those of most "
                     "excess of mass, or its leaves (finer).",
             .choices = {"eom", "leaf"}});
  table.Add("bootstrap.position_weight",
            &clustering.space.position_weight,
            {.help = "Weight of positions (in scene radii) when Gaussians are "
                     "compared.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.color_weight",
            &clustering.space.color_weight,
            {.help = "Weight of colours (0 to 1) when Gaussians are compared.",
             .min = 0,
             .max = 1000});
  table.Add(
      "bootstrap.semantic_weight",
      &clustering.space.semantic_weight,
      {.help = "Weight of semantics (0 to 1) when Gaussians are compared.",
       .min = 0,
       .max = 1000});
  table.Add("bootstrap.color_neighbors",
            &clustering.color_neighbors,
            {.help = "Neighbours over which colours and semantics are averaged "
                     "first.",
             .min = 0,
             .max = 1000});
}

// How clusters become instances.
void RegisterInstanceOptions(BootstrapStageOptions& options,
                             pipeline::OptionTable& table) {
  semantics::InstanceClusteringOptions& clustering = options.method.clustering;
  table.Add("bootstrap.max_planes",
            &clustering.planes.max_planes,
            {.help = "Large planes (floor, walls, table tops) that become "
                     "instances of their own before clustering; 0 seeks none.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.min_plane_width",
            &clustering.planes.min_width,
            {.help = "Shorter side of such a plane, in scene radii, at least: "
                     "smaller faces are those of things.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.merge_color",
            &clustering.merge_color,
            {.help = "Touching clusters join when their mean colours differ by "
                     "less than this; 0 joins none.",
             .min = 0,
             .max = 2});
  table.Add("bootstrap.merge_distance",
            &clustering.merge_distance,
            {.help = "How near clusters must be to touch, in scene radii.",
             .min = 0,
             .max = 10});
  table.Add("bootstrap.min_crease_contrast",
            &clustering.min_crease_contrast,
            {.help = "Clusters are split at concave creases between parts of "
                     "different colour: concavity (0 to 2) times colour "
                     "difference from which on they are; 0 splits none.",
             .min = 0,
             .max = 10});
  table.Add("bootstrap.noise_distance",
            &clustering.noise_distance,
            {.help = "Noise joins the nearest cluster within this many scene "
                     "radii.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.min_instance_size",
            &clustering.min_instance_size,
            {.help = "Instances of fewer Gaussians are dissolved.",
             .min = 1,
             .max = 100000000});
  table.Add("bootstrap.min_opacity",
            &clustering.min_opacity,
            {.help = "Fainter Gaussians are not clustered; they take their "
                     "neighbour's instance.",
             .min = 0,
             .max = 0.99});
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
                     "a chain of rules about geometry and colour.",
             .choices = {"evidence", "chain"}});
  table.Add("bootstrap.granularity",
            &options.method.clustering.evidence.granularity,
            {.help = "Above 0 more and smaller instances, below 0 fewer and "
                     "larger ones.",
             .min = -100,
             .max = 100});
  RegisterSemanticOptions(options, table);
  RegisterTrainingOptions(options, table);
  RegisterClusteringOptions(options, table);
  RegisterInstanceOptions(options, table);
  table.Add("bootstrap.max_image_size",
            &options.max_image_size,
            {.help = "Longest side in pixels of the instance maps; 0 is the "
                     "photographs' size.",
             .min = 0,
             .max = 100000});
  table.Add("bootstrap.num_previews",
            &options.num_previews,
            {.help = "Photographs that get a coloured preview.",
             .min = 0,
             .max = 100000});
}

StatusOr<semantics::BootstrappingOptions> MakeBootstrappingOptions(
    const BootstrapStageOptions& options) {
  constexpr double kGigabyte = 1 << 30;
  semantics::BootstrappingOptions method = options.method;
  method.method = options.mode == "paper" ? semantics::FieldMethod::kTrain
                                          : semantics::FieldMethod::kLift;
  method.clustering.method = options.clustering == "chain"
                                 ? semantics::ClusteringMethod::kChain
                                 : semantics::ClusteringMethod::kEvidence;
  method.clustering.hdbscan.method =
      options.selection == "leaf" ? semantics::ClusterSelection::kLeaf
                                  : semantics::ClusterSelection::kExcessOfMass;
  method.weights.max_memory_bytes =
      static_cast<uint64_t>(options.weights_memory_gb * kGigabyte);
  method.weights.max_scratch_bytes =
      static_cast<uint64_t>(options.weights_disk_gb * kGigabyte);
  FREEGS_RETURN_IF_ERROR(method.Check());
  return method;
}

}  // namespace freegs::stages
