// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/version_text.h"

#include <cstdint>

#include <hwy/highway.h>
#include <hwy/targets.h>

#include "pipeline/version.h"

namespace freegs::stages {

std::string InstructionSets() {
  std::string names;
  for (int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0;
       left &= left - 1) {
    const int64_t lowest = left & -left;
    names += (names.empty() ? "" : ", ") + std::string(hwy::TargetName(lowest));
  }
  // Highway's best target has the lowest bit.
  return names.empty() ? "none" : names + " (the first is used)";
}

std::string VersionText(std::string_view commit) {
  std::string text = "freegs_pipeline ";
  text += pipeline::kProgramVersion;
  text += "\ncommit ";
  text += commit;
  text += "\ninstruction sets " + InstructionSets();
  return text + "\nlicence BSD-3-Clause\n";
}

}  // namespace freegs::stages
