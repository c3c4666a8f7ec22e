// SPDX-License-Identifier: BSD-3-Clause
// The program of one reader, which FREEGS_FUZZ_READER names, for libFuzzer.
//
//   PROGRAM --seeds=FOLDER     writes the reader's good files and ends
//   PROGRAM FOLDER ...         libFuzzer with its own options

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
Reader FREEGS_FUZZ_READER();
}  // namespace freegs::fuzz

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  constexpr std::string_view kSeeds = "--seeds=";
  for (int i = 1; i < *argc; ++i) {
    const std::string_view argument = (*argv)[i];
    if (!argument.starts_with(kSeeds)) continue;
    const std::filesystem::path folder = argument.substr(kSeeds.size());
    int count = 0;
    for (const std::string& seed : freegs::fuzz::FREEGS_FUZZ_READER().seeds()) {
      freegs::WriteText(folder / ("seed_" + std::to_string(count++)), seed);
    }
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const freegs::fuzz::Reader reader = freegs::fuzz::FREEGS_FUZZ_READER();
  reader.read({reinterpret_cast<const char*>(data), size});
  return 0;
}
