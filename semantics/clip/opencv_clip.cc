// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/opencv_clip.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/dnn/layer.hpp>

#include "core/io/files.h"
#include "core/out_of_memory.h"
#include "core/text.h"
#include "semantics/clip/bicubic_resize.h"
#include "semantics/clip/network_check.h"

namespace freegs::semantics {
namespace {

// Copies of a network, for threads that use it at once, may need about this
// many bytes together.
constexpr uintmax_t kMaxCopiedBytes = 256 << 20;

// The first line of the message of an OpenCV exception.
std::string Reason(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

Status CheckImage(const ImageU8& image) {
  if (image.empty() || image.channels() != 3) {
    return InvalidArgumentError(
        "an image to encode must not be empty and have three channels");
  }
  return Status();
}

// 1 x 3 x H x W with mean and standard deviation taken out.
cv::Mat ToBlob(const ImageU8& image, const ModelInfo& info) {
  const int shape[] = {1, 3, image.height(), image.width()};
  cv::Mat blob(4, shape, CV_32F);
  for (int c = 0; c < 3; ++c) {
    float* out = blob.ptr<float>(0, c);
    for (size_t i = 0; i < image.num_pixels(); ++i) {
      out[i] = (static_cast<float>(image.data()[3 * i + c]) / 255.0f -
                info.mean[c]) /
               info.std[c];
    }
  }
  return blob;
}

// 1 x C x H x W of an image, and back.
cv::Mat ToChannels(const ImageF& image) {
  const int shape[] = {1, image.channels(), image.height(), image.width()};
  cv::Mat blob(4, shape, CV_32F);
  float* out = blob.ptr<float>();
  const auto channels = static_cast<size_t>(image.channels());
  for (size_t c = 0; c < channels; ++c) {
    for (size_t i = 0; i < image.num_pixels(); ++i) {
      *out++ = image.data()[i * channels + c];
    }
  }
  return blob;
}

ImageF FromChannels(const cv::Mat& blob) {
  ImageF image(blob.size[3], blob.size[2], blob.size[1]);
  const auto channels = static_cast<size_t>(image.channels());
  const float* in = blob.ptr<float>();
  for (size_t c = 0; c < channels; ++c) {
    for (size_t i = 0; i < image.num_pixels(); ++i) {
      image.data()[i * channels + c] = *in++;
    }
  }
  return image;
}

// An input of a network. A network of one input takes any name.
struct NetworkInput {
  std::string name;
  cv::Mat blob;
};

std::string ShapeText(const cv::Mat& blob) {
  std::string text;
  for (int i = 0; i < blob.dims; ++i) {
    text += (i > 0 ? " x " : "") + std::to_string(blob.size[i]);
  }
  return text;
}

// False if the vector has no direction: it is zero.
bool Normalize(std::span<float> vector) {
  double sum = 0;
  for (const float value : vector) sum += static_cast<double>(value) * value;
  if (!(sum > 0)) return false;
  const double scale = 1 / std::sqrt(sum);
  for (float& value : vector) value = static_cast<float>(value * scale);
  return true;
}

}  // namespace

ImageU8 CenterSquare(const ImageU8& image, int size) {
  const int short_side = std::min(image.width(), image.height());
  const auto resized = [size, short_side](int side) {
    return static_cast<int>(int64_t{size} * side / short_side);
  };
  const int width = resized(image.width());
  const int height = resized(image.height());
  // Half a pixel is rounded to the even number.
  const auto offset = [size](int side) {
    return static_cast<int>(std::nearbyint((side - size) / 2.0));
  };
  return ResizeBicubic(
      image, width, height, {offset(width), offset(height), size, size});
}

// The networks of a folder. Each use has a network of its own, since networks
// keep buffers; OpenCV runs small ones on one thread.
class OpenCvClip::Networks {
 public:
  // OpenCV makes the table of its layers at the first use, and its guard
  // against two first uses at once is a data race. So the first use is here.
  Networks() { cv::dnn::LayerFactory::isLayerRegistered("Identity"); }

  // Runs a network of the folder. Loads it first if it is not loaded yet. Waits
  // if all copies that there may be are in use.
  StatusOr<cv::Mat> Forward(const ModelFolder& folder,
                            const std::string& name,
                            const std::vector<NetworkInput>& inputs,
                            const std::vector<int>& output_shape) {
    Use use(this, folder, name);
    return Run(folder, name, inputs, output_shape, use.network());
  }

 private:
  // Keeps OpenCV from writing errors of networks to stderr, which a library
  // must not do, while at least one network is in use. The level belongs to the
  // process, so it is restored. The caller keeps threads apart.
  class QuietOpenCv {
   public:
    void Begin() {
      if (users_++ > 0) return;
      level_ =
          cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    }
    void End() {
      if (--users_ == 0) cv::utils::logging::setLogLevel(level_);
    }

   private:
    int users_ = 0;
    cv::utils::logging::LogLevel level_ = cv::utils::logging::LOG_LEVEL_INFO;
  };

  struct Copies {
    std::vector<cv::dnn::Net> free;
    size_t count = 0;  // Also those in use.
    size_t max_count = 1;
  };

  // Takes a network and gives it back at the end of its life, also when memory
  // runs out in between. Otherwise threads that wait for it would wait for
  // ever.
  class Use {
   public:
    Use(Networks* networks, const ModelFolder& folder, const std::string& name)
        : networks_(networks),
          name_(name),
          network_(networks->Take(folder, name)) {}
    ~Use() { networks_->GiveBack(name_, std::move(network_)); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

    std::optional<cv::dnn::Net>* network() { return &network_; }

   private:
    Networks* const networks_;
    const std::string& name_;
    std::optional<cv::dnn::Net> network_;
  };

  // Nothing if the network has yet to be loaded.
  std::optional<cv::dnn::Net> Take(const ModelFolder& folder,
                                   const std::string& name) {
    std::unique_lock lock(mutex_);
    Copies& copies = copies_[name];
    if (copies.count == 0) {
      std::error_code error;
      const uintmax_t bytes =
          std::filesystem::file_size(folder.path / name, error);
      if (!error && bytes > 0) {
        copies.max_count = std::max<size_t>(1, kMaxCopiedBytes / bytes);
      }
    }
    given_back_.wait(lock, [&copies] {
      return !copies.free.empty() || copies.count < copies.max_count;
    });
    // So that GiveBack, which must not throw, needs no memory.
    copies.free.reserve(copies.count + 1);
    quiet_.Begin();
    if (copies.free.empty()) {
      ++copies.count;
      return std::nullopt;
    }
    cv::dnn::Net network = std::move(copies.free.back());
    copies.free.pop_back();
    return network;
  }

  void GiveBack(const std::string& name, std::optional<cv::dnn::Net> network) {
    const std::lock_guard lock(mutex_);
    quiet_.End();
    Copies& copies = copies_[name];
    if (network) {
      copies.free.push_back(*std::move(network));
    } else {
      --copies.count;
    }
    given_back_.notify_all();
  }

  // Empties `network` if it cannot be loaded.
  static StatusOr<cv::Mat> Run(const ModelFolder& folder,
                               const std::string& name,
                               const std::vector<NetworkInput>& inputs,
                               const std::vector<int>& output_shape,
                               std::optional<cv::dnn::Net>* network) {
    if (!*network) {
      FREEGS_ASSIGN_OR_RETURN(const std::string content,
                              ReadFile(folder.path / name));
      const std::string fault = FaultOfNetwork(content);
      if (!fault.empty()) return folder.FileError(name, fault);
      try {
        cv::dnn::Net net =
            cv::dnn::readNetFromONNX((folder.path / name).string());
        if (net.empty()) return folder.FileError(name, "no network in it");
        net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
        net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
        *network = std::move(net);
      } catch (const std::exception& error) {
        if (IsOutOfMemory(error)) return OutOfMemoryError();
        return folder.FileError(name,
                                "OpenCV cannot load it: " + Reason(error));
      }
    }
    cv::Mat output;
    try {
      for (const NetworkInput& input : inputs) {
        (*network)->setInput(input.blob, input.name);
      }
      // A copy, because the network overwrites its output at the next call.
      output = (*network)->forward().clone();
    } catch (const std::exception& error) {
      if (IsOutOfMemory(error)) return OutOfMemoryError();
      return folder.FileError(name, "OpenCV cannot run it: " + Reason(error));
    }
    const std::vector<int> shape(output.size.p, output.size.p + output.dims);
    if (shape != output_shape || output.type() != CV_32F) {
      return folder.FileError(
          name,
          "its output of " + ShapeText(output) + " is not what it should be");
    }
    const float* values = output.ptr<float>();
    if (!std::all_of(values, values + output.total(), [](float value) {
          return std::isfinite(value);
        })) {
      return folder.FileError(name, "its output is not finite");
    }
    return output;
  }

  std::mutex mutex_;
  std::condition_variable given_back_;
  std::map<std::string, Copies> copies_;
  QuietOpenCv quiet_;
};

OpenCvClip::OpenCvClip(ModelFolder folder)
    : folder_(std::move(folder)),
      model_hash_(folder_.info.Hash()),
      networks_(std::make_unique<Networks>()) {}

OpenCvClip::~OpenCvClip() = default;

StatusOr<std::unique_ptr<OpenCvClip>> OpenCvClip::Open(
    const std::filesystem::path& folder) {
  FREEGS_ASSIGN_OR_RETURN(ModelFolder model, ModelFolder::Open(folder));
  return std::unique_ptr<OpenCvClip>(new OpenCvClip(std::move(model)));
}

int OpenCvClip::embedding_dim() const { return info().embedding_dim; }

const std::string& OpenCvClip::model_hash() const { return model_hash_; }

std::vector<std::string> OpenCvClip::canonical_phrases() const {
  return info().canonical.empty() ? ClipEncoder::canonical_phrases()
                                  : info().canonical;
}

std::vector<int> OpenCvClip::dense_sizes() const {
  std::vector<int> sizes;
  for (const DenseNetwork& network : info().dense) {
    sizes.push_back(network.image_size);
  }
  return sizes;
}

StatusOr<std::vector<float>> OpenCvClip::EncodeImage(const ImageU8& image) {
  FREEGS_RETURN_IF_ERROR(CheckImage(image));
  FREEGS_ASSIGN_OR_RETURN(
      const cv::Mat output,
      networks_->Forward(
          folder_,
          "visual.onnx",
          {{"", ToBlob(CenterSquare(image, info().image_size), info())}},
          {1, embedding_dim()}));
  std::vector<float> embedding(output.ptr<float>(),
                               output.ptr<float>() + output.total());
  if (!Normalize(embedding)) {
    return folder_.FileError("visual.onnx", "its output is zero");
  }
  return embedding;
}

StatusOr<ImageF> OpenCvClip::EncodeDense(const ImageU8& image, int dense_size) {
  FREEGS_RETURN_IF_ERROR(CheckImage(image));
  if (dense_size == 0) dense_size = info().dense[0].image_size;
  const auto network = std::find_if(info().dense.begin(),
                                    info().dense.end(),
                                    [dense_size](const DenseNetwork& known) {
                                      return known.image_size == dense_size;
                                    });
  if (network == info().dense.end()) {
    std::vector<std::string> sizes;
    for (const int size : dense_sizes()) sizes.push_back(std::to_string(size));
    return InvalidArgumentError(folder_.path.string() +
                                " has no dense network for images of " +
                                std::to_string(dense_size) +
                                " pixels; it has those for " + Joined(sizes));
  }
  const int grid = network->grid;
  const int dim = embedding_dim();
  FREEGS_ASSIGN_OR_RETURN(
      const cv::Mat output,
      networks_->Forward(
          folder_,
          network->file,
          {{"", ToBlob(ResizeBicubic(image, dense_size, dense_size), info())}},
          {1, dim, grid, grid}));
  return FromChannels(output);
}

int OpenCvClip::upsampled_size() const { return info().upsampled_size; }

StatusOr<ImageF> OpenCvClip::Upsample(const ImageF& features,
                                      const ImageU8& image) {
  FREEGS_RETURN_IF_ERROR(CheckImage(image));
  const DenseNetwork& network = info().dense[0];
  const int size = upsampled_size();
  if (size == 0) {
    return InvalidArgumentError(folder_.path.string() + " has no upsampler");
  }
  if (features.width() != network.grid || features.height() != network.grid ||
      features.channels() != embedding_dim()) {
    return InvalidArgumentError(
        "the upsampler takes the features of an image of " +
        std::to_string(network.image_size) + " pixels");
  }
  FREEGS_ASSIGN_OR_RETURN(
      const cv::Mat output,
      networks_->Forward(
          folder_,
          "upsampler.onnx",
          {{"features", ToChannels(features)},
           {"image",
            ToBlob(ResizeBicubic(image, network.image_size, network.image_size),
                   info())}},
          {1, embedding_dim(), size, size}));
  return FromChannels(output);
}

StatusOr<TextEmbedding> OpenCvClip::EncodeText(const std::string& text) {
  if (text_ == nullptr) {
    FREEGS_ASSIGN_OR_RETURN(BytePairTokenizer tokenizer,
                            folder_.LoadTokenizer());
    FREEGS_ASSIGN_OR_RETURN(TokenTable table, folder_.LoadTokenTable());
    text_ = std::make_unique<TextParts>(
        TextParts{std::move(tokenizer), std::move(table)});
  }
  const int context = info().context_length;
  FREEGS_ASSIGN_OR_RETURN(const TokenizedText tokens,
                          text_->tokenizer.Tokenize(text, context));
  // CLIP pads with token 0. Attention in the text encoder is causal, so that
  // what follows the end token does not change the result.
  const int width = info().text_width;
  const int shape[] = {1, context, width};
  cv::Mat input(3, shape, CV_32F);
  for (int i = 0; i < context; ++i) {
    const auto k = static_cast<size_t>(i);
    text_->table.CopyRow(k < tokens.ids.size() ? tokens.ids[k] : 0,
                         {input.ptr<float>(0, i), static_cast<size_t>(width)});
  }
  const int dim = embedding_dim();
  FREEGS_ASSIGN_OR_RETURN(
      const cv::Mat output,
      networks_->Forward(
          folder_, "text.onnx", {{"", input}}, {1, context, dim}));
  // As CLIP does, also where the text itself holds an end token.
  const auto end = std::find(
      tokens.ids.begin(), tokens.ids.end(), text_->tokenizer.end_token());
  const float* row =
      output.ptr<float>(0, static_cast<int>(end - tokens.ids.begin()));
  // Besides words there are the tokens of the start and the end.
  TextEmbedding embedding{.values = {row, row + dim},
                          .truncated = tokens.truncated,
                          .has_words = tokens.ids.size() > 2};
  if (!Normalize(embedding.values)) {
    return folder_.FileError("text.onnx", "its output is zero");
  }
  return embedding;
}

}  // namespace freegs::semantics
