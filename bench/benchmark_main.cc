// SPDX-License-Identifier: BSD-3-Clause
// The main function of the benchmarks. Beside the options of Google Benchmark
// it takes --simd NAME, one of the instruction sets that `freegs_pipeline
// doctor` lists, such as AVX2: the SIMD code then runs with this one.

#include <cstring>
#include <iostream>
#include <string>

#include <benchmark/benchmark.h>
#include <hwy/highway.h>
#include <hwy/targets.h>

namespace {

// Returns false when this machine or this program does not have it.
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

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc == 3 && std::strcmp(argv[1], "--simd") == 0) {
    if (!UseInstructionSet(argv[2])) {
      std::cerr << "this machine does not have --simd " << argv[2] << "\n";
      return 2;
    }
    argc = 1;
  }
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
