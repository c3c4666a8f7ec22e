# SPDX-License-Identifier: BSD-3-Clause
# What the program says of itself: completion for bash and zsh and its manual page,
# written by running the program that was just built.
include(GNUInstallDirs)
if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
  message(STATUS "No completion for shells and no manual page: the program for "
    "${CMAKE_SYSTEM_PROCESSOR} cannot run here. Set CMAKE_CROSSCOMPILING_EMULATOR")
  return()
endif()

# freegs_add_said_file(OUTPUT WORD ...) writes the file OUTPUT with what the
# program prints when it is called with these words; a file that ends in .gz is
# compressed.
set(said_folder ${CMAKE_BINARY_DIR}/share)
set(said_files "")
function(freegs_add_said_file output)
  add_custom_command(
    OUTPUT ${said_folder}/${output}
    COMMAND ${CMAKE_COMMAND} "-DPROGRAM=${CMAKE_CROSSCOMPILING_EMULATOR};$<TARGET_FILE:freegs_pipeline>"
      "-DWORDS=${ARGN}" -DOUTPUT=${said_folder}/${output}
      -P ${PROJECT_SOURCE_DIR}/cmake/WriteSaid.cmake
    DEPENDS freegs_pipeline ${PROJECT_SOURCE_DIR}/cmake/WriteSaid.cmake
    COMMENT "Writing ${output}"
    VERBATIM)
  set(said_files ${said_files} ${said_folder}/${output} PARENT_SCOPE)
  get_filename_component(folder ${output} DIRECTORY)
  install(FILES ${said_folder}/${output}
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${folder} COMPONENT program)
endfunction()

freegs_add_said_file(bash-completion/completions/freegs_pipeline completion bash)
freegs_add_said_file(zsh/vendor-completions/_freegs_pipeline completion zsh)
freegs_add_said_file(man/man1/freegs_pipeline.1.gz manual man)
add_custom_target(freegs_said ALL DEPENDS ${said_files})
