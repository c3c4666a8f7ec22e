// SPDX-License-Identifier: BSD-3-Clause
// Learns how evidence speaks for or against one object, from scenes whose truth
// is known, and says how well it segments others.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <boost/program_options.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "semantics/geometry/scene_extent.h"
#include "semantics/instances/palette.h"
#include "semantics/patches/evidence.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/region_merging.h"
#include "semantics/patches/scene_patches.h"
#include "splat/weights/blending_weights.h"
#include "stages/scene/workspace_scene.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;
using semantics::Evidence;
using semantics::kNumEvidences;
using semantics::RegionGraph;
using semantics::RegionTree;

// What of each patch, in pixels, is in which true segment. Segments may overlap
// where masks of parts do.
struct LearningScene {
  std::string name;
  RegionGraph graph;
  std::vector<std::map<int, double>> votes;  // Of each patch.
  std::vector<double> mass;                  // Pixels of each patch.
  std::map<int, double> segment_mass;
  std::vector<std::pair<std::string, Image<int32_t>>> pictures;  // Patches.
};

// The true segments of a view at a size: (number, mask).
using Masks = std::vector<std::pair<int, ImageU8>>;

StatusOr<Masks> MasksOf(const fs::path& truth,
                        const std::string& name,
                        std::map<std::string, int>* labels) {
  Masks masks;
  const std::string stem = fs::path(name).stem();
  const fs::path surfaces = truth / "gt/surfaces" / (stem + ".png");
  const fs::path instances = truth / "gt/instance" / (stem + ".png");
  const fs::path drawn = fs::exists(surfaces) ? surfaces : instances;
  if (fs::exists(drawn)) {
    FREEGS_ASSIGN_OR_RETURN(const ImageU16 ids, ReadLabels(drawn));
    std::map<int, ImageU8> by_id;
    for (size_t i = 0; i < ids.size(); ++i) {
      const int id = ids.data()[i];
      if (id == 0) continue;
      auto [it, added] = by_id.try_emplace(id);
      if (added) it->second = ImageU8(ids.width(), ids.height(), 1);
      it->second.data()[i] = 255;
    }
    for (auto& [id, mask] : by_id) masks.emplace_back(id, std::move(mask));
    return masks;
  }
  const fs::path folder = truth / "test_mask" / stem;
  if (!fs::exists(folder)) return masks;
  for (const auto& entry : fs::directory_iterator(folder)) {
    FREEGS_ASSIGN_OR_RETURN(const ImageU16 read, ReadLabels(entry.path()));
    ImageU8 mask(read.width(), read.height(), 1);
    for (size_t i = 0; i < read.size(); ++i) {
      mask.data()[i] = read.data()[i] > 0 ? 255 : 0;
    }
    const int id = labels
                       ->try_emplace(entry.path().stem().string(),
                                     static_cast<int>(labels->size()) + 1)
                       .first->second;
    masks.emplace_back(id, std::move(mask));
  }
  std::sort(masks.begin(), masks.end(), [](const auto& a, const auto& b) {
    return a.first < b.first;
  });
  return masks;
}

StatusOr<LearningScene> LoadScene(const fs::path& workspace,
                                  const fs::path& truth,
                                  ThreadPool& pool) {
  FREEGS_ASSIGN_OR_RETURN(const stages::WorkspaceScene scene,
                          stages::ReadWorkspaceScene(workspace));
  std::vector<View> views = scene.train;
  views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());
  const auto extent =
      semantics::ComputeSceneExtent(scene.model, views, 0.1, pool);
  const semantics::PatchScene input{.model = scene.model,
                                    .views = scene.train,
                                    .render = scene.render,
                                    .photo_of =
                                        [&](size_t v) {
                                          return ReadRgb(workspace /
                                                         "undistort/images" /
                                                         scene.train[v].name);
                                        },
                                    .scene_radius = extent.radius};
  const auto started = std::chrono::steady_clock::now();
  FREEGS_ASSIGN_OR_RETURN(semantics::ScenePatches patches,
                          semantics::BuildScenePatches(input, pool, nullptr));
  const std::chrono::duration<double> took =
      std::chrono::steady_clock::now() - started;
  LearningScene result;
  result.name = workspace.filename();
  result.graph = std::move(patches.graph);
  const size_t count = result.graph.regions.size();
  result.votes.resize(count);
  result.mass.assign(count, 0);
  std::map<std::string, int> labels;
  for (View view : views) {
    FREEGS_ASSIGN_OR_RETURN(const Masks masks,
                            MasksOf(truth, view.name, &labels));
    if (masks.empty()) continue;
    Image<int32_t> picture;
    view.camera = view.camera.LimitedTo(semantics::kPatchImageSide);
    FREEGS_ASSIGN_OR_RETURN(
        const splat::BlendingWeights weights,
        splat::ComputeBlendingWeights(
            scene.model, view.camera, view.cam_from_world, scene.render, pool));
    picture = Image<int32_t>(weights.width, weights.height, 1, -1);
    for (int y = 0; y < weights.height; ++y) {
      for (int x = 0; x < weights.width; ++x) {
        const size_t p = static_cast<size_t>(y) * weights.width + x;
        std::vector<int> ids;
        for (const auto& [id, mask] : masks) {
          if (mask((2 * x + 1) * mask.width() / (2 * weights.width),
                   (2 * y + 1) * mask.height() / (2 * weights.height)) > 127) {
            ids.push_back(id);
            result.segment_mass[id] += 1;
          }
        }
        // The patch that a pixel shows most of.
        std::map<int32_t, float> shares;
        for (uint32_t e = weights.pixel_begin[p];
             e < weights.pixel_begin[p + 1];
             ++e) {
          const int32_t patch = patches.patch_of_gaussian[weights.gaussians[e]];
          if (patch >= 0) shares[patch] += weights.weights[e];
        }
        const auto most = std::max_element(
            shares.begin(), shares.end(), [](const auto& a, const auto& b) {
              return a.second < b.second;
            });
        float all = 0;
        for (const auto& [patch, share] : shares) all += share;
        if (all < 0.5f) continue;
        picture(x, y) = most->first;
        result.mass[most->first] += 1;
        for (const int id : ids) result.votes[most->first][id] += 1;
      }
    }
    if (result.pictures.size() < 3) {
      result.pictures.emplace_back(fs::path(view.name).stem(),
                                   std::move(picture));
    }
  }
  std::cerr << result.name << ": " << count << " patches, "
            << result.graph.contacts.size() << " contacts, " << took.count()
            << " s\n";
  return result;
}

struct Example {
  Evidence evidence;
  bool different = false;
  float weight = 1;
};

// Logistic regression by Newton steps. Evidence that is left out has weight 0.
class LogisticLearner {
 public:
  LogisticLearner(const std::vector<Example>& examples,
                  std::set<std::string> left_out)
      : without_(std::move(left_out)) {
    const size_t n = kNumEvidences;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
    Eigen::VectorXd square = Eigen::VectorXd::Zero(n);
    for (const Example& example : examples) {
      for (size_t k = 0; k < n; ++k) {
        mean[k] += example.evidence[k];
        square[k] += example.evidence[k] * example.evidence[k];
      }
    }
    mean /= examples.size();
    scale_ = (square / examples.size() - mean.cwiseAbs2()).cwiseMax(1e-8);
    scale_ = scale_.cwiseSqrt().cwiseInverse();
    mean_ = mean;
    weights_ = Eigen::VectorXd::Zero(n + 1);
    for (int iteration = 0; iteration < 25; ++iteration) {
      Eigen::MatrixXd hessian = 1.0 * Eigen::MatrixXd::Identity(n + 1, n + 1);
      Eigen::VectorXd gradient = weights_;
      for (const Example& example : examples) {
        const Eigen::VectorXd x = Row(example.evidence);
        const double p = 1 / (1 + std::exp(-weights_.dot(x)));
        gradient += example.weight * (p - (example.different ? 1 : 0)) * x;
        hessian.selfadjointView<Eigen::Lower>().rankUpdate(
            x, example.weight * p * (1 - p));
      }
      hessian.triangularView<Eigen::StrictlyUpper>() =
          hessian.transpose().triangularView<Eigen::StrictlyUpper>();
      weights_ -= hessian.ldlt().solve(gradient);
    }
  }
  Eigen::VectorXd Row(const Evidence& evidence) const {
    Eigen::VectorXd x(kNumEvidences + 1);
    for (size_t k = 0; k < kNumEvidences; ++k) {
      x[k] = without_.count(semantics::kEvidenceNames[k]) > 0
                 ? 0
                 : (evidence[k] - mean_[k]) * scale_[k];
    }
    x[kNumEvidences] = 1;
    return x;
  }
  // Log-odds of being two things.
  double Difference(const Evidence& evidence) const {
    return weights_.dot(Row(evidence));
  }
  semantics::EvidenceModel Model() const {
    semantics::EvidenceModel model;
    for (size_t k = 0; k < kNumEvidences; ++k) {
      model.mean[k] = mean_[k];
      model.deviation[k] = 1 / scale_[k];
      model.weight[k] = weights_[k];
    }
    model.bias = weights_[kNumEvidences];
    return model;
  }
  void Print() const {
    for (size_t k = 0; k < kNumEvidences; ++k) {
      std::cerr << "  " << semantics::kEvidenceNames[k] << " " << weights_[k]
                << "\n";
    }
    std::cerr << "  bias " << weights_[kNumEvidences] << "\n";
  }

 private:
  std::set<std::string> without_;
  Eigen::VectorXd mean_, scale_, weights_;
};

// The true segment of a region that is mostly one, or -1.
int TrueSegment(const std::map<int, double>& votes, double mass) {
  int best = -1;
  double most = 0;
  for (const auto& [id, count] : votes) {
    if (count > most) {
      most = count;
      best = id;
    }
  }
  return most >= 0.65 * mass && mass > 0 ? best : -1;
}

// Merges as the learner says, but only what belongs together; what it asks on
// the way are the examples.
void Collect(const LearningScene& scene,
             const semantics::DifferenceFn& difference,
             bool own_mistakes,
             std::vector<Example>* examples) {
  std::vector<std::map<int, double>> votes = scene.votes;
  std::vector<double> mass = scene.mass;
  // Votes of merged regions are built on demand, in the order of merges.
  semantics::AllowFn allow = [&](int32_t a, int32_t b, const Evidence& e) {
    const int sa = TrueSegment(votes[a], mass[a]);
    const int sb = TrueSegment(votes[b], mass[b]);
    bool join = false;
    if (sa < 0 || sb < 0) {
      // Nobody knows; small ones of nothing are joined to go on.
      join = sa < 0 && sb < 0;
    } else {
      join = sa == sb;
      // Joining large regions wrongly does more harm: the root of the small
      // region's pixels.
      const double root = std::pow(10.0, 0.5 * (e[semantics::kSize] + 4));
      examples->push_back({e, !join, static_cast<float>(root)});
      if (own_mistakes) join = difference(e) <= 0;
    }
    if (join) {
      std::map<int, double> sum = votes[a];
      for (const auto& [id, count] : votes[b]) sum[id] += count;
      votes.push_back(std::move(sum));
      mass.push_back(mass[a] + mass[b]);
    }
    return join;
  };
  semantics::MergeRegions(scene.graph, difference, allow);
}

struct Quality {
  double miou = 0;
  double pieces = 0;
};

// Mean over segments of the best IoU with a region of `region_of_patch`.
Quality Judge(const LearningScene& scene,
              const std::vector<int32_t>& region_of_patch,
              bool objects = true) {
  std::map<int32_t, double> mass;
  std::map<std::pair<int, int32_t>, double> both;
  for (size_t p = 0; p < region_of_patch.size(); ++p) {
    mass[region_of_patch[p]] += scene.mass[p];
    for (const auto& [id, count] : scene.votes[p]) {
      both[{id, region_of_patch[p]}] += count;
    }
  }
  Quality quality;
  int count = 0;
  for (const auto& [id, total] : scene.segment_mass) {
    if (total < 100 || (objects && id >= 200)) continue;
    double best = 0;
    double covered = 0;
    for (const auto& [region, m] : mass) {
      const auto it = both.find({id, region});
      if (it == both.end()) continue;
      best = std::max(best, it->second / (m + total - it->second));
      covered += it->second;
    }
    for (const auto& [region, m] : mass) {
      const auto it = both.find({id, region});
      if (it != both.end() && it->second > 0.1 * covered) quality.pieces += 1;
    }
    quality.miou += best;
    ++count;
  }
  if (count > 0) {
    quality.miou /= count;
    quality.pieces /= count;
  }
  return quality;
}

// For every segment: its best region, and what else is in that.
void Explain(const LearningScene& scene,
             const std::vector<int32_t>& region_of_patch) {
  std::map<int32_t, double> mass;
  std::map<int32_t, std::map<int, double>> inside;
  for (size_t p = 0; p < region_of_patch.size(); ++p) {
    mass[region_of_patch[p]] += scene.mass[p];
    for (const auto& [id, count] : scene.votes[p]) {
      inside[region_of_patch[p]][id] += count;
    }
  }
  for (const auto& [id, total] : scene.segment_mass) {
    double best = -1;
    int32_t region = 0;
    int pieces = 0;
    for (const auto& [r, m] : mass) {
      const auto it = inside[r].find(id);
      if (it == inside[r].end()) continue;
      const double iou = it->second / (m + total - it->second);
      if (iou > best) {
        best = iou;
        region = r;
      }
      pieces += it->second > 0.1 * total;
    }
    std::printf("  segment %d: %.0f px, IoU %.3f, %d pieces, region %.0f px:",
                id,
                total,
                best,
                pieces,
                mass[region]);
    for (const auto& [other, count] : inside[region]) {
      if (count > 0.03 * mass[region]) std::printf(" %d:%.0f", other, count);
    }
    std::printf("\n");
  }
}

void Draw(const LearningScene& scene,
          const std::vector<int32_t>& region_of_patch,
          const fs::path& folder) {
  fs::create_directories(folder);
  for (const auto& [name, picture] : scene.pictures) {
    ImageU8 drawn(picture.width(), picture.height(), 3);
    for (size_t i = 0; i < picture.size(); ++i) {
      const int32_t patch = picture.data()[i];
      const auto color = semantics::PaletteColor(
          patch < 0 ? -1 : (region_of_patch[patch] * 7919) % 1000003);
      std::copy_n(color.data(), 3, drawn.data() + i * 3);
    }
    (void)WriteImage(folder / (scene.name + "_" + name + ".png"), drawn);
  }
}

// The best level per object.
double BestLevel(const LearningScene& scene, const RegionTree& tree) {
  std::vector<std::map<int, double>> votes = scene.votes;
  std::vector<double> mass = scene.mass;
  std::map<int, double> best;
  const auto look = [&](size_t region) {
    for (const auto& [id, count] : votes[region]) {
      const double iou =
          count / (mass[region] + scene.segment_mass.at(id) - count);
      best[id] = std::max(best[id], iou);
    }
  };
  for (size_t p = 0; p < votes.size(); ++p) look(p);
  for (const auto& merge : tree.merges) {
    std::map<int, double> sum = votes[merge.a];
    for (const auto& [id, count] : votes[merge.b]) sum[id] += count;
    votes.push_back(std::move(sum));
    mass.push_back(mass[merge.a] + mass[merge.b]);
    look(votes.size() - 1);
  }
  double sum = 0;
  int count = 0;
  for (const auto& [id, total] : scene.segment_mass) {
    if (total < 100 || id >= 200) continue;
    sum += best[id];
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

// The patches that are mostly in a segment, taken together.
double Oracle(const LearningScene& scene) {
  std::vector<int32_t> best(scene.votes.size(), 0);
  double sum = 0;
  int n = 0;
  for (const auto& [id, total] : scene.segment_mass) {
    if (total < 100 || id >= 200) continue;
    double in = 0;
    double all = 0;
    for (size_t p = 0; p < scene.votes.size(); ++p) {
      const auto it = scene.votes[p].find(id);
      if (it == scene.votes[p].end() || it->second < 0.5 * scene.mass[p]) {
        continue;
      }
      in += it->second;
      all += scene.mass[p];
    }
    sum += in / (all + total - in);
    ++n;
  }
  return n > 0 ? sum / n : 0;
}

void WriteModel(const semantics::EvidenceModel& model,
                size_t num_scenes,
                size_t num_examples,
                const fs::path& path) {
  std::ofstream file(path);
  file << "{\n \"learnt_from\": {\"scenes\": " << num_scenes
       << ", \"pairs\": " << num_examples << "},\n \"bias\": " << model.bias
       << ",\n \"evidence\": [\n";
  for (size_t k = 0; k < kNumEvidences; ++k) {
    file << "  {\"name\": \"" << semantics::kEvidenceNames[k]
         << "\", \"mean\": " << model.mean[k]
         << ", \"deviation\": " << model.deviation[k]
         << ", \"weight\": " << model.weight[k] << "}"
         << (k + 1 < kNumEvidences ? ",\n" : "\n");
  }
  file << " ]\n}\n";
}

// As many rounds as there are, each with the examples that the learner of the
// one before came across, its own mistakes included.
LogisticLearner Learn(const std::vector<LearningScene>& scenes,
                      const std::vector<std::string>& without,
                      size_t* num_examples) {
  constexpr int kRounds = 3;
  const std::set<std::string> left_out(without.begin(), without.end());
  std::vector<Example> examples;
  std::optional<LogisticLearner> learner;
  for (int round = 0; round < kRounds; ++round) {
    const semantics::DifferenceFn difference = [&](const Evidence& e) {
      return learner ? learner->Difference(e)
                     : double{e[semantics::kContrastFar]} +
                           e[semantics::kHistogram] + e[semantics::kColor];
    };
    for (const LearningScene& scene : scenes) {
      if (learner) Collect(scene, difference, true, &examples);
      Collect(scene, difference, false, &examples);
    }
    learner.emplace(examples, left_out);
  }
  *num_examples = examples.size();
  return *std::move(learner);
}

void Report(const std::vector<LearningScene>& scenes,
            const LogisticLearner& learner,
            const std::string& draw,
            bool explain) {
  constexpr double kCuts[] = {-2, -1, -0.5, 0, 0.5, 1, 2};
  std::map<double, double> mean;
  double best = 0;
  double oracle = 0;
  const auto share = 1 / static_cast<double>(scenes.size());
  std::printf("%-14s", "cut at");
  for (const double cut : kCuts) std::printf("   %6.1f", cut);
  std::printf("  best level  patches\n");
  for (const LearningScene& scene : scenes) {
    const RegionTree tree = semantics::MergeRegions(
        scene.graph, [&](const Evidence& e) { return learner.Difference(e); });
    if (explain) Explain(scene, tree.Cut(0));
    if (!draw.empty()) Draw(scene, tree.Cut(0), draw);
    std::printf("%-14s", scene.name.c_str());
    for (const double cut : kCuts) {
      const Quality quality = Judge(scene, tree.Cut(cut));
      std::printf(" %.3f/%2.0f", quality.miou, quality.pieces);
      mean[cut] += quality.miou * share;
    }
    const double level = BestLevel(scene, tree);
    const double most = Oracle(scene);
    std::printf("  %10.3f  %7.3f\n", level, most);
    best += level * share;
    oracle += most * share;
  }
  std::printf("%-14s", "mean");
  for (const double cut : kCuts) std::printf(" %.3f   ", mean[cut]);
  std::printf("  %10.3f  %7.3f\n", best, oracle);
}

int Run(int argc, char** argv) {
  std::vector<std::string> train;
  std::vector<std::string> test;
  std::vector<std::string> without;
  bool explain = false;
  std::string draw;
  std::string out;
  po::options_description description(
      "Learns what evidence is worth. Tables: mean IoU of objects and in how "
      "many pieces they are, at several cuts");
  // clang-format off
  description.add_options()
      ("help,h", "this text")
      ("train", po::value(&train)->multitoken()->required(),
       "WORKSPACE TRUTH ...: scenes of freegs_make_scene --scene clutter")
      ("test", po::value(&test)->multitoken(), "WORKSPACE TRUTH ...")
      ("out", po::value(&out), "JSON file to write")
      ("without", po::value(&without)->multitoken(), "evidence to leave out")
      ("draw", po::value(&draw), "folder for pictures of the regions")
      ("explain", po::bool_switch(&explain), "a line for every object");
  // clang-format on
  po::variables_map values;
  try {
    po::store(po::parse_command_line(argc, argv, description), values);
    if (values.count("help") != 0) {
      std::cout << description;
      return 0;
    }
    po::notify(values);
  } catch (const po::error& error) {
    std::cerr << "freegs_fit_evidence: " << error.what() << "\n";
    return 2;
  }
  ThreadPool pool;
  std::vector<LearningScene> taught;
  std::vector<LearningScene> tested;
  for (const bool is_test : {false, true}) {
    const std::vector<std::string>& names = is_test ? test : train;
    for (size_t i = 0; i + 1 < names.size(); i += 2) {
      auto scene = LoadScene(names[i], names[i + 1], pool);
      if (!scene.ok()) {
        std::cerr << names[i] << ": " << scene.status().message() << "\n";
        return 1;
      }
      (is_test ? tested : taught).push_back(*std::move(scene));
    }
  }
  size_t num_examples = 0;
  const LogisticLearner learner = Learn(taught, without, &num_examples);
  learner.Print();
  if (!out.empty()) {
    WriteModel(learner.Model(), taught.size(), num_examples, out);
  }
  Report(taught, learner, draw, explain);
  if (!tested.empty()) Report(tested, learner, draw, explain);
  return 0;
}

}  // namespace
}  // namespace freegs

int main(int argc, char** argv) { return freegs::Run(argc, argv); }
