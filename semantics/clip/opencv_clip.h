// SPDX-License-Identifier: BSD-3-Clause
// Runs CLIP with OpenCV's DNN module on the processor.

#ifndef FREEGS_SEMANTICS_CLIP_OPENCV_CLIP_H_
#define FREEGS_SEMANTICS_CLIP_OPENCV_CLIP_H_

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"
#include "semantics/clip/model_folder.h"

namespace freegs::semantics {

// See clip_encoder.h for an example.
class OpenCvClip : public ClipEncoder {
 public:
  // Checks the folder (see ModelFolder::Open). Each network is loaded when it
  // is first used, so that a text query does not load an image network.
  static StatusOr<std::unique_ptr<OpenCvClip>> Open(
      const std::filesystem::path& folder);
  ~OpenCvClip() override;

  const ModelInfo& info() const { return folder_.info; }

  int embedding_dim() const override;
  const std::string& model_hash() const override;
  std::vector<std::string> canonical_phrases() const override;
  std::vector<int> dense_sizes() const override;
  StatusOr<std::vector<float>> EncodeImage(const ImageU8& image) override;
  StatusOr<ImageF> EncodeDense(const ImageU8& image,
                               int dense_size = 0) override;
  int upsampled_size() const override;
  StatusOr<ImageF> Upsample(const ImageF& features,
                            const ImageU8& image) override;
  StatusOr<TextEmbedding> EncodeText(const std::string& text) override;

 private:
  class Networks;  // Keeps OpenCV's headers out of this one.
  struct TextParts {
    BytePairTokenizer tokenizer;
    TokenTable table;
  };

  explicit OpenCvClip(ModelFolder folder);

  const ModelFolder folder_;
  const std::string model_hash_;
  std::unique_ptr<Networks> networks_;
  std::unique_ptr<TextParts> text_;
};

// Returns the square of an image that CLIP sees: the short side is resized to
// `size` and the centre is cropped, to the same pixels as in torchvision. The
// image must not be empty.
ImageU8 CenterSquare(const ImageU8& image, int size);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_OPENCV_CLIP_H_
