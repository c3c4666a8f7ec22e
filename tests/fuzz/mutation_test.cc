// SPDX-License-Identifier: BSD-3-Clause
// Fuzzing in short, in every build: each reader gets its good files with a few
// places changed, 10000 times or for a second. scripts/fuzz.sh looks deeper,
// since it sees which inputs reach new code.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <sys/resource.h>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {

#define FREEGS_READER(name) Reader name();
#include "generated/fuzz_readers.inc"
#undef FREEGS_READER

namespace {

struct NamedReader {
  const char* name;
  Reader (*reader)();
};
constexpr NamedReader kReaders[] = {
#define FREEGS_READER(name) {#name, name},
#include "generated/fuzz_readers.inc"
#undef FREEGS_READER
};

// A fast reader gets the same inputs on every machine; a slow one, such as that
// of networks, does not hold up the tests.
constexpr uint64_t kNumInputs = 10000;
constexpr std::chrono::seconds kTime(1);

// Address space for the test program, its libraries and threads. A reader that
// believes a file's claim of more gets std::bad_alloc, which fails the test.
constexpr rlim_t kMemory = rlim_t{6} << 30;

// Numbers at which sizes and counts overflow.
constexpr std::array<uint64_t, 10> kNumbers = {0,
                                               1,
                                               0x7f,
                                               0xff,
                                               0xffff,
                                               0x7fffffff,
                                               0xffffffff,
                                               uint64_t{1} << 32,
                                               0x7fffffffffffffff,
                                               0xffffffffffffffff};
constexpr std::array<const char*, 6> kTexts = {
    "-1", "1e309", "nan", "99999999999999999999", "[[[[[[[[", "../../x"};

void ChangeOnePlace(const std::vector<std::string>& seeds,
                    RandomStream* random,
                    std::string* bytes) {
  const size_t at = random->Index(bytes->size() + 1);
  const size_t rest = bytes->size() - at;
  switch (random->Index(7)) {
    case 0:
      if (rest > 0) (*bytes)[at] ^= static_cast<char>(1 << random->Index(8));
      break;
    case 1: {
      const uint64_t number = kNumbers[random->Index(kNumbers.size())];
      const size_t size = std::min(rest, size_t{1} << random->Index(4));
      for (size_t k = 0; k < size; ++k) {
        (*bytes)[at + k] = static_cast<char>(number >> (8 * k));
      }
      break;
    }
    case 2:
      bytes->resize(at);
      break;
    case 3:
      bytes->erase(at, random->Index(17));
      break;
    case 4:
      bytes->insert(at, bytes->substr(at, random->Index(65)));
      break;
    case 5: {
      const std::string& other = seeds[random->Index(seeds.size())];
      if (other.empty()) break;
      bytes->replace(
          at,
          random->Index(33),
          other.substr(random->Index(other.size()), random->Index(33)));
      break;
    }
    default: {
      // In place of a number, in formats that are text.
      const size_t digit = bytes->find_first_of("0123456789", at);
      if (digit == std::string::npos) break;
      const size_t end = bytes->find_first_not_of("0123456789.", digit);
      bytes->replace(digit,
                     std::min(end, bytes->size()) - digit,
                     kTexts[random->Index(kTexts.size())]);
    }
  }
}

class MutationTest : public testing::TestWithParam<NamedReader> {
 protected:
  static void SetUpTestSuite() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    rlimit limit = {};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &limit), 0);
    limit.rlim_cur = std::min(kMemory, limit.rlim_max);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
#endif
  }
};

TEST_P(MutationTest, ReaderSurvives) {
  const Reader reader = GetParam().reader();
  const std::vector<std::string> seeds = reader.seeds();
  ASSERT_FALSE(seeds.empty());
  for (const std::string& seed : seeds) reader.read(seed);
  uint64_t count = 0;
  for (const auto end = std::chrono::steady_clock::now() + kTime;
       count < kNumInputs && std::chrono::steady_clock::now() < end;
       ++count) {
    RandomStream random(1, count);
    std::string bytes = seeds[random.Index(seeds.size())];
    for (size_t k = 0; k <= random.Index(4); ++k) {
      ChangeOnePlace(seeds, &random, &bytes);
    }
    SCOPED_TRACE("input " + std::to_string(count));
    reader.read(bytes);
  }
  EXPECT_GT(count, 0u);
  RecordProperty("executions", std::to_string(count));
}

INSTANTIATE_TEST_SUITE_P(Readers,
                         MutationTest,
                         testing::ValuesIn(kReaders),
                         [](const testing::TestParamInfo<NamedReader>& reader) {
                           return std::string(reader.param.name);
                         });

}  // namespace
}  // namespace freegs::fuzz
