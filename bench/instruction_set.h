// SPDX-License-Identifier: BSD-3-Clause
// Makes a benchmark run on a lower instruction set than the machine has.

#ifndef FREEGS_BENCH_INSTRUCTION_SET_H_
#define FREEGS_BENCH_INSTRUCTION_SET_H_

#include <string>

namespace freegs::bench {

// From now on the SIMD code runs with this instruction set alone, one of those
// that `freegs_pipeline doctor` lists, such as "AVX2". Returns false, and
// changes nothing, when this machine or this program does not have it. To be
// called before other threads begin.
bool UseInstructionSet(const std::string& name);

}  // namespace freegs::bench

#endif  // FREEGS_BENCH_INSTRUCTION_SET_H_
