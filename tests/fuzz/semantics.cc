// SPDX-License-Identifier: BSD-3-Clause
// Files of the semantic field, of its instances and of their features.

#include "semantics/clip/feature_cache.h"
#include "semantics/field/field_checkpoint.h"
#include "semantics/field/idsf.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instances_json.h"
#include "semantics/losses/decoder_file.h"
#include "semantics/queries/instance_features.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

semantics::FieldState SmallField() {
  semantics::FieldTrainingOptions options;
  options.hidden_dim = 3;
  semantics::FieldState state = semantics::FieldTraining::InitialState(
      {1, 2, 3, 4, 5, 6}, 2, 4, options, 7);
  state.step = 42;
  state.teachers = {2, {0, -1, 1}, {1, 0, 0, 0, 0, 0, 0, 0}};
  state.rounds = {{30, 2, 0}, {40, 2, 0.75}};
  state.history = {{40, {0.1, 0.2, 0.3, 0.4}}};
  return state;
}

}  // namespace

Reader FieldCheckpoint() {
  return {[](std::string_view bytes) {
            const auto state = semantics::ParseFieldState(WithChecksum(bytes));
            if (!state.ok()) return;
            const auto written = semantics::SerializeFieldState(*state);
            Require(written.ok() && semantics::ParseFieldState(*written).ok());
          },
          [] {
            return std::vector<std::string>{SeedWithoutChecksum(
                *semantics::SerializeFieldState(SmallField()))};
          }};
}

Reader IdsfFile() {
  return {[](std::string_view bytes) {
            const auto idsf = semantics::ParseIdsf(WithChecksum(bytes));
            if (!idsf.ok()) return;
            const auto written = semantics::SerializeIdsf(*idsf);
            Require(written.ok() && *written == WithChecksum(bytes));
          },
          [] {
            const semantics::Idsf idsf = {2, {1, 2, 3, 4, 5, 6}, {0, -1, 1}};
            return std::vector<std::string>{
                SeedWithoutChecksum(*semantics::SerializeIdsf(idsf)),
                SeedWithoutChecksum(
                    *semantics::SerializeIdsf({0, {}, {0, -1, 1}}))};
          }};
}

Reader Decoder() {
  return {[](std::string_view bytes) {
            const auto stored = semantics::ParseDecoder(WithChecksum(bytes));
            if (!stored.ok()) return;
            const auto written = semantics::SerializeDecoder(*stored);
            Require(written.ok() && semantics::ParseDecoder(*written).ok());
          },
          [] {
            const semantics::LinearDecoder linear = {
                2, 3, {1, 2, 3, 4, 5, 6}, {1, 2, 3}};
            const semantics::FieldState field = SmallField();
            return std::vector<std::string>{
                SeedWithoutChecksum(*semantics::SerializeDecoder(
                    {semantics::FeatureDecoder(linear), std::nullopt})),
                SeedWithoutChecksum(*semantics::SerializeDecoder(
                    {field.decoder, field.decoder_adam}))};
          }};
}

Reader FeatureCacheEntry() {
  return {
      [](std::string_view bytes) {
        const semantics::FeatureCache cache(Scratch().path());
        WriteText(cache.FileOf("image", "model", "dense"), WithChecksum(bytes));
        const auto found = cache.Find("image", "model", "dense");
        Require(found.features.has_value() == found.reason.empty());
      },
      [] {
        const semantics::FeatureCache cache(Scratch().path());
        Require(
            cache.Store("image", "model", "dense", ImageF(3, 2, 4, 0.5f)).ok());
        return std::vector<std::string>{SeedWithoutChecksum(
            ReadText(cache.FileOf("image", "model", "dense")))};
      }};
}

Reader InstancesFile() {
  return {[](std::string_view bytes) {
            const auto instances = semantics::ParseInstances(bytes);
            if (!instances.ok()) return;
            Require(semantics::ParseInstances(
                        semantics::SerializeInstances(*instances))
                        .ok());
          },
          [] {
            std::vector<semantics::Instance> instances(2);
            instances[0].id = 1;
            instances[0].words = {"red apple", "apple"};
            instances[1].id = 2;
            instances[1].background = true;
            return std::vector<std::string>{
                semantics::SerializeInstances(instances)};
          }};
}

Reader HierarchyFile() {
  return {
      [](std::string_view bytes) {
        const auto hierarchy = semantics::ParseHierarchy(bytes);
        if (!hierarchy.ok()) return;
        Require(
            semantics::ParseHierarchy(semantics::SerializeHierarchy(*hierarchy))
                .ok());
        const auto num_leaves =
            static_cast<int32_t>(hierarchy->part_pixels.size());
        for (const double granularity : {-5.0, 0.0, 5.0}) {
          (void)semantics::CutHierarchy(*hierarchy, granularity);
        }
        for (int32_t leaf = 0; leaf < std::min(num_leaves, 8); ++leaf) {
          for (const int steps : {-2, 0, 3}) {
            (void)semantics::GaussiansOf(
                *hierarchy, semantics::RegionAround(*hierarchy, leaf, steps));
          }
        }
      },
      [] {
        semantics::Hierarchy hierarchy;
        hierarchy.part_pixels = {100, 200, 50, 3};
        hierarchy.total_pixels = 1000;
        hierarchy.tree.num_leaves = 4;
        hierarchy.quality = {0.5, 0.5, 0.5, 0.5, 0.9, 0.6, 0.2};
        hierarchy.tree.merges = {{0, 1, -2}, {4, 2, 1}, {3, 5, 2}};
        hierarchy.part_of_gaussian = {0, 0, 1, -1, 2, 3};
        return std::vector<std::string>{
            semantics::SerializeHierarchy(hierarchy)};
      }};
}

Reader InstanceFeaturesFile() {
  return {[](std::string_view bytes) {
            const auto features = semantics::ParseInstanceFeatures(bytes);
            if (!features.ok()) return;
            const auto written =
                semantics::SerializeInstanceFeatures(*features);
            Require(written.ok() &&
                    semantics::ParseInstanceFeatures(*written).ok());
          },
          [] {
            semantics::InstanceFeatures features;
            features.dim = 2;
            features.model = "tiny";
            features.model_hash = "00";
            features.features = {1, 0, 0, 0, 0.6f, 0.8f};
            return std::vector<std::string>{
                *semantics::SerializeInstanceFeatures(features)};
          }};
}

}  // namespace freegs::fuzz
