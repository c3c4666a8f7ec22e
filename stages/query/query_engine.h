// SPDX-License-Identifier: BSD-3-Clause
// Finds the answer to a question.

#ifndef FREEGS_STAGES_QUERY_QUERY_ENGINE_H_
#define FREEGS_STAGES_QUERY_QUERY_ENGINE_H_

#include <memory>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/clip/opencv_clip.h"
#include "stages/query/query_answer.h"
#include "stages/query/query_request.h"
#include "stages/query/query_scene.h"

namespace freegs::stages {

// What questions by words and by example need. It is filled by the first of
// them, and the next ones of the same scene are answered faster.
struct QueryNetworks {
  std::unique_ptr<semantics::OpenCvClip> clip;
  std::vector<float> canonical;  // See semantics::EncodeCanonicalPhrases.
};

// Answers one question. `scene` must have what LoadQueryScene loads for the
// request; a click with a level changes its labels and adds an instance.
// load_ms, masks_ms and masks of the answer are left alone.
//
// kInvalidArgument for an unknown view and for a pixel outside the view;
// kBadInput for a file that is missing or malformed; kMissingDependency when
// the CLIP model is missing or is not the one of the scene's features.
StatusOr<QueryAnswer> FindAnswer(const QueryRequest& request,
                                 ThreadPool& pool,
                                 QueryScene* scene,
                                 QueryNetworks* networks);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_ENGINE_H_
