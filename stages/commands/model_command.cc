// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/model_command.h"

#include "semantics/clip_export/clip_export.h"

namespace freegs::stages {

namespace {

struct ModelRequest {
  semantics::ClipExportOptions options;
  std::string out;
  std::string merges;
};

CommandWords DescribeModel(ModelRequest* request) {
  CommandWords words("model", "Makes a model folder of a CLIP's weights.");
  words.AddArgument(
      {.name = "WEIGHTS", .help = "FILE.safetensors, or a folder with one."});
  words.AddOption("out",
                  &request->out,
                  {.help = "Model folder to write.", .value_name = "DIR"});
  words.AddOption("merges",
                  &request->merges,
                  {.help = "Byte-pair merges of the model; merges.txt beside "
                           "the weights when not given.",
                   .value_name = "FILE"});
  words.AddOption("dense-size",
                  &request->options.dense_size,
                  {.help = "One more image size in pixels for dense features, "
                           "such as 448; 0 for none.",
                   .min = 0,
                   .max = 4096});
  words.Require("out");
  return words;
}

}  // namespace

CommandWords ModelWords() { return KeepWords<ModelRequest>(DescribeModel); }

Status RunModelCommand(const std::vector<std::string>& arguments,
                       CommandContext& context) {
  ModelRequest request;
  CommandWords words = DescribeModel(&request);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          words.ParseAndApply(arguments));
  const std::string& out = request.out;
  FREEGS_RETURN_IF_ERROR(CheckOutputPlace(out));
  request.options.checkpoint = positional[0];
  request.options.merges = request.merges;
  FREEGS_ASSIGN_OR_RETURN(
      const semantics::ModelInfo info,
      semantics::ExportClip(request.options, out, &context.cancellation));
  context.out << out << ": " << info.name << ", " << info.embedding_dim
              << " dimensions; use it with --bootstrap.model " << out << "\n";
  return Status();
}

}  // namespace freegs::stages
