# SPDX-License-Identifier: BSD-3-Clause
# Writes OUTPUT, a file that defines pipeline::ProgramCommit(), with the commit of
# the checkout SOURCE. It runs at each build and leaves a file that is right as it
# is, so that only a new commit has it compiled again.
#   cmake -DSOURCE=... -DOUTPUT=... -P WriteCommit.cmake
set(commit "")
# Only the checkout of these sources counts, not one that they were copied into.
if(EXISTS ${SOURCE}/.git)
  find_program(git NAMES git)
  if(git)
    execute_process(
      COMMAND ${git} -C ${SOURCE} describe --always --dirty --abbrev=12
        --exclude=*
      OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
      RESULT_VARIABLE result ERROR_QUIET)
    if(NOT result EQUAL 0)
      set(commit "")
    endif()
  endif()
endif()
if(NOT commit MATCHES "^[0-9a-f]+(-dirty)?$")
  set(commit "unknown")
endif()
set(text "// SPDX-License-Identifier: BSD-3-Clause
#include \"pipeline/version.h\"

namespace freegs::pipeline {

const char* ProgramCommit() { return \"${commit}\"; }

}  // namespace freegs::pipeline
")
set(before "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} before)
endif()
if(NOT before STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
