// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/doctor_command.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <system_error>

#include <Eigen/Core>
#include <boost/version.hpp>
#include <ceres/version.h>
#include <flann/config.h>
#include <hwy/highway.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>
#include <xxhash.h>

#include "core/number_text.h"
#include "pipeline/system_info.h"
#include "pipeline/version.h"
#include "sfm/colmap/colmap_program.h"
#include "stages/command_line/version_text.h"
#include "stages/registry/pipeline_options.h"
#include "stages/scene/clip_input.h"

namespace freegs::stages {
namespace {

// Below these a run of ordinary size is likely to fail.
constexpr int64_t kLowMemoryBytes = 4 * kGigabyte;
constexpr int64_t kLowDiskBytes = 5 * kGigabyte;

std::string SizeText(int64_t bytes) {
  return FormatBytes(static_cast<double>(bytes));
}

void PrintLine(std::ostream& out,
               const std::string& name,
               const std::string& text) {
  out << name << std::string(name.size() < 14 ? 14 - name.size() : 1, ' ')
      << text << "\n";
}

// The version "a.b.c" of the number (a * base + b) * base + c.
std::string Dotted(int64_t number, int64_t base) {
  return std::to_string(number / base / base) + "." +
         std::to_string(number / base % base) + "." +
         std::to_string(number % base);
}

void PrintMachine(std::ostream& out) {
  std::string cores = std::to_string(pipeline::AvailableCores());
  if (const std::optional<double> quota = pipeline::CoresOfQuota()) {
    cores += " (" + std::to_string(pipeline::CoresOfAffinity()) + " allowed, " +
             FormatFixed(*quota, 1) + " by the control group)";
  }
  PrintLine(out, "cores", cores);
  PrintLine(out, "SIMD", InstructionSets());
  const pipeline::MemoryInfo memory = pipeline::Memory();
  PrintLine(out,
            "memory",
            SizeText(memory.available_bytes) + " available of " +
                SizeText(memory.total_bytes) +
                (memory.available_bytes < kLowMemoryBytes
                     ? " - little: use a smaller reconstruct.max_image_size"
                     : ""));
  std::error_code error;
  const std::filesystem::path here = std::filesystem::current_path(error);
  if (const auto disk = pipeline::FreeDiskBytes(here)) {
    PrintLine(out,
              "disk",
              SizeText(*disk) + " free in " + here.string() +
                  (*disk < kLowDiskBytes ? " - little for a workspace" : ""));
  }
}

void PrintLibraries(std::ostream& out) {
  PrintLine(out, "OpenCV", CV_VERSION);
  PrintLine(out, "Ceres", CERES_VERSION_STRING);
  PrintLine(out,
            "Eigen",
            std::to_string(EIGEN_WORLD_VERSION) + "." +
                std::to_string(EIGEN_MAJOR_VERSION) + "." +
                std::to_string(EIGEN_MINOR_VERSION));
  PrintLine(out, "FLANN", FLANN_VERSION_);
  PrintLine(out,
            "Boost",
            std::to_string(BOOST_VERSION / 100000) + "." +
                std::to_string(BOOST_VERSION / 100 % 1000) + "." +
                std::to_string(BOOST_VERSION % 100));
  PrintLine(out,
            "Highway",
            std::to_string(HWY_MAJOR) + "." + std::to_string(HWY_MINOR) + "." +
                std::to_string(HWY_PATCH));
  PrintLine(out,
            "JSON",
            std::to_string(NLOHMANN_JSON_VERSION_MAJOR) + "." +
                std::to_string(NLOHMANN_JSON_VERSION_MINOR) + "." +
                std::to_string(NLOHMANN_JSON_VERSION_PATCH));
  PrintLine(out, "xxHash", Dotted(XXH_VERSION_NUMBER, 100));
#ifdef __VERSION__
  PrintLine(out, "compiler", __VERSION__);
#endif
}

CommandWords DescribeDoctor(PipelineOptions* options) {
  pipeline::OptionTable table = MakeOptionTable(options);
  table.LimitCommandLine({"sfm.colmap", "bootstrap.model"});
  return {"doctor",
          "Lists what this machine offers and what it lacks: cores, memory, "
          "libraries, COLMAP, the CLIP model.",
          std::move(table)};
}

}  // namespace

CommandWords DoctorWords() {
  return KeepWords<PipelineOptions>(DescribeDoctor);
}

Status RunDoctorCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  PipelineOptions options;
  const auto positional = DescribeDoctor(&options).ParseAndApply(arguments);
  FREEGS_RETURN_IF_ERROR(positional.status());
  std::ostream& out = context.out;
  PrintLine(out, "program", pipeline::kProgramVersion);
  PrintMachine(out);
  PrintLibraries(out);

  Status verdict;
  StatusOr<sfm::ColmapProgram> colmap = sfm::ColmapProgram::Find(
      options.sfm.colmap.colmap, &context.cancellation);
  if (!colmap.ok()) {
    PrintLine(out, "colmap", "MISSING");
    verdict = colmap.status();
  } else {
    // A command that would open a window shows whether it can do without.
    const auto known =
        colmap->Options("feature_extractor", &context.cancellation);
    PrintLine(
        out,
        "colmap",
        colmap->version() + (known.ok() ? ", runs without a display"
                                        : ", does not run without a display"));
    for (const std::string& fault : colmap->KnownFaults()) {
      PrintLine(out, "", fault);
    }
    if (!known.ok()) verdict = known.status();
  }
  const auto model = OpenClipModel(options.bootstrap.model);
  PrintLine(out,
            "CLIP model",
            model.ok() ? (*model)->info().name : std::string("MISSING"));
  if (verdict.ok() && !model.ok()) verdict = model.status();
  if (verdict.ok()) out << "nothing is missing\n";
  return verdict;
}

}  // namespace freegs::stages
