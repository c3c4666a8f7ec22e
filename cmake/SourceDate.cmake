# SPDX-License-Identifier: BSD-3-Clause
# freegs_set_source_date(SOURCE) sets the environment variable
# SOURCE_DATE_EPOCH, unless it is set: the date of the commit that is checked out
# in SOURCE or, outside of a checkout, the date in its newest entry of
# CHANGELOG.md. What is packed carries this time, so that packing twice gives the
# same bytes.
function(freegs_set_source_date source)
  if(DEFINED ENV{SOURCE_DATE_EPOCH})
    return()
  endif()
  set(date "")
  find_program(git NAMES git)
  if(git AND EXISTS ${source}/.git)
    execute_process(COMMAND ${git} -C ${source} log -1 --format=%ct
      OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endif()
  if(NOT date MATCHES "^[0-9]+$")
    file(STRINGS ${source}/CHANGELOG.md heading LIMIT_COUNT 1
      REGEX "^## .* - [0-9]+-[0-9]+-[0-9]+$")
    string(REGEX MATCH "[0-9]+-[0-9]+-[0-9]+$" day "${heading}")
    execute_process(COMMAND date -u -d ${day} +%s
      OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE)
  endif()
  set(ENV{SOURCE_DATE_EPOCH} ${date})
endfunction()
