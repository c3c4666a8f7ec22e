// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_holdout.h"

#include <set>
#include <string>

namespace freegs::stages {
namespace {

std::set<std::string> HeldOut(const photos::PhotoList& list) {
  std::set<std::string> files;
  for (const photos::Photo& photo : list.photos) {
    if (photo.split == photos::PhotoSplit::kHoldout) files.insert(photo.file);
  }
  return files;
}

}  // namespace

void WarnOfOtherHoldout(const pipeline::StageContext& context,
                        const photos::PhotoList& list) {
  const auto before =
      photos::ReadPhotoList(context.workspace / "ingest" / "images.json");
  if (!before.ok()) return;
  const std::set<std::string> held_out = HeldOut(*before);
  if (held_out.empty() || held_out == HeldOut(list)) return;
  context.log(pipeline::LogLevel::kWarning,
              "the photos that are kept from training are not those of the "
              "last run, so figures like holdout_psnr do not compare; "
              "ingest.holdout_list can keep them");
}

}  // namespace freegs::stages
