// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/bench_command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "pipeline/workspace.h"
#include "stages/bench/baseline.h"
#include "stages/bench/bench_names.h"
#include "stages/bench/bench_page.h"
#include "stages/bench/bench_results.h"
#include "stages/bench/bench_summary.h"
#include "stages/bench/cell_runner.h"
#include "stages/bench/reference.h"
#include "stages/suite/suite.h"
#include "stages/suite/suite_cells.h"
#include "stages/viewer/web_bundle.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

struct BenchRequest {
  std::string out;
  std::string baseline;
  bool write_baseline = false;
  bool list = false;
  bool again = false;
  int jobs = 1;
};

CommandWords DescribeBench(BenchRequest* request) {
  CommandWords words("bench",
                     "Runs a suite of experiments, and charts speed against "
                     "accuracy.");
  words.AddArgument({.name = "SUITE",
                     .help = "File that names scenes, options to vary, seeds, "
                             "charts and tables; docs/bench.md describes it."});
  words.AddOption("out",
                  &request->out,
                  {.help = "Folder for results.csv, results.json, summary.md, "
                           "index.html and all workspaces. A bench that was "
                           "stopped goes on with what is there.",
                   .value_name = "DIR"});
  words.AddOption("jobs",
                  &request->jobs,
                  {.help = "Experiments at a time. More than 1 makes seconds "
                           "of wall time longer than they would be alone.",
                   .value_name = "N",
                   .min = 1,
                   .max = 64});
  words.AddOption("baseline",
                  &request->baseline,
                  {.help = "Figures of an earlier program, to compare with: "
                           "names what moved, and ends with exit code 4 if "
                           "anything moved further than that file allows.",
                   .value_name = "FILE"});
  words.AddOption("write-baseline",
                  &request->write_baseline,
                  {.help = "Write the file of --baseline instead; tolerances "
                           "that it has are kept."});
  words.AddOption("list",
                  &request->list,
                  {.help = "Only print the experiments, one per line."});
  words.AddOption("again",
                  &request->again,
                  {.help = "Forget the results in DIR, for instance those of "
                           "an earlier program."});
  return words;
}

SuiteChecks MakeChecks(const BenchEnvironment& environment) {
  SuiteChecks checks;
  if (environment.eval_words) {
    checks.eval = [&environment](const std::string& option,
                                 const std::string& value) -> StatusOr<bool> {
      const CommandWords words = environment.eval_words();
      FREEGS_RETURN_IF_ERROR(
          words.Parse({"WORKSPACE", "--" + option + "=" + value}).status());
      const pipeline::OptionTable::Option* known = words.table().Find(option);
      return known != nullptr &&
             CompletionOf(ValueName(*known)) != Completion::kNothing;
    };
  }
  checks.disturb = environment.disturber.check;
  return checks;
}

Status WriteResults(const BenchResults& bench, const fs::path& out) {
  const std::string json = JsonText(ToJson(bench), 1);
  const std::string summary = SummaryMarkdown(bench);
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(out / "results.json", json));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(out / "results.csv", ToCsv(bench)));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(out / "summary.md", summary));
  BenchPage page;
  page.title = bench.suite.title;
  page.results = json;
  page.summary = summary;
  const StatusOr<fs::path> bundle = FindWebBundle();
  StatusOr<std::string> script =
      bundle.ok() ? ReadFile(*bundle / "bench.js") : bundle.status();
  if (script.ok()) {
    page.script = *std::move(script);
    const StatusOr<std::string> licenses = ReadFile(*bundle / "licenses.txt");
    if (licenses.ok()) {
      FREEGS_RETURN_IF_ERROR(WriteFileAtomic(out / "licenses.txt", *licenses));
    }
  } else {
    page.missing =
        "This page has no charts: its script is not built. Install Node.js 18 "
        "or newer with npm, build the program again and repeat the bench; what "
        "is done is kept. results.csv and results.json have all figures.";
  }
  return WriteFileAtomic(out / "index.html", RenderBenchPage(page));
}

// The baseline to compare with or to replace. Read before anything runs, so
// that a wrong name does not cost a bench.
StatusOr<Baseline> ReadBaseline(const BenchRequest& request) {
  const fs::path path = request.baseline;
  std::error_code error;
  Baseline then;
  then.tolerances = DefaultTolerances();
  if (request.write_baseline) {
    FREEGS_RETURN_IF_ERROR(PrepareOutputFile(path).status());
    if (!fs::exists(path, error)) return then;
  }
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json json, ReadJson(path));
  return BaselineFromJson(json, path.string());
}

Status CompareWithBaseline(const BenchRequest& request,
                           const Baseline& then,
                           const BenchResults& bench,
                           const BenchEnvironment& environment) {
  const fs::path path = request.baseline;
  const Baseline now = MakeBaseline(bench, then.tolerances);
  if (request.write_baseline) {
    FREEGS_RETURN_IF_ERROR(CheckForBaseline(bench));
    FREEGS_ASSIGN_OR_RETURN(const fs::path file, PrepareOutputFile(path));
    return WriteFileAtomic(file, JsonText(ToJson(now), 1));
  }
  const std::vector<std::string> moved = WhatMoved(then, now);
  for (const std::string& line : moved) {
    environment.out << "moved: " << line << "\n";
  }
  if (moved.empty()) {
    environment.out << "all figures are as in " << path.string() << "\n";
    return Status();
  }
  return UnusableResultError(
      std::to_string(moved.size()) + " figures are not as in " + path.string() +
      "; if that is meant, write it anew with --write-baseline");
}

Status ForgetResults(const fs::path& out) {
  for (const char* name : {"store", "cells", "scenes", "photos", "poses"}) {
    std::error_code error;
    fs::remove_all(out / name, error);
    if (error) {
      return InternalError((out / name).string() +
                           ": cannot delete: " + error.message());
    }
  }
  return Status();
}

// A folder of other files must not be mixed with results.
Status CheckOutFolder(const fs::path& out) {
  std::error_code error;
  if (!fs::exists(out, error) || fs::exists(out / ".bench", error)) {
    return Status();
  }
  if (fs::is_directory(out, error) && fs::is_empty(out, error)) return Status();
  return BadInputError(out.string() +
                       ": holds other files; give a new or empty folder, or "
                       "that of an earlier bench");
}

// `environment` must outlive what is returned.
BenchContext MakeBenchContext(const BenchRequest& request,
                              const Suite& suite,
                              const BenchEnvironment& environment) {
  std::error_code error;
  BenchContext context;
  context.out = pipeline::AbsolutePath(request.out);
  context.program = fs::read_symlink("/proc/self/exe", error);
  context.time_limit_s = suite.time_limit_s;
  // A comparison is about the program of now.
  context.only_this_program = !request.baseline.empty();
  context.disturber = environment.disturber;
  context.cancellation = &environment.cancellation;
  context.say = [&environment, mutex = std::make_shared<std::mutex>()](
                    const std::string& text) {
    const std::lock_guard lock(*mutex);
    environment.err << "bench: " << text << std::endl;
  };
  return context;
}

void PrintCells(const std::vector<SuiteCell>& cells, std::ostream& out) {
  for (const SuiteCell& cell : cells) out << cell.id << "\n";
}

}  // namespace

CommandWords BenchWords() { return KeepWords<BenchRequest>(DescribeBench); }

Status RunBench(const std::vector<std::string>& arguments,
                const BenchEnvironment& environment) {
  BenchRequest request;
  CommandWords words = DescribeBench(&request);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          words.ParseAndApply(arguments));
  if (request.write_baseline && request.baseline.empty()) {
    return InvalidArgumentError("--write-baseline needs --baseline FILE");
  }
  FREEGS_ASSIGN_OR_RETURN(const Suite suite, ReadSuite(positional[0]));
  const SuiteChecks checks = MakeChecks(environment);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<SuiteCell> cells,
                          MakeCells(suite, checks));
  if (request.list) {
    PrintCells(cells, environment.out);
    return Status();
  }
  if (request.out.empty()) {
    return InvalidArgumentError("give a folder for the results: --out DIR");
  }
  const BenchContext context = MakeBenchContext(request, suite, environment);
  FREEGS_RETURN_IF_ERROR(CheckOutFolder(context.out));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(context.out));
  Baseline baseline;
  if (!request.baseline.empty()) {
    FREEGS_ASSIGN_OR_RETURN(baseline, ReadBaseline(request));
  }
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceLock lock,
                          pipeline::WorkspaceLock::Acquire(context.out));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(context.out / ".bench", ""));
  if (request.again) FREEGS_RETURN_IF_ERROR(ForgetResults(context.out));

  const auto warn = [&context](const std::vector<std::string>& lines) {
    for (const std::string& line : lines) context.say("warning: " + line);
  };
  warn(UnknownKeys(suite));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<ScenePhotos> photos,
                          FindAllPhotos(suite, context));
  CellRunnerOptions options;
  options.jobs = request.jobs;
  options.finished = [&](std::vector<CellResult> so_far) {
    CompareWithReference(suite, cells, &so_far);
    return WriteResults({suite, cells, so_far}, context.out);
  };
  FREEGS_ASSIGN_OR_RETURN(std::vector<CellResult> results,
                          RunCells(suite, cells, photos, context, options));
  CompareWithReference(suite, cells, &results);
  const BenchResults bench{suite, cells, results};
  environment.out << SummaryMarkdown(bench) << "\n"
                  << (context.out / "index.html").string() << "\n";
  warn(UnknownFigures(bench));
  const bool all_failed =
      std::none_of(results.begin(), results.end(), [](const CellResult& cell) {
        return cell.status == CellStatus::kDone;
      });
  // Failures alone are no baseline.
  if (!request.baseline.empty() && !(all_failed && request.write_baseline)) {
    FREEGS_RETURN_IF_ERROR(
        CompareWithBaseline(request, baseline, bench, environment));
  }
  if (all_failed) {
    return UnusableResultError("all experiments failed: " +
                               results.front().reason);
  }
  return Status();
}

}  // namespace freegs::stages
