# SPDX-License-Identifier: BSD-3-Clause
# Writes OUTPUT, a file with what PROGRAM prints when it is called with WORDS.
#   cmake "-DPROGRAM=[EMULATOR;]PROGRAM" "-DWORDS=completion;bash" -DOUTPUT=... \
#     -P WriteSaid.cmake
execute_process(COMMAND ${PROGRAM} ${WORDS}
  OUTPUT_VARIABLE said ERROR_VARIABLE error RESULT_VARIABLE result)
if(NOT result EQUAL 0 OR said STREQUAL "")
  list(JOIN WORDS " " words)
  message(FATAL_ERROR "freegs_pipeline ${words} failed (${result}): ${error}")
endif()
get_filename_component(folder ${OUTPUT} DIRECTORY)
file(MAKE_DIRECTORY ${folder})
if(NOT OUTPUT MATCHES "^(.*)\\.gz$")
  file(WRITE ${OUTPUT} "${said}")
  return()
endif()
# Without name and time in the header: the same text gives the same bytes.
file(WRITE ${CMAKE_MATCH_1} "${said}")
execute_process(COMMAND gzip -9nf ${CMAKE_MATCH_1} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "gzip ${CMAKE_MATCH_1} failed (${result})")
endif()
