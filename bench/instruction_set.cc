// SPDX-License-Identifier: BSD-3-Clause

#include "bench/instruction_set.h"

#include <hwy/highway.h>
#include <hwy/targets.h>

namespace freegs::bench {

bool UseInstructionSet(const std::string& name) {
  for (auto rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0;
       rest &= rest - 1) {
    const auto target = rest & -rest;
    if (name != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return true;
  }
  return false;
}

}  // namespace freegs::bench
