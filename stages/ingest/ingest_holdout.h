// SPDX-License-Identifier: BSD-3-Clause
// Tells when other photos are kept from training than in the last run.

#ifndef FREEGS_STAGES_INGEST_INGEST_HOLDOUT_H_
#define FREEGS_STAGES_INGEST_INGEST_HOLDOUT_H_

#include "photos/photo_list.h"
#include "pipeline/stage.h"

namespace freegs::stages {

// Warns if the holdout photos of the list are not those of the result of ingest
// that the workspace has: a photo that comes or goes shifts which ones a rule
// holds out. Nothing without such a result, or if it had no holdout photos.
void WarnOfOtherHoldout(const pipeline::StageContext& context,
                        const photos::PhotoList& list);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_HOLDOUT_H_
