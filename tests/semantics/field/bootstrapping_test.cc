// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/bootstrapping.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "semantics/field/field_checkpoint.h"
#include "tests/semantics/clip/color_encoder.h"
#include "tests/semantics/synthetic_gaussians.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

// The table scene, its pictures, and an encoder that sees colours.

class BootstrappingTest : public testing::Test {
 protected:
  void SetUp() override { TakePhotos(); }

  void TakePhotos() {
    ThreadPool pool(2);
    views_.clear();
    photos_.clear();
    for (int k = 0; k < 8; ++k) {
      views_.push_back(LookAtOrigin(0.785 * k));
      views_.back().camera = views_.back().camera.Resized(240, 180);
      views_.back().name = "view" + std::to_string(k);
      photos_.push_back(ToU8(splat::RenderView(scene_.model,
                                               views_.back().camera,
                                               views_.back().cam_from_world,
                                               {},
                                               pool)
                                 .color));
    }
  }

  StatusOr<SemanticField> Lift(
      int threads = 2, const CancellationToken* cancellation = nullptr) {
    ThreadPool pool(threads);
    const FeatureCache cache(folder_ / "cache");
    return BootstrapSemanticField(
        {scene_.model, views_, views_, splat::RenderOptions()},
        [&](size_t view) -> StatusOr<ImageU8> { return photos_[view]; },
        options_,
        0,
        {encoder_, cache, pool, cancellation, progress_, resume_from_, save_});
  }

  // The label that most Gaussians of an object have.
  int32_t LabelOf(const SemanticField& field, int32_t object) const {
    std::map<int32_t, int> counts;
    for (size_t i = 0; i < scene_.truth.size(); ++i) {
      if (scene_.truth[i] == object) ++counts[field.instances.labels[i]];
    }
    return std::max_element(
               counts.begin(),
               counts.end(),
               [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }

  static double Cosine(const InstanceVectors& vectors,
                       int32_t label,
                       const std::vector<float>& other) {
    double sum = 0;
    for (size_t c = 0; c < other.size(); ++c) {
      sum += vectors.vectors[label * other.size() + c] * other[c];
    }
    return sum;
  }

  SyntheticGaussians scene_ = MakeTableScene();
  std::vector<View> views_;
  std::vector<ImageU8> photos_;
  ColorEncoder encoder_;
  TemporaryFolder folder_;
  BootstrappingOptions options_;
  ProgressFn progress_;
  std::optional<FieldState> resume_from_;
  std::function<Status(const FieldTraining&, bool)> save_;
};

// Training that is over soon.
FieldTrainingOptions ShortTraining() {
  FieldTrainingOptions training;
  training.iterations = 250;
  training.pixels_per_step = 64;
  training.hidden_dim = 16;
  training.cluster_start = 100;
  training.cluster_interval = 50;
  training.smoothing_start = 20;
  training.settled_index = 2;
  training.decoder.learning_rate = 5e-3;
  return training;
}

TEST_F(BootstrappingTest, InstancesMeanWhatThePhotographsShow) {
  const auto field = Lift();
  ASSERT_TRUE(field.ok()) << field.status().message();
  EXPECT_EQ(field->instances.num_instances, 5);
  EXPECT_EQ(field->vectors.dim, 8);
  // Every instance is seen in more views than are encoded.
  EXPECT_EQ(field->vectors.num_crops,
            static_cast<size_t>(5 * options_.instances.views_per_instance));
  EXPECT_LE(field->decoder.latent_dim(), 8);
  EXPECT_EQ(field->seconds.size(), 4u);
  const std::vector<float> red = ColorEncoder::Embed({0.7, 0.1, 0.1});
  const std::vector<float> green = ColorEncoder::Embed({0.1, 0.6, 0.1});
  const std::vector<float> blue = ColorEncoder::Embed({0.1, 0.2, 0.7});
  const int32_t labels[] = {
      LabelOf(*field, 1), LabelOf(*field, 2), LabelOf(*field, 3)};
  const std::vector<float>* colors[] = {&red, &green, &blue};
  for (int object = 0; object < 3; ++object) {
    for (int color = 0; color < 3; ++color) {
      if (color == object) continue;
      EXPECT_GT(Cosine(field->vectors, labels[object], *colors[object]),
                Cosine(field->vectors, labels[object], *colors[color]) + 0.1)
          << object << " " << color;
    }
  }
}

// Calls "green" what is red and blue, as it would a snowman. It has an inkling
// of it where it sees the red part alone.
class SnowmanEncoder : public ColorEncoder {
 public:
  StatusOr<std::vector<float>> EncodeImage(const ImageU8& image) override {
    double red = 0;
    double blue = 0;
    for (size_t i = 0; i < image.num_pixels(); ++i) {
      const uint8_t* rgb = image.data() + 3 * i;
      red += rgb[0] > rgb[1] + 50 && rgb[0] > rgb[2] + 50 ? 1 : 0;
      blue += rgb[2] > rgb[0] + 30 && rgb[2] > rgb[1] + 30 ? 1 : 0;
    }
    if (std::min(red, blue) > 0.45 * std::max(red, blue)) {
      return Embed({0.1, 0.7, 0.1});
    }
    if (red > blue) return Embed({0.48, 0.53, 0.48});
    return ColorEncoder::EncodeImage(image);
  }
};

TEST_F(BootstrappingTest, InstancesThatAreRecognisedTogetherAreOne) {
  scene_.AddSphere({0.5, 0.5, 0.4}, 0.12, {0.1, 0.2, 0.8}, 900, 5);
  TakePhotos();
  SnowmanEncoder encoder;
  const FeatureCache cache(folder_ / "cache");
  auto words = Vocabulary::Create({{"green"}}, encoder);
  ASSERT_TRUE(words.ok());
  const auto lift = [&](double min_confidence, int threads) {
    ThreadPool pool(threads);
    BootstrapTools tools{
        encoder, cache, pool, nullptr, nullptr, resume_from_, save_};
    tools.things = {*words, min_confidence};
    return BootstrapSemanticField(
        {scene_.model, views_, views_, splat::RenderOptions()},
        [&](size_t view) -> StatusOr<ImageU8> { return photos_[view]; },
        options_,
        0,
        tools);
  };
  const auto apart = lift(0, 2);
  ASSERT_TRUE(apart.ok()) << apart.status().message();
  EXPECT_NE(LabelOf(*apart, 1), LabelOf(*apart, 5));
  const auto joined = lift(0.7, 2);
  ASSERT_TRUE(joined.ok()) << joined.status().message();
  EXPECT_EQ(joined->instances.num_instances,
            apart->instances.num_instances - 1);
  const int32_t snowman = LabelOf(*joined, 1);
  EXPECT_EQ(snowman, LabelOf(*joined, 5));
  // It has the vector of both together, and the others have theirs.
  EXPECT_GT(
      Cosine(joined->vectors, snowman, ColorEncoder::Embed({0.1, 0.7, 0.1})),
      0.999);
  EXPECT_NEAR(Cosine(joined->vectors,
                     LabelOf(*joined, 3),
                     ColorEncoder::Embed({0.1, 0.2, 0.8})),
              Cosine(apart->vectors,
                     LabelOf(*apart, 3),
                     ColorEncoder::Embed({0.1, 0.2, 0.8})),
              1e-6);
  EXPECT_EQ(lift(0.7, 1)->instances.labels, joined->instances.labels);
}

// Sees the colours of an image at four times the resolution of its grid.
class UpsamplingEncoder : public ColorEncoder {
 public:
  static constexpr int kSize = 4 * kGrid;

  int upsampled_size() const override { return kSize; }
  StatusOr<ImageF> Upsample(const ImageF& features,
                            const ImageU8& image) override {
    EXPECT_EQ(features.width(), kGrid);
    ++num_upsampled;
    const ImageU8 small = Resize(image, kSize, kSize);
    ImageF result(kSize, kSize, 8);
    for (size_t i = 0; i < small.num_pixels(); ++i) {
      const uint8_t* rgb = small.data() + 3 * i;
      const std::vector<float> vector =
          Embed({rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0});
      std::copy(vector.begin(), vector.end(), result.data() + 8 * i);
    }
    return result;
  }

  int num_upsampled = 0;
};

TEST_F(BootstrappingTest, TheModelMayBringItsUpsampler) {
  const auto without = Lift();
  ASSERT_TRUE(without.ok());
  UpsamplingEncoder encoder;
  const FeatureCache cache(folder_ / "cache");
  const auto lift = [&](int threads) {
    ThreadPool pool(threads);
    return BootstrapSemanticField(
        {scene_.model, views_, views_, splat::RenderOptions()},
        [&](size_t view) -> StatusOr<ImageU8> { return photos_[view]; },
        options_,
        0,
        {encoder, cache, pool, nullptr, nullptr, resume_from_, save_});
  };
  const auto with = lift(2);
  ASSERT_TRUE(with.ok()) << with.status().message();
  EXPECT_EQ(encoder.num_upsampled, 8);
  EXPECT_NE(with->features, without->features);
  EXPECT_EQ(lift(1)->features, with->features);
  // A small thing keeps its colour where cells mix it with what is around.
  const std::vector<float> red = ColorEncoder::Embed({0.7, 0.1, 0.1});
  const auto likeness = [&](const SemanticField& field) {
    ThreadPool pool(1);
    const auto means = MeanInstanceVectors(
        field.features,
        std::vector<double>(field.instances.labels.size(), 1.0),
        field.instances.labels,
        field.instances.num_instances,
        field.decoder,
        pool);
    EXPECT_TRUE(means.ok());
    return Cosine({.dim = 8, .vectors = *means}, LabelOf(field, 1), red);
  };
  EXPECT_GT(likeness(*with), likeness(*without));

  // Training looks at the same features.
  options_.method = FieldMethod::kTrain;
  options_.training = ShortTraining();
  const auto trained = lift(2);
  ASSERT_TRUE(trained.ok()) << trained.status().message();
  EXPECT_LT(trained->losses.back().losses.pixel, 0.5);
}

TEST_F(BootstrappingTest, EveryVectorOfAnInstanceHasLengthOne) {
  for (const FieldMethod method : {FieldMethod::kLift, FieldMethod::kTrain}) {
    options_.method = method;
    options_.training = ShortTraining();
    const auto field = Lift();
    ASSERT_TRUE(field.ok());
    for (int i = 0; i < field->instances.num_instances; ++i) {
      double square = 0;
      for (int c = 0; c < 8; ++c) {
        square += std::pow(field->vectors.vectors[i * 8 + c], 2);
      }
      EXPECT_NEAR(square, 1, 1e-5);
    }
  }
}

TEST_F(BootstrappingTest, SameBytesForAnyNumberOfThreads) {
  const auto a = Lift(1);
  const auto b = Lift(3);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->features, b->features);
  EXPECT_EQ(a->instances.labels, b->instances.labels);
  EXPECT_EQ(a->vectors.vectors, b->vectors.vectors);
}

TEST_F(BootstrappingTest, PhotographsGoThroughTheNetworkOnce) {
  ASSERT_TRUE(Lift().ok());
  EXPECT_EQ(encoder_.num_dense, 8);
  ASSERT_TRUE(Lift().ok());
  EXPECT_EQ(encoder_.num_dense, 8);
}

TEST_F(BootstrappingTest, DimensionIsWhatIsAskedOrWhatTheSceneNeeds) {
  options_.features.dim = 3;
  const auto three = Lift();
  ASSERT_TRUE(three.ok());
  EXPECT_EQ(three->decoder.latent_dim(), 3);
  options_.features.dim = 0;
  options_.features.kept_energy = 1;
  options_.features.max_dim = 5;
  const auto five = Lift();
  ASSERT_TRUE(five.ok());
  EXPECT_EQ(five->decoder.latent_dim(), 5);
}

TEST_F(BootstrappingTest, TrainingLearnsWhatLiftingKnows) {
  options_.method = FieldMethod::kTrain;
  options_.training = ShortTraining();
  const auto field = Lift();
  ASSERT_TRUE(field.ok()) << field.status().message();
  EXPECT_EQ(field->steps, 250);
  ASSERT_EQ(field->rounds.size(), 3u);
  EXPECT_EQ(field->rounds[0].step, 100);
  EXPECT_EQ(field->rounds[0].num_instances, 5);
  EXPECT_GT(field->rounds[2].agreement, 0.9);
  ASSERT_EQ(field->losses.size(), 3u);
  EXPECT_LT(field->losses.back().losses.pixel,
            0.7 * field->losses.front().losses.pixel);
  EXPECT_EQ(field->losses[0].losses.instance, 0);
  EXPECT_GT(field->losses[1].losses.instance, 0);
  EXPECT_GT(field->losses[1].losses.smoothing, 0);
  EXPECT_GT(field->losses[1].losses.contrastive, 0);
  EXPECT_NE(field->decoder.mlp(), nullptr);
  EXPECT_EQ(field->instances.num_instances, 5);
}

TEST_F(BootstrappingTest, TrainingEndsWhenClusteringHasSettled) {
  options_.method = FieldMethod::kTrain;
  options_.training = ShortTraining();
  options_.training.settled_index = 0.9;
  const auto field = Lift();
  ASSERT_TRUE(field.ok());
  EXPECT_EQ(field->steps, 150);
  EXPECT_EQ(field->rounds.size(), 2u);
}

TEST_F(BootstrappingTest, InterruptedTrainingGoesOnToTheSameBytes) {
  options_.method = FieldMethod::kTrain;
  options_.training = ShortTraining();
  std::vector<double> steps;  // As reported.
  progress_ = [&steps](const Progress& progress) {
    if (progress.step == "training") steps.push_back(progress.done);
  };
  const auto whole = Lift(1);
  ASSERT_TRUE(whole.ok());
  EXPECT_GT(steps.size(), 5u);
  EXPECT_TRUE(std::is_sorted(steps.begin(), steps.end()));
  // After the last step, 250, instances are still to be found.
  for (const int64_t stop : {50, 100, 200, 250}) {
    CancellationToken cancellation;
    std::optional<FieldState> saved;
    save_ = [&](const FieldTraining& training, bool stopping) {
      if (training.step() >= stop) cancellation.Cancel();
      if (stopping) {
        const auto bytes = SerializeFieldState(training.state());
        EXPECT_TRUE(bytes.ok());
        auto state = ParseFieldState(*bytes);
        EXPECT_TRUE(state.ok()) << state.status().message();
        saved = *std::move(state);
      }
      return Status();
    };
    EXPECT_EQ(Lift(2, &cancellation).status().code(), StatusCode::kInterrupted);
    ASSERT_TRUE(saved.has_value()) << stop;
    EXPECT_EQ(saved->step, stop);
    save_ = nullptr;
    resume_from_ = std::move(saved);
    steps.clear();
    const auto rest = Lift(3);
    resume_from_.reset();
    ASSERT_TRUE(rest.ok());
    ASSERT_FALSE(steps.empty());
    EXPECT_EQ(steps.front(), stop);
    EXPECT_EQ(rest->features, whole->features) << stop;
    EXPECT_EQ(rest->instances.labels, whole->instances.labels);
    EXPECT_EQ(rest->vectors.vectors, whole->vectors.vectors);
    EXPECT_EQ(rest->rounds.size(), whole->rounds.size());
    EXPECT_EQ(rest->losses.back().losses.pixel,
              whole->losses.back().losses.pixel);
  }
}

TEST_F(BootstrappingTest, EachLossCanBeLeftOut) {
  options_.method = FieldMethod::kTrain;
  options_.training = ShortTraining();
  options_.training.iterations = 40;
  options_.training.cluster_start = 20;
  const auto all = Lift();
  ASSERT_TRUE(all.ok());
  const struct {
    double FieldTrainingOptions::*weight;
    double FieldLosses::*loss;
  } losses[] = {
      {&FieldTrainingOptions::instance_weight, &FieldLosses::instance},
      {&FieldTrainingOptions::smoothing_weight, &FieldLosses::smoothing},
      {&FieldTrainingOptions::contrastive_weight, &FieldLosses::contrastive}};
  for (const auto& [weight, loss] : losses) {
    const double usual = std::exchange(options_.training.*weight, 0.0);
    const auto rest = Lift();
    options_.training.*weight = usual;
    ASSERT_TRUE(rest.ok());
    EXPECT_GT(all->losses.back().losses.*loss, 0);
    EXPECT_EQ(rest->losses.back().losses.*loss, 0);
    EXPECT_NE(rest->features, all->features);
  }
  options_.training.cluster_start = 0;
  const auto without = Lift();
  ASSERT_TRUE(without.ok());
  EXPECT_TRUE(without->rounds.empty());
}

TEST_F(BootstrappingTest, RandomStartIsAnotherStart) {
  scene_.Add({0, 0, 9}, {0.5, 0.5, 0.5}, 0.01, 0.9, -1);  // Above all views.
  options_.method = FieldMethod::kTrain;
  options_.training = ShortTraining();
  options_.training.iterations = 1;
  options_.random_start = true;
  const auto a = Lift();
  options_.random_start = false;
  const auto b = Lift();
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE(a->features, b->features);
  // What no view shows has no vector, whatever the start.
  const int dim = a->decoder.latent_dim();
  EXPECT_EQ(std::vector<float>(a->features.end() - dim, a->features.end()),
            std::vector<float>(dim, 0.0f));
}

TEST_F(BootstrappingTest, StopsWhenCancelled) {
  CancellationToken cancellation;
  cancellation.Cancel();
  EXPECT_EQ(Lift(2, &cancellation).status().code(), StatusCode::kInterrupted);
}

TEST_F(BootstrappingTest, RefusesOptionsOutOfRange) {
  options_.instances.views_per_instance = 0;
  EXPECT_EQ(Lift().status().code(), StatusCode::kInvalidArgument);
}

TEST(MeanInstanceVectorsTest, AveragesDirectionsByWhatIsSeen) {
  ThreadPool pool(1);
  LinearDecoder axes;
  axes.latent_dim = axes.feature_dim = 2;
  axes.mean = {0, 0};
  axes.basis = {1, 0, 0, 1};
  const std::vector<float> vectors = {5, 0, 0, 1, 0, 0, 3, 3};
  const std::vector<double> weights = {1, 3, 9, 1};
  const std::vector<int32_t> labels = {0, 0, 0, -1};
  const auto result = MeanInstanceVectors(
      vectors, weights, labels, 2, FeatureDecoder(axes), pool);
  ASSERT_TRUE(result.ok());
  const std::vector<float>& means = *result;
  ASSERT_EQ(means.size(), 4u);
  EXPECT_NEAR(means[0], 1 / std::sqrt(10.0), 1e-6);
  EXPECT_NEAR(means[1], 3 / std::sqrt(10.0), 1e-6);
  EXPECT_EQ(means[2], 0);  // An instance without Gaussians.
}

}  // namespace
}  // namespace freegs::semantics
