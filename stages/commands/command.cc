// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/command.h"

#include "pipeline/workspace.h"

namespace freegs::stages {

void WarnOfRun(const std::filesystem::path& workspace,
               CommandContext& context) {
  if (!pipeline::IsLocked(workspace)) return;
  context.err << "warning: a run is working in " << workspace.string()
              << "; stages that it has not come to yet are older than those "
                 "before them, and may not fit to them\n";
}

}  // namespace freegs::stages
