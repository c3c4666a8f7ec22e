// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/model_command.h"

#include "pipeline/option_table.h"
#include "semantics/clip_export/clip_export.h"

namespace freegs::stages {

Status RunModelCommand(const std::vector<std::string>& arguments,
                       CommandContext& context) {
  semantics::ClipExportOptions options;
  std::string out;
  std::string merges;
  pipeline::OptionTable table;
  table.Add("out", &out, {.help = "Model folder to write."});
  table.Add("merges",
            &merges,
            {.help = "Byte-pair merges of the model; merges.txt beside the "
                     "weights when not given."});
  table.Add("dense-size",
            &options.dense_size,
            {.help = "One more image size in pixels for dense features, such "
                     "as 448; 0 for none.",
             .min = 0,
             .max = 4096});
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  FREEGS_RETURN_IF_ERROR(table.Apply(line.settings));
  if (line.positional.size() != 1) {
    return InvalidArgumentError(
        "model takes one file or folder of weights: model "
        "FILE.safetensors|FOLDER --out DIR");
  }
  if (out.empty()) {
    return InvalidArgumentError("model needs a folder to write: --out DIR");
  }
  options.checkpoint = line.positional[0];
  options.merges = merges;
  FREEGS_ASSIGN_OR_RETURN(
      const semantics::ModelInfo info,
      semantics::ExportClip(options, out, &context.cancellation));
  context.out << out << ": " << info.name << ", " << info.embedding_dim
              << " dimensions; use it with --bootstrap.model " << out << "\n";
  return Status();
}

}  // namespace freegs::stages
