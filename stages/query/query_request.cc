// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_request.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "core/io/json_text.h"
#include "pipeline/option_table.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {
namespace {

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

// Reads "VIEW X Y ...", the values of an option that is given at most once.
StatusOr<std::optional<ViewPlace>> ParsePlace(
    const std::string& option,
    const std::vector<std::vector<std::string>>& given) {
  if (given.empty()) return std::optional<ViewPlace>();
  const std::vector<std::string>& values = given.front();
  ViewPlace place;
  place.view = values[0];
  for (size_t k = 1; k < values.size(); ++k) {
    FREEGS_ASSIGN_OR_RETURN(const double number,
                            ParseNumber(values[k], option));
    place.numbers.push_back(number);
  }
  return std::optional(std::move(place));
}

// Options that the kind of question has no use for are refused.
Status CheckOptions(const QueryRequest& request,
                    const std::vector<pipeline::OptionSetting>& settings) {
  for (const pipeline::OptionSetting& setting : settings) {
    const std::string& name = setting.name;
    if (name == "min-cosine" && !request.example) {
      return InvalidArgumentError("--min-cosine is for --example only");
    }
    if (name == "query.min_relevancy" && !request.text) {
      return InvalidArgumentError("--min-relevancy is for --text only");
    }
    if (name == "model" && !request.text && !request.example) {
      return InvalidArgumentError("--model is for --text and --example only");
    }
  }
  return Status();
}

// Where the words of the command line are put.
struct QueryTargets {
  PipelineOptions options;
  QueryRequest request;
  std::string text;
  std::string example;
  std::vector<std::vector<std::string>> click;
  std::vector<std::vector<std::string>> box;
  int wider = 1;
  int narrower = 1;
};

void AddQuestions(QueryTargets* targets, CommandWords* words) {
  words->AddOption(
      "text",
      &targets->text,
      {.help = "Words for what is looked for.", .value_name = "WORDS"});
  words->AddOption(
      "example",
      &targets->example,
      {.help = "Picture of what is looked for.", .value_name = "IMAGE"});
  words->AddListOption({.name = "click",
                        .value_names = {"VIEW", "X", "Y"},
                        .help = "The instance at a pixel of a view. VIEW is "
                                "the name of a photo or of a camera.",
                        .target = &targets->click});
  words->AddListOption(
      {.name = "box",
       .value_names = {"VIEW", "X0", "Y0", "X1", "Y1"},
       .help = "The instance that a box is drawn around, from pixel X0 Y0 to "
               "X1 Y1 of a view.",
       .target = &targets->box});
  words->RequireOneOf({"text", "example", "click", "box"});
  words->AddOption("wider",
                   &targets->wider,
                   {.help = "With --click: so many levels above the instance "
                            "that is clicked: what it is a part of.",
                    .min = 1,
                    .max = kMaxLevels,
                    .shows_default = false});
  words->AddOption("narrower",
                   &targets->narrower,
                   {.help = "With --click: so many levels below the instance "
                            "that is clicked: its part that was clicked.",
                    .min = 1,
                    .max = kMaxLevels,
                    .shows_default = false});
}

void AddAnswers(QueryRequest* request, CommandWords* words) {
  words->AddOption("out",
                   &request->out,
                   {.help = "Folder for masks, overlays and query.json.",
                    .value_name = "DIR"});
  words->AddOption("json", &request->json, {.help = "Print JSON."});
  words->AddOption(
      "cameras",
      &request->cameras,
      {.help = "JSON file of cameras; without it, those of the photos.",
       .value_name = "FILE"});
  words->AddOption("no-align",
                   &request->no_align,
                   {.help = "The cameras are in the scene's own world frame."});
  words->AddOption("size",
                   &request->size,
                   {.help = "Longest side of the masks in pixels at most; 0 is "
                            "the photos' or the camera file's.",
                    .min = 0});
  words->AddOption("model",
                   &request->model,
                   {.help = "Folder of the CLIP model, where it is not the one "
                            "the scene was made with or has moved.",
                    .value_name = "DIR"});
  words->AddOption(
      "max-hits",
      &request->max_hits,
      {.help = "Instances at most; 0 is all that pass.", .min = 0});
  words->AddOption(
      "min-cosine",
      &request->min_cosine,
      {.help = "With --example: instances less like it are not hits.",
       .min = -1,
       .max = 1});
}

CommandWords DescribeQuery(QueryTargets* targets) {
  pipeline::OptionTable table = MakeOptionTable(&targets->options);
  table.LimitCommandLine({"general.threads", "query"});
  table.AddAlias("min-relevancy", "query.min_relevancy");
  table.AddAlias("background", "query.background");
  CommandWords words("query",
                     "Finds the instance that is meant, in space and in every "
                     "view.",
                     std::move(table));
  words.AddArgument(WorkspaceArgument());
  AddQuestions(targets, &words);
  AddAnswers(&targets->request, &words);
  return words;
}

}  // namespace

CommandWords QueryWords() { return KeepWords<QueryTargets>(DescribeQuery); }

StatusOr<QueryRequest> ParseQueryRequest(
    const std::vector<std::string>& arguments) {
  QueryTargets targets;
  CommandWords words = DescribeQuery(&targets);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  QueryRequest& request = targets.request;
  FREEGS_ASSIGN_OR_RETURN(request.click, ParsePlace("--click", targets.click));
  FREEGS_ASSIGN_OR_RETURN(request.box, ParsePlace("--box", targets.box));
  FREEGS_ASSIGN_OR_RETURN(request.workspace,
                          ExistingWorkspace(line.positional[0]));
  FREEGS_RETURN_IF_ERROR(
      ApplyQuerySettings(request.workspace, line.settings, words.table()));
  request.text_options = targets.options.query;
  request.threads = targets.options.general.threads;

  for (const pipeline::OptionSetting& setting : line.settings) {
    if (setting.name == "text") request.text = targets.text;
    if (setting.name == "example") request.example = targets.example;
    const bool wider = setting.name == "wider";
    if (wider || setting.name == "narrower") {
      if (request.level) {
        return InvalidArgumentError(
            "--wider and --narrower exclude one another");
      }
      request.level = wider ? targets.wider : -targets.narrower;
    }
  }
  if (request.text &&
      request.text->find_first_not_of(" \t\r\n") == std::string::npos) {
    return InvalidArgumentError("--text needs words");
  }
  if (request.text && ValidUtf8(*request.text) != *request.text) {
    return InvalidArgumentError("--text: the words are not UTF-8");
  }
  if (request.level && !request.click) {
    return InvalidArgumentError("--wider and --narrower are for --click only");
  }
  FREEGS_RETURN_IF_ERROR(CheckOptions(request, line.settings));
  if (request.no_align && request.cameras.empty()) {
    return InvalidArgumentError("--no-align is for --cameras FILE only");
  }
  return request;
}

}  // namespace freegs::stages
