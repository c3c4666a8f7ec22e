// SPDX-License-Identifier: BSD-3-Clause
// What a fuzz target is made of. A family of readers has a file with one
// function per reader:
//
//   Reader Ply() {
//     return {[](std::string_view bytes) { (void)splat::ParsePly(bytes); },
//             [] { return std::vector<std::string>{splat::SerializePly(...)};
//             }};
//   }
//
// CMakeLists.txt makes a program of each. A reader may refuse any bytes, but it
// must neither crash nor hang, nor take memory that the bytes cannot fill.

#ifndef FREEGS_TESTS_FUZZ_READER_H_
#define FREEGS_TESTS_FUZZ_READER_H_

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/byte_stream.h"
#include "tests/temporary_folder.h"

namespace freegs::fuzz {

struct Reader {
  void (*read)(std::string_view bytes);
  // Small good files, from which the fuzzer starts.
  std::vector<std::string> (*seeds)();
};

// Ends the program, which the fuzzer reports with the bytes that led here.
inline void Require(bool holds) {
  if (!holds) std::abort();
}

// A fuzzer does not guess checksums, so the program appends the right one, and
// seeds lack it.
inline std::string WithChecksum(std::string_view body) {
  ByteWriter writer;
  writer.PutBytes(body);
  writer.PutChecksum();
  return std::move(writer).content();
}
inline std::string SeedWithoutChecksum(std::string_view content) {
  return std::string(WithoutChecksum(content));
}

// One folder per process, for readers that need files.
inline const TemporaryFolder& Scratch() {
  static const TemporaryFolder folder;
  return folder;
}

// The fuzzer replaces one file of a good folder: the first byte of its input
// says which, and the others are its content. So it need not make several files
// that fit each other.
struct FolderFile {
  std::string name;
  std::string content;
};

inline void WriteWithOneReplaced(const std::filesystem::path& folder,
                                 const std::vector<FolderFile>& files,
                                 std::string_view bytes) {
  const size_t chosen =
      bytes.empty() ? 0 : static_cast<uint8_t>(bytes[0]) % files.size();
  for (size_t i = 0; i < files.size(); ++i) {
    WriteText(
        folder / files[i].name,
        i == chosen ? bytes.substr(bytes.empty() ? 0 : 1) : files[i].content);
  }
}

inline std::vector<std::string> SeedsOfFolder(
    const std::vector<FolderFile>& files) {
  std::vector<std::string> seeds;
  for (size_t i = 0; i < files.size(); ++i) {
    seeds.push_back(static_cast<char>(i) + files[i].content);
  }
  return seeds;
}

}  // namespace freegs::fuzz

#endif  // FREEGS_TESTS_FUZZ_READER_H_
