// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_request.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "pipeline/option_table.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {
namespace {

constexpr char kUsage[] =
    "query WORKSPACE (--text WORDS | --example IMAGE | --click VIEW X Y "
    "[--wider N | --narrower N] | --box VIEW X0 Y0 X1 Y1)";
constexpr int kMaxLevels = 1000;

StatusOr<double> ParseNumber(const std::string& word,
                             const std::string& option) {
  double value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) {
    return InvalidArgumentError(option + ": \"" + word +
                                "\" is not a number of pixels");
  }
  return value;
}

// Takes an option of several values, such as "--click VIEW X Y", out of the
// arguments. The option table only knows options of one value.
StatusOr<std::optional<ViewPlace>> TakePlace(
    const std::string& option,
    size_t num_numbers,
    std::vector<std::string>* arguments) {
  const auto found = std::find(arguments->begin(), arguments->end(), option);
  if (found == arguments->end()) return std::optional<ViewPlace>();
  const auto words = static_cast<size_t>(arguments->end() - found) - 1;
  if (words < num_numbers + 1) {
    return InvalidArgumentError(option + " needs a view and " +
                                std::to_string(num_numbers) +
                                " numbers: " + kUsage);
  }
  ViewPlace place;
  place.view = found[1];
  for (size_t k = 0; k < num_numbers; ++k) {
    FREEGS_ASSIGN_OR_RETURN(
        const double number,
        ParseNumber(found[static_cast<int64_t>(k) + 2], option));
    place.numbers.push_back(number);
  }
  arguments->erase(found, found + static_cast<int64_t>(num_numbers) + 2);
  if (std::find(arguments->begin(), arguments->end(), option) !=
      arguments->end()) {
    return InvalidArgumentError(option + " is given twice");
  }
  return std::optional(std::move(place));
}

struct Levels {
  int wider = 1;
  int narrower = 1;
};

void AddWords(QueryRequest* request,
              std::string* text,
              std::string* example,
              Levels* levels,
              pipeline::OptionTable* table) {
  table->Add("text", text, {.help = "Words for what is looked for."});
  table->Add("example", example, {.help = "Picture of what is looked for."});
  table->Add("wider",
             &levels->wider,
             {.help = "So many levels above the instance that is clicked: what "
                      "it is a part of.",
              .min = 1,
              .max = kMaxLevels});
  table->Add("narrower",
             &levels->narrower,
             {.help = "So many levels below the instance that is clicked: its "
                      "part that was clicked.",
              .min = 1,
              .max = kMaxLevels});
  table->Add("out", &request->out, {.help = "Folder for masks."});
  table->Add("json", &request->json, {.help = "Print JSON."});
  table->Add(
      "cameras",
      &request->cameras,
      {.help = "JSON file of cameras; without it, those of the photos."});
  table->Add("no-align",
             &request->no_align,
             {.help = "The cameras are in the scene's own world frame."});
  table->Add("size",
             &request->size,
             {.help = "Longest side of the masks in pixels at most; 0 is the "
                      "photos' or the camera file's.",
              .min = 0});
  table->Add("model",
             &request->model,
             {.help = "Folder of the CLIP model, where it is not the one the "
                      "scene was made with or has moved."});
  table->Add("max-hits",
             &request->max_hits,
             {.help = "Instances at most; 0 is all that pass.", .min = 0});
  table->Add("min-cosine",
             &request->min_cosine,
             {.help = "Instances less like the example are not hits.",
              .min = -1,
              .max = 1});
  table->AddAlias("min-relevancy", "query.min_relevancy");
  table->AddAlias("background", "query.background");
}

}  // namespace

StatusOr<QueryRequest> ParseQueryRequest(
    const std::vector<std::string>& all_arguments) {
  std::vector<std::string> arguments = all_arguments;
  QueryRequest request;
  FREEGS_ASSIGN_OR_RETURN(request.click, TakePlace("--click", 2, &arguments));
  FREEGS_ASSIGN_OR_RETURN(request.box, TakePlace("--box", 4, &arguments));

  PipelineOptions options;
  pipeline::OptionTable table = MakeOptionTable(&options);
  std::string text;
  std::string example;
  Levels levels;
  AddWords(&request, &text, &example, &levels, &table);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  if (line.positional.size() != 1) {
    return InvalidArgumentError(std::string("query takes one workspace: ") +
                                kUsage);
  }
  std::error_code error;
  request.workspace =
      std::filesystem::absolute(line.positional[0], error).lexically_normal();
  if (!std::filesystem::is_directory(request.workspace, error)) {
    return BadInputError(request.workspace.string() + ": no such workspace");
  }
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(request.workspace, line.settings, table));
  request.text_options = options.query;
  request.threads = options.general.threads;

  for (const pipeline::OptionSetting& setting : line.settings) {
    if (setting.name == "text") request.text = text;
    if (setting.name == "example") request.example = example;
    const bool wider = setting.name == "wider";
    if (wider || setting.name == "narrower") {
      if (request.level) {
        return InvalidArgumentError(
            "--wider and --narrower exclude one another");
      }
      request.level = wider ? levels.wider : -levels.narrower;
    }
  }
  const int questions = request.text.has_value() + request.example.has_value() +
                        request.click.has_value() + request.box.has_value();
  if (questions != 1) {
    return InvalidArgumentError(std::string("query needs one question: ") +
                                kUsage);
  }
  if (request.text &&
      request.text->find_first_not_of(" \t\r\n") == std::string::npos) {
    return InvalidArgumentError("--text needs words");
  }
  if (request.level && !request.click) {
    return InvalidArgumentError("--wider and --narrower are for --click only");
  }
  if (request.no_align && request.cameras.empty()) {
    return InvalidArgumentError("--no-align is for --cameras FILE only");
  }
  return request;
}

}  // namespace freegs::stages
