// SPDX-License-Identifier: BSD-3-Clause
// freegs_fit_evidence: learns how evidence speaks for or against one object,
// from scenes whose truth is known, and says how well it segments others.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <boost/program_options.hpp>

#include "bench/evidence/evidence_learner.h"
#include "bench/evidence/learning_scene.h"
#include "bench/evidence/quality_learner.h"
#include "bench/evidence/segmentation_quality.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "semantics/instances/evidence_clustering.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/palette.h"
#include "semantics/patches/region_graph.h"
#include "semantics/patches/scene_patches.h"

namespace freegs::evidence {
namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;
using semantics::EvidenceModel;
using semantics::LearntModels;

struct Arguments {
  std::vector<std::string> train;  // Workspace, truth, workspace, ...
  std::vector<std::string> test;
  std::vector<std::string> without;
  std::string weights;
  std::string out;
  std::string draw;
  bool semantics = false;
  bool explain = false;
  bool in_turn = false;
  int threads = 0;
};

void Draw(const LearningScene& scene,
          const std::vector<int32_t>& region_of_patch,
          const fs::path& folder) {
  for (const auto& [name, patches] : scene.pictures) {
    ImageU8 drawn(patches.width(), patches.height(), 3);
    for (size_t i = 0; i < patches.size(); ++i) {
      const int32_t patch = patches.data()[i];
      const int32_t region = patch < 0 ? -1 : region_of_patch[patch];
      const auto color =
          semantics::PaletteColor(region < 0 ? -1 : (region * 7919) % 1000003);
      std::copy_n(color.data(), 3, drawn.data() + i * 3);
    }
    const Status written =
        WriteImage(folder / (scene.name + "_" + name + ".png"), drawn);
    if (!written.ok()) std::cerr << written.message() << "\n";
  }
}

void Explain(const std::vector<ObjectQuality>& objects) {
  for (const ObjectQuality& object : objects) {
    std::printf("  object %d: %.0f pixels, IoU %.3f, %d pieces; in its region:",
                object.id,
                object.pixels,
                object.iou,
                object.pieces);
    for (const auto& [id, pixels] : object.in_region) {
      if (pixels > 0.05 * object.pixels) std::printf(" %d:%.0f", id, pixels);
    }
    std::printf("\n");
  }
}

// A scene with each of its divisions into patches.
using Divisions = std::vector<LearningScene>;

// The hierarchy that the program takes, and the division that it is of.
struct Chosen {
  semantics::Hierarchy hierarchy;
  size_t division = 0;
};

Chosen Choose(const Divisions& scene,
              const LearntModels& models,
              ThreadPool& pool) {
  std::vector<semantics::ScenePatches> patches;
  for (const LearningScene& one : scene) patches.push_back(one.patches);
  std::vector<semantics::Hierarchy> hierarchies =
      semantics::BuildHierarchies(patches, models, pool);
  const size_t division =
      semantics::DivisionMostAgreedOn(hierarchies, patches[0].seen, pool)
          .division;
  return {std::move(hierarchies[division]), division};
}

// A table of all scenes. Returns the mean IoU at the default granularity.
double Report(const std::vector<Divisions>& scenes,
              const LearntModels& models,
              const Arguments& arguments,
              ThreadPool& pool) {
  constexpr double kGranularities[] = {-7, -3, -1, 0, 1, 2, 4};
  constexpr size_t kColumns = std::size(kGranularities);
  struct Row {
    Chosen chosen;
    std::vector<std::vector<ObjectQuality>> objects;
    double best_level = 0;
    double best_patches = 0;
  };
  std::vector<Row> rows(scenes.size());
  pool.ParallelFor(
      0,
      static_cast<int64_t>(scenes.size()),
      1,
      [&](int64_t first, int64_t last, int) {
        ThreadPool one_thread(1);
        for (int64_t s = first; s < last; ++s) {
          Row& row = rows[s];
          row.chosen = Choose(scenes[s], models, one_thread);
          const LearningScene& scene = scenes[s][row.chosen.division];
          for (const double granularity : kGranularities) {
            row.objects.push_back(MeasureObjects(
                scene,
                semantics::CutHierarchy(row.chosen.hierarchy, granularity)
                    .region_of_part));
          }
          row.best_level = BestLevelIou(scene, row.chosen.hierarchy.tree);
          row.best_patches = BestPatchesIou(scene);
        }
      });
  std::printf("%-16s", "granularity");
  for (const double granularity : kGranularities) {
    std::printf("  %8.1f", granularity);
  }
  std::printf("  best level  patches\n");
  std::vector<double> mean(kColumns + 2, 0.0);
  const auto count = static_cast<double>(scenes.size());
  double worst = 1;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const Row& row = rows[s];
    const LearningScene& scene = scenes[s][row.chosen.division];
    std::printf("%-16s", scene.name.c_str());
    for (size_t k = 0; k < kColumns; ++k) {
      const double iou = MeanIou(row.objects[k]);
      std::printf("  %.3f/%.1f", iou, MeanPieces(row.objects[k]));
      mean[k] += iou / count;
      if (kGranularities[k] == 0) worst = std::min(worst, iou);
    }
    std::printf("  %10.3f  %7.3f\n", row.best_level, row.best_patches);
    mean[kColumns] += row.best_level / count;
    mean[kColumns + 1] += row.best_patches / count;
    const std::vector<ObjectQuality>& normal = row.objects[kColumns / 2];
    if (arguments.explain) Explain(normal);
    if (!arguments.draw.empty()) {
      Draw(scene,
           semantics::CutHierarchy(row.chosen.hierarchy, 0).region_of_part,
           arguments.draw);
    }
  }
  std::printf("%-16s", "mean");
  for (size_t k = 0; k < kColumns; ++k) std::printf("  %.3f    ", mean[k]);
  std::printf("  %10.3f  %7.3f; worst %.3f\n",
              mean[kColumns],
              mean[kColumns + 1],
              worst);
  std::fflush(stdout);
  return mean[kColumns / 2];
}

// What a file was learnt from and judged on, as its first lines. mean_iou: of
// the objects in the scenes that it was judged on, if there were any.
struct Origin {
  size_t num_scenes = 0;
  size_t num_judged = 0;
  double mean_iou = 0;
};

void WriteOrigin(const Origin& origin,
                 const char* of_what,
                 size_t num_examples,
                 std::ostream& text) {
  text << "{\n \"learnt_from\": {\"scenes\": " << origin.num_scenes << ", \""
       << of_what << "\": " << num_examples << "},\n";
  if (origin.num_judged > 0) {
    text << " \"judged_on\": {\"scenes\": " << origin.num_judged
         << ", \"mean_iou\": " << origin.mean_iou << "},\n";
  }
}

Status WriteEvidence(const LearntEvidence& learnt,
                     const Origin& origin,
                     const fs::path& path) {
  const EvidenceModel& model = learnt.model;
  std::ostringstream text;
  WriteOrigin(origin, "pairs", learnt.num_examples, text);
  text << " \"bias\": " << model.bias << ",\n \"evidence\": [\n";
  for (size_t k = 0; k < semantics::kNumEvidences; ++k) {
    text << "  {\"name\": \"" << semantics::kEvidenceNames[k]
         << "\", \"mean\": " << model.mean[k]
         << ", \"deviation\": " << model.deviation[k]
         << ", \"weight\": " << model.weight[k] << "}"
         << (k + 1 < semantics::kNumEvidences ? ",\n" : "\n");
  }
  text << " ]\n}\n";
  return WriteFileAtomic(path, text.str());
}

Status WriteQuality(const LearntQuality& learnt,
                    const Origin& origin,
                    const fs::path& path) {
  const semantics::QualityModel& model = learnt.model;
  std::ostringstream text;
  WriteOrigin(origin, "regions", learnt.num_regions, text);
  text << " \"bias\": " << model.bias << ",\n \"numbers\": [\n";
  for (size_t k = 0; k < semantics::kNumRegionAttributes; ++k) {
    text << "  {\"name\": \"" << semantics::RegionAttributeName(k)
         << "\", \"least\": " << model.least[k]
         << ", \"most\": " << model.most[k]
         << ", \"weight\": " << model.weight[k] << "}"
         << (k + 1 < semantics::kNumRegionAttributes ? ",\n" : "\n");
  }
  text << " ]\n}\n";
  return WriteFileAtomic(path, text.str());
}

// Fits the same examples without each evidence, and the quality of regions to
// what becomes of them, and says what becomes of the scenes.
void LeaveOutInTurn(const LearntEvidence& learnt,
                    const std::vector<LearningScene>& taught,
                    const std::vector<Divisions>& tested,
                    double all,
                    const Arguments& arguments,
                    ThreadPool& pool) {
  std::vector<std::pair<std::string, double>> means;
  for (const char* name : semantics::kEvidenceNames) {
    std::set<std::string> without(arguments.without.begin(),
                                  arguments.without.end());
    if (!without.insert(name).second) continue;
    std::printf("without %s\n", name);
    LearntModels models;
    models.evidence = Calibrated(FitEvidence(learnt.share, without, pool),
                                 learnt.calibration);
    models.quality = LearnQuality(taught, models.evidence, pool).model;
    means.emplace_back(name, Report(tested, models, arguments, pool));
  }
  std::printf("\n%-16s  mean IoU  difference\n%-16s  %8.3f\n",
              "without",
              "nothing",
              all);
  for (const auto& [name, mean] : means) {
    std::printf("%-16s  %8.3f  %+10.3f\n", name.c_str(), mean, mean - all);
  }
}

StatusOr<std::vector<Divisions>> LoadScenes(
    const std::vector<std::string>& folders,
    bool with_semantics,
    ThreadPool& pool) {
  std::vector<Divisions> scenes;
  for (size_t i = 0; i + 1 < folders.size(); i += 2) {
    FREEGS_ASSIGN_OR_RETURN(
        Divisions scene,
        LoadLearningScene(folders[i], folders[i + 1], with_semantics, pool));
    const semantics::RegionGraph& graph = scene[0].patches.graph;
    std::cerr << scene[0].name << ": " << graph.regions.size() << " patches, "
              << graph.contacts.size() << " contacts\n";
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

Status CheckPairs(const char* option, const std::vector<std::string>& folders) {
  if (folders.size() % 2 == 0) return Status();
  return InvalidArgumentError(std::string(option) +
                              " takes pairs of WORKSPACE TRUTH; the last "
                              "workspace, " +
                              folders.back() + ", has no truth");
}

Status Learn(const Arguments& arguments) {
  FREEGS_RETURN_IF_ERROR(CheckPairs("--train", arguments.train));
  FREEGS_RETURN_IF_ERROR(CheckPairs("--test", arguments.test));
  FREEGS_RETURN_IF_ERROR(CheckEvidenceNames(arguments.without));
  for (const std::string& folder : {arguments.draw, arguments.out}) {
    if (!folder.empty()) FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
  }
  ThreadPool pool(arguments.threads);
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<Divisions> tested,
      LoadScenes(arguments.test, arguments.semantics, pool));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<Divisions> training,
      LoadScenes(arguments.train, arguments.semantics, pool));
  // One division of each scene teaches, as when the models that come with the
  // program were learnt.
  std::vector<LearningScene> taught;
  for (const Divisions& scene : training) taught.push_back(scene[0]);
  FREEGS_ASSIGN_OR_RETURN(LearntModels models, semantics::DefaultModels());
  const bool learns_evidence = arguments.weights.empty() && !taught.empty();
  if (!arguments.weights.empty()) {
    FREEGS_ASSIGN_OR_RETURN(const std::string text,
                            ReadFile(arguments.weights, 1 << 20));
    FREEGS_ASSIGN_OR_RETURN(models.evidence,
                            semantics::ParseEvidenceModel(text));
  }
  LearntEvidence evidence;
  if (learns_evidence) {
    FREEGS_ASSIGN_OR_RETURN(
        evidence,
        LearnEvidence(taught,
                      {arguments.without.begin(), arguments.without.end()},
                      pool));
    std::printf("log-odds are %.3f * height %+.3f\n",
                evidence.calibration.slope,
                evidence.calibration.offset);
    models.evidence = evidence.model;
  }
  LearntQuality quality;
  if (!taught.empty()) {
    quality = LearnQuality(taught, models.evidence, pool);
    if (quality.num_regions == 0) {
      return BadInputError(
          "nothing to learn the quality of regions from: no view with true "
          "masks shows a region");
    }
    models.quality = quality.model;
    Report(training, models, arguments, pool);
  }
  Origin origin{.num_scenes = taught.size(), .num_judged = tested.size()};
  if (!tested.empty()) {
    origin.mean_iou = Report(tested, models, arguments, pool);
  }
  if (!arguments.out.empty() && !taught.empty()) {
    const fs::path folder = arguments.out;
    if (learns_evidence) {
      FREEGS_RETURN_IF_ERROR(
          WriteEvidence(evidence, origin, folder / "evidence.json"));
    }
    FREEGS_RETURN_IF_ERROR(
        WriteQuality(quality, origin, folder / "region_quality.json"));
  }
  if (arguments.in_turn && learns_evidence && !tested.empty()) {
    LeaveOutInTurn(evidence, taught, tested, origin.mean_iou, arguments, pool);
  }
  return Status();
}

int Run(int argc, char** argv) {
  Arguments arguments;
  po::options_description description(
      "Learns what evidence is worth. Tables: mean IoU of objects and in how "
      "many pieces they are, at several granularities");
  // clang-format off
  description.add_options()
      ("help,h", "this text")
      ("train", po::value(&arguments.train)->multitoken(),
       "WORKSPACE TRUTH ...: scenes of freegs_make_scene --scene clutter")
      ("test", po::value(&arguments.test)->multitoken(), "WORKSPACE TRUTH ...")
      ("weights", po::value(&arguments.weights),
       "evidence.json to take; only the quality of regions is learnt then")
      ("out", po::value(&arguments.out), "folder for evidence.json and region_quality.json")
      ("without", po::value(&arguments.without)->multitoken(),
       "evidence to leave out")
      ("semantics", po::bool_switch(&arguments.semantics),
       "semantics are evidence: bootstrap/idsf.bin of the workspaces")
      ("in-turn", po::bool_switch(&arguments.in_turn),
       "also fit with each evidence left out in turn")
      ("draw", po::value(&arguments.draw), "folder for pictures of the regions")
      ("explain", po::bool_switch(&arguments.explain), "a line for every object")
      ("threads", po::value(&arguments.threads)->default_value(0),
       "0: all cores");
  // clang-format on
  po::variables_map values;
  try {
    po::store(po::parse_command_line(argc, argv, description), values);
    po::notify(values);
  } catch (const po::error& error) {
    std::cerr << "freegs_fit_evidence: " << error.what() << "\n";
    return 2;
  }
  if (values.count("help") != 0) {
    std::cout << description;
    return 0;
  }
  try {
    const Status status = Learn(arguments);
    if (status.ok()) return 0;
    std::cerr << "freegs_fit_evidence: " << status.message() << "\n";
  } catch (const std::exception& error) {
    std::cerr << "freegs_fit_evidence: " << error.what() << "\n";
  }
  return 1;
}

}  // namespace
}  // namespace freegs::evidence

int main(int argc, char** argv) { return freegs::evidence::Run(argc, argv); }
