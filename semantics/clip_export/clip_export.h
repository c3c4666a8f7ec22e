// SPDX-License-Identifier: BSD-3-Clause
// Makes a model folder (semantics/clip/model_folder.h) of a CLIP's weights:
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const ModelInfo info,
//       ExportClip({.checkpoint = "clip-vit-base-patch16"}, "model", nullptr));

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_EXPORT_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_EXPORT_H_

#include <filesystem>

#include "core/cancellation.h"
#include "core/status.h"
#include "semantics/clip/model_info.h"

namespace freegs::semantics {

struct ClipExportOptions {
  // A .safetensors file or the folder of one, see ClipCheckpoint::Open.
  std::filesystem::path checkpoint = {};

  // Byte-pair merges, see BytePairTokenizer; empty for merges.txt beside the
  // weights.
  std::filesystem::path merges = {};

  // Another image size in pixels for dense features, beside the model's own; a
  // multiple of its patch. 0 for none.
  int dense_size = 0;

  Status Check() const;
};

// Writes the folder `out` and returns what its model.json says. The files are
// written into OUT.part, which takes the place of `out` when all are there; an
// `out` that exists is OUT.replaced.part meanwhile. What an export that was
// stopped has left there is removed. An `out` that is neither missing, an empty
// folder nor a model folder is refused, as is a folder of these two names that
// holds other things, and as are weights that are not there: kBadInput.
// kMissingDependency for everything else that is wrong with the weights and the
// files beside them, and kInvalidArgument for a dense size that does not fit
// them. kInterrupted when cancelled (`cancellation` may be null). Unless it
// succeeds, `out` is as before. Memory: about twice the size of the largest
// network.
StatusOr<ModelInfo> ExportClip(const ClipExportOptions& options,
                               const std::filesystem::path& out,
                               const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_EXPORT_H_
