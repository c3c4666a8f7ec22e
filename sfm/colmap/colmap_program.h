// SPDX-License-Identifier: BSD-3-Clause
// The installed `colmap` program: where it is, its version, and which commands
// and options it knows. Names changed between releases (SiftExtraction.use_gpu
// became FeatureExtraction.use_gpu): this class asks the program.

#ifndef FREEGS_SFM_COLMAP_COLMAP_PROGRAM_H_
#define FREEGS_SFM_COLMAP_COLMAP_PROGRAM_H_

#include <initializer_list>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/colmap/child_process.h"

namespace freegs::sfm {

class ColmapProgram {
 public:
  // Asks `program` (a path, or a name in PATH) who it is. kMissingDependency
  // with advice when it cannot be started or is not COLMAP.
  static StatusOr<ColmapProgram> Find(const std::string& program,
                                      const CancellationToken* cancellation);

  const std::string& program() const { return program_; }
  // "3.8", "4.1.1"; "unknown" when it does not say.
  const std::string& version() const { return version_; }
  bool HasCommand(std::string_view command) const;

  // What is known to be wrong with this release and what to do, one line each,
  // for a warning. Empty for good, unknown and future ones.
  std::vector<std::string> KnownFaults() const;

  // The options of a command as its --help lists them, without dashes. Asks
  // once per command. kMissingDependency when the command does not exist.
  StatusOr<std::set<std::string>> Options(
      const std::string& command, const CancellationToken* cancellation);

  // A command line of this program, for a machine without display.
  ChildCommand Command(const std::string& command) const;

 private:
  std::string program_;
  std::string version_;
  std::set<std::string, std::less<>> commands_;
  std::map<std::string, std::set<std::string>> options_;
};

// Builds the arguments of one command from the options that it has.
class ColmapArguments {
 public:
  // options: as from ColmapProgram::Options.
  ColmapArguments(ChildCommand command, std::set<std::string> options)
      : command_(std::move(command)), options_(std::move(options)) {}

  // Adds an option all releases have; it is an error when this one lacks it.
  void Require(const std::string& option, const std::string& value);

  // Adds the first of the names that the program knows; none is fine.
  // Returns whether one was known.
  bool Prefer(std::initializer_list<std::string> names,
              const std::string& value);

  // Adds every one of the names that the program knows.
  void AddAll(std::initializer_list<std::string> names,
              const std::string& value);

  // The command line, or the first missing required option
  // (kMissingDependency).
  StatusOr<ChildCommand> Finish() const;

 private:
  ChildCommand command_;
  std::set<std::string> options_;
  std::string missing_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_COLMAP_PROGRAM_H_
