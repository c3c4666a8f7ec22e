// SPDX-License-Identifier: BSD-3-Clause
// The interface to a CLIP model. It turns images and words into vectors of one
// space (Radford et al. 2021), and also every part of an image (MaskCLIP; Zhou
// et al. 2022). Another inference engine than OpenCV would implement this
// interface.
//
//   FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<OpenCvClip> encoder,
//                           OpenCvClip::Open(folder));
//   FREEGS_ASSIGN_OR_RETURN(const ImageF places, encoder->EncodeDense(image));
//   FREEGS_ASSIGN_OR_RETURN(const TextEmbedding text,
//                           encoder->EncodeText("a red mug"));
//   // The cosine of a place and text.values says how well they match.

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
  bool has_words = true;      // False for blanks of any kind.
};

// Several threads may encode images at once, with the same results; texts only
// one at a time. Images are RGB with 8 bits and not empty, else the error is
// kInvalidArgument. A model that cannot be loaded, or whose output has the
// wrong shape, gives kMissingDependency with the name of the file.
class ClipEncoder {
 public:
  virtual ~ClipEncoder() = default;

  // D, the size of the vectors of images, places and texts.
  virtual int embedding_dim() const = 0;

  // Identifies what the model computes. Caches use it as a key.
  virtual const std::string& model_hash() const = 0;

  // Phrases that say nothing in particular. A text is relevant if it beats
  // these (see relevancy.h). The phrases are those of LERF unless the model has
  // its own.
  virtual std::vector<std::string> canonical_phrases() const {
    return {"object", "things", "stuff", "texture"};
  }

  // The image sizes in pixels that EncodeDense takes, the default first.
  virtual std::vector<int> dense_sizes() const = 0;

  // Returns D numbers of length 1 for the central square of the image. The
  // short side is resized to the size of the network and the long side is
  // cropped, as in CLIP's training.
  virtual StatusOr<std::vector<float>> EncodeImage(const ImageU8& image) = 0;

  // Returns features of the whole image, grid x grid x D. They are not
  // normalised; their length says how much there is to see. The image is
  // stretched to a square, so that cell (x, y) covers the same share of the
  // width and height of the image as of the grid. dense_size is one of
  // dense_sizes(), else the error is kInvalidArgument; 0 takes the default.
  virtual StatusOr<ImageF> EncodeDense(const ImageU8& image,
                                       int dense_size = 0) = 0;

  // Width and height of what Upsample() returns. 0 if the model has no
  // upsampler.
  virtual int upsampled_size() const = 0;

  // Brings features to the detail of the image by an upsampler that comes with
  // the model (such as FeatUp). Returns upsampled_size() x upsampled_size() x
  // D. `features` is what EncodeDense gave for the same image at the default
  // size. kInvalidArgument for features of another shape and for a model
  // without an upsampler.
  virtual StatusOr<ImageF> Upsample(const ImageF& features,
                                    const ImageU8& image) = 0;

  // Errors also as BytePairTokenizer::Tokenize.
  virtual StatusOr<TextEmbedding> EncodeText(const std::string& text) = 0;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_CLIP_ENCODER_H_
