// SPDX-License-Identifier: BSD-3-Clause
// The installed `colmap` program: where it is, its version, and which commands
// and options it has. Names of options differ between releases: what was
// SiftExtraction.use_gpu is FeatureExtraction.use_gpu in newer ones.

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

// Asks the program for its version and options:
//
//   FREEGS_ASSIGN_OR_RETURN(ColmapProgram colmap,
//                           ColmapProgram::Find("colmap", cancellation));
//   FREEGS_ASSIGN_OR_RETURN(auto options,
//                           colmap.Options("mapper", cancellation));
//   ColmapArguments arguments(colmap.Command("mapper"), std::move(options));
//   arguments.Require("database_path", database.string());
//   arguments.Prefer({"Mapper.random_seed"}, "1");
//   FREEGS_ASSIGN_OR_RETURN(const ChildCommand command, arguments.Finish());
class ColmapProgram {
 public:
  // Starts `program`, which is a path or a name in PATH, to ask for its
  // version. Returns kMissingDependency, with advice, when it cannot be started
  // or is not COLMAP.
  static StatusOr<ColmapProgram> Find(const std::string& program,
                                      const CancellationToken* cancellation);

  const std::string& program() const { return program_; }
  // Such as "3.8" or "4.1.1"; "unknown" when the program does not tell.
  const std::string& version() const { return version_; }

  // Known faults of this release and what to do about them, one line each, for
  // warnings. Empty for releases without known faults.
  std::vector<std::string> KnownFaults() const;

  // The options of a command, as its --help lists them, without dashes. The
  // program is asked once per command. Returns kMissingDependency when the
  // command does not exist.
  StatusOr<std::set<std::string>> Options(
      const std::string& command, const CancellationToken* cancellation);

  // The beginning of a command line, set up for a machine without display.
  ChildCommand Command(const std::string& command) const;

 private:
  std::string program_;
  std::string version_;
  std::map<std::string, std::set<std::string>> options_;
};

// Builds the arguments of one command with options that this release has.
class ColmapArguments {
 public:
  // `options` are those of ColmapProgram::Options.
  ColmapArguments(ChildCommand command, std::set<std::string> options)
      : command_(std::move(command)), options_(std::move(options)) {}

  // Adds an option that all releases have. Finish() returns an error when this
  // one lacks it.
  void Require(const std::string& option, const std::string& value);

  // Adds the first one of the names that this release has, and returns whether
  // it has any.
  bool Prefer(std::initializer_list<std::string> names,
              const std::string& value);

  // Adds all of the names that this release has.
  void AddAll(std::initializer_list<std::string> names,
              const std::string& value);

  // Returns the command line, or kMissingDependency with the name of the first
  // required option that this release lacks.
  StatusOr<ChildCommand> Finish() const;

 private:
  ChildCommand command_;
  std::set<std::string> options_;
  std::string missing_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_COLMAP_PROGRAM_H_
