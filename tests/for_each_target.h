// SPDX-License-Identifier: BSD-3-Clause
// Runs a test once with every instruction set that this machine has.

#ifndef FREEGS_TESTS_FOR_EACH_TARGET_H_
#define FREEGS_TESTS_FOR_EACH_TARGET_H_

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace freegs {

// All code that Highway dispatches runs with the same instruction set while
// `body` runs. Afterwards the best one is chosen again.
template <class Body>
void ForEachTarget(const Body& body) {
  const auto all = hwy::SupportedTargets();
  for (auto rest = all; rest != 0; rest &= rest - 1) {
    const auto target = rest & -rest;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    SCOPED_TRACE(hwy::TargetName(target));
    body();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace freegs

#endif  // FREEGS_TESTS_FOR_EACH_TARGET_H_
