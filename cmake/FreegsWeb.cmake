# SPDX-License-Identifier: BSD-3-Clause
# The page's script, bundled from web/ by esbuild. npm fetches what the lock file
# names. Without Node.js the program is the same, and its pages have no 3D view.
find_program(FREEGS_NODE node)
find_program(FREEGS_NPM npm)
set(node_version 0)
if(FREEGS_NODE)
  execute_process(COMMAND ${FREEGS_NODE} --version
    OUTPUT_VARIABLE node_version OUTPUT_STRIP_TRAILING_WHITESPACE)
  string(REGEX REPLACE "^v" "" node_version "${node_version}")
endif()
include(GNUInstallDirs)
set(FREEGS_BUILD_WEB AUTO CACHE STRING
  "Build the 3D view of the page (ON, OFF, or AUTO: where Node.js 18 and npm are)")
# Found out anew each time, so that Node.js can come later.
if(FREEGS_BUILD_WEB STREQUAL "AUTO")
  if(FREEGS_NPM AND node_version VERSION_GREATER_EQUAL 18)
    set(FREEGS_BUILD_WEB ON)
  else()
    set(FREEGS_BUILD_WEB OFF)
  endif()
endif()
if(NOT FREEGS_BUILD_WEB)
  message(STATUS "The page will have no 3D view: "
    "FREEGS_BUILD_WEB is off, or Node.js 18 with npm was not found")
  # One of an earlier build would not fit the program any more.
  file(REMOVE_RECURSE ${CMAKE_BINARY_DIR}/share/freegs_pipeline/web)
  return()
endif()

# npm works in a copy, so that the source folder stays as it is.
set(web ${CMAKE_BINARY_DIR}/web)
set(web_out ${CMAKE_BINARY_DIR}/share/freegs_pipeline/web)
# Paths are arguments of the script, as a shell would read quotes in them as its own.
# `cmake -E chdir` may lose quotes of a script. In the message the build folder is
# quoted, so that the line can be pasted.
string(REPLACE "'" "'\\''" build_word "${CMAKE_BINARY_DIR}")
string(CONCAT fetch
  [[cd "$1" && "$2" ci --no-progress || { printf '%s\n' "The packages of the page ]]
  [[cannot be fetched. To go on without its 3D view, run: scripts/configure.sh $3 ]]
  [[-DFREEGS_BUILD_WEB=OFF and then the same command again." >&2; exit 1; }]])
file(GLOB_RECURSE web_sources CONFIGURE_DEPENDS
  ${PROJECT_SOURCE_DIR}/web/src/* ${PROJECT_SOURCE_DIR}/web/*.html)
add_custom_command(
  OUTPUT ${web}/node_modules/.package-lock.json
  COMMAND ${CMAKE_COMMAND} -E make_directory ${web}
  COMMAND ${CMAKE_COMMAND} -E copy
    ${PROJECT_SOURCE_DIR}/web/package.json
    ${PROJECT_SOURCE_DIR}/web/package-lock.json
    ${PROJECT_SOURCE_DIR}/web/.npmrc ${web}
  COMMAND sh -c "${fetch}" sh ${web} ${FREEGS_NPM} "'${build_word}'"
  COMMAND ${CMAKE_COMMAND} -E touch ${web}/node_modules/.package-lock.json
  DEPENDS
    ${PROJECT_SOURCE_DIR}/web/package.json
    ${PROJECT_SOURCE_DIR}/web/package-lock.json
    ${PROJECT_SOURCE_DIR}/web/.npmrc
  COMMENT "Fetching the packages of the page"
  VERBATIM)
add_custom_command(
  OUTPUT ${web_out}/viewer.js ${web_out}/bench.js
  # Without it, sources that were removed would stay in the copy.
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${web}/src
  COMMAND ${CMAKE_COMMAND} -E copy_directory ${PROJECT_SOURCE_DIR}/web/src ${web}/src
  COMMAND ${CMAKE_COMMAND} -E copy
    ${PROJECT_SOURCE_DIR}/web/build.mjs
    ${PROJECT_SOURCE_DIR}/web/plot.mjs
    ${PROJECT_SOURCE_DIR}/web/live.html
    ${PROJECT_SOURCE_DIR}/web/tsconfig.json ${web}
  COMMAND ${FREEGS_NODE} ${web}/node_modules/typescript/bin/tsc -p ${web}
  COMMAND ${FREEGS_NODE} ${web}/build.mjs ${web_out}
  DEPENDS
    ${web}/node_modules/.package-lock.json
    ${PROJECT_SOURCE_DIR}/web/build.mjs
    ${PROJECT_SOURCE_DIR}/web/plot.mjs
    ${PROJECT_SOURCE_DIR}/web/tsconfig.json
    ${web_sources}
  COMMENT "Checking and bundling the page"
  VERBATIM)
add_custom_target(freegs_web ALL DEPENDS ${web_out}/viewer.js)
install(DIRECTORY ${web_out}
  DESTINATION ${CMAKE_INSTALL_DATADIR}/freegs_pipeline COMPONENT program)
