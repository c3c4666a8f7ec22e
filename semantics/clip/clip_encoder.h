// SPDX-License-Identifier: BSD-3-Clause
// Images and words as vectors of one space (CLIP; Radford et al. 2021), and the
// same for every part of an image (MaskCLIP; Zhou et al. 2022). The one place
// that other engines than OpenCV would have to fill.

#ifndef FREEGS_SEMANTICS_CLIP_CLIP_ENCODER_H_
#define FREEGS_SEMANTICS_CLIP_CLIP_ENCODER_H_

#include <string>
#include <vector>

#include "core/image.h"
#include "core/status.h"

namespace freegs::semantics {

struct TextEmbedding {
  std::vector<float> values;  // D, of length 1.
  bool truncated = false;     // True if the text was too long and was cut.
};

// Not thread-safe: networks keep buffers from call to call. Images are RGB,
// 8 bits, not empty, else kInvalidArgument. A model that cannot be loaded or
// gives what it should not is kMissingDependency, naming the file.
class ClipEncoder {
 public:
  virtual ~ClipEncoder() = default;

  // D: how many numbers an image, a place or a text is.
  virtual int embedding_dim() const = 0;

  // What identifies the model's results, for caches.
  virtual const std::string& model_hash() const = 0;

  // What says nothing in particular: a text must beat these to be relevant (see
  // relevancy.h). Those of LERF, unless the model has its own.
  virtual std::vector<std::string> canonical_phrases() const {
    return {"object", "things", "stuff", "texture"};
  }

  // Image sizes in pixels that EncodeDense takes, the default first.
  virtual std::vector<int> dense_sizes() const = 0;

  // D numbers of length 1 for the image's central square: its short side is
  // resized to the network's and the long side cropped, as CLIP was trained.
  virtual StatusOr<std::vector<float>> EncodeImage(const ImageU8& image) = 0;

  // grid x grid x D features of the whole image, not normalised: their length
  // says how much there is to see. The image is stretched to a square, so that
  // cell (x, y) covers the same share of width and height in the image as in
  // the grid. dense_size is one of dense_sizes(), else kInvalidArgument; 0
  // takes the default.
  virtual StatusOr<ImageF> EncodeDense(const ImageU8& image,
                                       int dense_size = 0) = 0;

  // Width and height of what Upsample gives; 0 when the model brings no
  // upsampler of its own.
  virtual int upsampled_size() const = 0;

  // Features in the detail of the image by an upsampler that the model brings
  // (such as FeatUp's): upsampled_size() x upsampled_size() x D. `features` are
  // what EncodeDense gave for the same image at the default size.
  // kInvalidArgument for features of another shape and without an upsampler.
  virtual StatusOr<ImageF> Upsample(const ImageF& features,
                                    const ImageU8& image) = 0;

  // Errors also as BytePairTokenizer::Tokenize.
  virtual StatusOr<TextEmbedding> EncodeText(const std::string& text) = 0;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_CLIP_ENCODER_H_
