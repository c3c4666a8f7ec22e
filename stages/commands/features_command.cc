// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/features_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/json_text.h"
#include "core/number_text.h"
#include "core/parallel.h"
#include "pipeline/system_info.h"
#include "semantics/clip/feature_cache.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/clip/relevancy.h"
#include "semantics/clip/relevancy_map.h"
#include "stages/scene/clip_input.h"
#include "stages/scene/heat_map.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Colours begin at the relevancy at which a place is as much like the words as
// like a canonical phrase. They never reach their brightest below the second
// value, so that an image that does not show the words stays dark.
constexpr double kNoRelevancy = 0.5;
constexpr double kFullRelevancy = 0.6;

struct FeaturesRequest {
  fs::path image;
  std::string text;
  std::string model;
  std::string out;
  std::string cache;
  int dense_size = 0;
  int size = 448;
  int threads = 0;
  semantics::JointBilateralOptions upsampling;
};

CommandWords DescribeFeatures(FeaturesRequest* request) {
  CommandWords words("features", "Draws where in an image CLIP sees words.");
  words.AddArgument({.name = "IMAGE", .help = "The photograph."});
  words.AddOption("text",
                  &request->text,
                  {.help = "Words to look for.", .value_name = "WORDS"});
  words.AddOption(
      "model",
      &request->model,
      {.help = "Folder of a CLIP model (freegs_pipeline model); the small "
               "one that comes with the program when not given.",
       .value_name = "DIR"});
  words.AddOption("out",
                  &request->out,
                  {.help = "Picture to write (.png or .jpg); IMAGE_heat.png in "
                           "the current folder when not given.",
                   .value_name = "FILE"});
  words.AddLetter('o', "out");  // Many programs have it.
  words.AddOption("cache",
                  &request->cache,
                  {.help = "Folder that keeps features for other words.",
                   .value_name = "DIR"});
  words.AddOption("dense-size",
                  &request->dense_size,
                  {.help = "Image size in pixels that the network sees; 0 is "
                           "the model's default.",
                   .min = 0});
  words.AddOption("size",
                  &request->size,
                  {.help = "Longest side of the picture in pixels.",
                   .min = 8,
                   .max = 8192});
  words.AddOption(
      "range-sigma",
      &request->upsampling.range_sigma,
      {.help = "How unlike in colour two places of one thing may be.",
       .min = 0.001,
       .max = 1000});
  words.AddThreads(&request->threads);
  words.Require("text");
  return words;
}

StatusOr<FeaturesRequest> ParseFeaturesRequest(
    const std::vector<std::string>& arguments) {
  FeaturesRequest request;
  CommandWords words = DescribeFeatures(&request);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          words.ParseAndApply(arguments));
  FREEGS_RETURN_IF_ERROR(request.upsampling.Check());
  if (ValidUtf8(request.text) != request.text) {
    return InvalidArgumentError("--text: the words are not UTF-8");
  }
  request.image = positional[0];
  if (request.out.empty()) {
    request.out = request.image.stem().string() + "_heat.png";
  }
  if (!CanWriteImage(request.out)) {
    return InvalidArgumentError(
        "--out " + request.out +
        ": the suffix says the format; give .png or .jpg");
  }
  for (const std::string& place : {request.out, request.cache}) {
    FREEGS_RETURN_IF_ERROR(CheckOutputPlace(place));
  }
  std::error_code error;
  if (fs::equivalent(request.out, request.image, error)) {
    return InvalidArgumentError("--out " + request.out +
                                ": would replace the photo; give another name");
  }
  FREEGS_ASSIGN_OR_RETURN(const fs::path out, PrepareOutputFile(request.out));
  request.out = out.string();
  return request;
}

ImageU8 LimitedTo(const ImageU8& image, int longest_side) {
  const int longest = std::max(image.width(), image.height());
  if (longest <= longest_side) return image;
  const auto scaled = [&](int side) {
    return std::max(1,
                    static_cast<int>(std::lround(static_cast<double>(side) *
                                                 longest_side / longest)));
  };
  return Resize(image, scaled(image.width()), scaled(image.height()));
}

}  // namespace

CommandWords FeaturesWords() {
  return KeepWords<FeaturesRequest>(DescribeFeatures);
}

Status RunFeaturesCommand(const std::vector<std::string>& arguments,
                          CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const FeaturesRequest request,
                          ParseFeaturesRequest(arguments));
  FREEGS_ASSIGN_OR_RETURN(const UprightPhoto photo,
                          ReadUprightPhoto(request.image));
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<semantics::OpenCvClip> encoder,
                          OpenClipModel(request.model));

  FREEGS_ASSIGN_OR_RETURN(const semantics::TextEmbedding text,
                          semantics::EncodeWords(request.text, *encoder));
  if (text.truncated) {
    context.err << "features: the words are too long for the model; it sees "
                   "only their beginning\n";
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> canonical,
                          semantics::EncodeCanonicalPhrases(*encoder));
  if (context.cancellation.cancelled()) {
    return InterruptedError("features: stopped");
  }
  FREEGS_ASSIGN_OR_RETURN(
      ImageF features,
      request.cache.empty()
          ? encoder->EncodeDense(photo.pixels, request.dense_size)
          : semantics::EncodeDenseCached(*encoder,
                                         semantics::FeatureCache(request.cache),
                                         photo.hash,
                                         photo.pixels,
                                         request.dense_size));

  // The upsampler belongs to dense.onnx; networks of other sizes have none.
  if (encoder->upsampled_size() > 0 &&
      (request.dense_size == 0 ||
       request.dense_size == encoder->dense_sizes()[0])) {
    FREEGS_ASSIGN_OR_RETURN(features,
                            encoder->Upsample(features, photo.pixels));
  }

  const ImageU8 picture = LimitedTo(photo.pixels, request.size);
  ThreadPool pool(pipeline::WorkingThreads(request.threads));
  FREEGS_ASSIGN_OR_RETURN(const ImageF relevancy,
                          semantics::RelevancyMap(features,
                                                  ToFloat(picture),
                                                  text.values,
                                                  canonical,
                                                  request.upsampling,
                                                  pool));
  const auto [least, most] = std::minmax_element(
      relevancy.data(), relevancy.data() + relevancy.size());
  const fs::path out(request.out);
  const double high = std::max<double>(kFullRelevancy, *most);
  FREEGS_RETURN_IF_ERROR(
      WriteImage(out, HeatMap(picture, relevancy, kNoRelevancy, high)));
  const auto place = static_cast<int>(most - relevancy.data());
  context.out << "relevancy " << FormatFixed(*least, 3) << " .. "
              << FormatFixed(*most, 3) << ", highest at ("
              << place % picture.width() << ", " << place / picture.width()
              << ") of " << picture.width() << " x " << picture.height()
              << "\n";
  return Status();
}

}  // namespace freegs::stages
