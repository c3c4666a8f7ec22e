// SPDX-License-Identifier: BSD-3-Clause
// The main function of the benchmarks. Beside the options of Google Benchmark
// it takes --simd NAME, one of the instruction sets that `freegs_pipeline
// doctor` lists, such as AVX2: the SIMD code then runs with this one.

#include <cstring>
#include <iostream>

#include <benchmark/benchmark.h>

#include "bench/instruction_set.h"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc == 3 && std::strcmp(argv[1], "--simd") == 0) {
    if (!freegs::bench::UseInstructionSet(argv[2])) {
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
