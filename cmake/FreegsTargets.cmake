# SPDX-License-Identifier: BSD-3-Clause
# One library per room (a folder of sources), a collection of rooms for each
# top-level folder, and one test program per top-level folder.
include(GNUInstallDirs)

add_library(freegs_warnings INTERFACE)
target_compile_options(freegs_warnings INTERFACE -Wall -Wextra -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION MATCHES "^12")
  # False alarms on "literal" + std::string (GCC bug 105651).
  target_compile_options(freegs_warnings INTERFACE -Wno-restrict)
endif()
if(FREEGS_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # What sanitizers add to the code makes GCC see uninitialised values and
  # overflows where there are none. Ordinary builds have no warnings.
  target_compile_options(freegs_warnings INTERFACE -Wno-error)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC collects its garbage only beyond this many kB: a tenth less time for at
  # most 2 GB a compiler.
  target_compile_options(freegs_warnings INTERFACE
    "SHELL:--param ggc-min-heapsize=1000000")
endif()
if(FREEGS_SANITIZE)
  target_compile_options(freegs_warnings INTERFACE
    -fsanitize=${FREEGS_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(freegs_warnings INTERFACE -fsanitize=${FREEGS_SANITIZE})
endif()
if(FREEGS_FUZZ)
  # Coverage of the libraries guides the fuzzer, which only its targets link.
  target_compile_options(freegs_warnings INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Large headers of the standard library, Eigen, GoogleTest and JSON, compiled once
# for all files of one optimisation level. Headers of ours are not among them: every
# file still includes what it uses (a build with FREEGS_PCH=OFF shows it).
function(freegs_add_precompiled_headers target)
  file(WRITE ${CMAKE_BINARY_DIR}/generated/${target}.cc "")
  add_library(${target} OBJECT ${CMAKE_BINARY_DIR}/generated/${target}.cc)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen freegs_warnings)
  target_precompile_headers(${target} PRIVATE
    <algorithm> <array> <atomic> <cmath> <cstdint> <filesystem> <functional>
    <map> <memory> <mutex> <optional> <set> <span> <sstream> <string>
    <string_view> <thread> <utility> <variant> <vector>
    <Eigen/Core> <Eigen/Geometry> ${ARGN})
endfunction()
if(FREEGS_PCH)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_LAUNCHER)
    add_compile_options(-fpch-preprocess)  # Else ccache keeps nothing.
  endif()
  freegs_add_precompiled_headers(freegs_pch)
  freegs_add_precompiled_headers(freegs_pch_cold <nlohmann/json.hpp>)
  target_compile_options(freegs_pch_cold PRIVATE $<$<CONFIG:Release>:-O1>)
endif()

# What Highway compiles for. SSSE3 is left out: processors that have it but not SSE4
# date from before 2008, and use the scalar code. The vectors of SVE have no size
# that a compiler knows and cannot be members of a class; processors with SVE use
# NEON.
set(FREEGS_INSTRUCTION_SETS
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")

# freegs_add_library(NAME SOURCES a.cc ... LINK libraries ... LINK_PRIVATE ...)
# makes freegs_NAME. LINK is what the headers include, LINK_PRIVATE what only the
# sources do. With COLD it is compiled with -O1 instead of -O3: code that waits for
# files and other programs, or calls rooms that do the work.
function(freegs_add_library name)
  cmake_parse_arguments(ARG "COLD" "" "SOURCES;LINK;LINK_PRIVATE" ${ARGN})
  set(target freegs_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(freegs::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/freegs>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set(pch freegs_pch)
  if(ARG_COLD)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
    set(pch freegs_pch_cold)
  endif()
  if(FREEGS_PCH)
    target_precompile_headers(${target} REUSE_FROM ${pch})
  endif()
  if(FREEGS_UNITY)
    set_target_properties(${target} PROPERTIES
      UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${FREEGS_UNITY_BATCH})
  endif()
  # Files that Highway compiles once for each instruction set include themselves,
  # so they stay alone. They get -O3 in cold rooms too.
  # No file is read in them, and Clang needs up to ten minutes for one of them with
  # sanitizers, so fuzzers are built without.
  set(options $<$<CONFIG:Release>:-O3>)
  if(FREEGS_FUZZ)
    list(APPEND options -fno-sanitize=all)
  endif()
  foreach(source IN LISTS ARG_SOURCES)
    file(STRINGS ${source} alone REGEX "hwy/foreach_target.h" LIMIT_COUNT 1)
    if(alone)
      set_source_files_properties(${source} PROPERTIES
        SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON
        COMPILE_DEFINITIONS "${FREEGS_INSTRUCTION_SETS}"
        COMPILE_OPTIONS "${options}")
    endif()
  endforeach()
  target_link_libraries(${target} PUBLIC ${ARG_LINK}
    PRIVATE ${ARG_LINK_PRIVATE} $<BUILD_INTERFACE:freegs_warnings>)
  set_property(GLOBAL APPEND PROPERTY FREEGS_LIBRARIES ${target})
endfunction()

# freegs_add_program(NAME SOURCE main.cc LINK libraries ...) makes the program NAME.
# An executable's own files are compiled with other flags than the precompiled
# headers, so the file is an object library.
function(freegs_add_program name)
  cmake_parse_arguments(ARG "" "SOURCE" "LINK" ${ARGN})
  add_library(${name}_main OBJECT ${ARG_SOURCE})
  target_link_libraries(${name}_main PRIVATE ${ARG_LINK} freegs_warnings)
  target_compile_options(${name}_main PRIVATE $<$<CONFIG:Release>:-O1>)
  if(FREEGS_PCH)
    target_precompile_headers(${name}_main REUSE_FROM freegs_pch_cold)
  endif()
  add_executable(${name} $<TARGET_OBJECTS:${name}_main>)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} freegs_warnings)
endfunction()

# freegs_add_collection(NAME ROOMS a b ...) makes freegs::NAME, which links the
# rooms freegs::a, freegs::b, ...
function(freegs_add_collection name)
  cmake_parse_arguments(ARG "" "" "ROOMS" ${ARGN})
  set(target freegs_${name})
  add_library(${target} INTERFACE)
  add_library(freegs::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  foreach(room IN LISTS ARG_ROOMS)
    target_link_libraries(${target} INTERFACE freegs::${room})
  endforeach()
  set_property(GLOBAL APPEND PROPERTY FREEGS_LIBRARIES ${target})
endfunction()

# Gold links a test program in a quarter of the time.
set(FREEGS_FAST_LINKER "")
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND NOT CMAKE_CROSSCOMPILING
    AND NOT FREEGS_SANITIZE AND NOT FREEGS_FUZZ)
  find_program(FREEGS_GOLD ld.gold)
  mark_as_advanced(FREEGS_GOLD)
  if(FREEGS_GOLD)
    set(FREEGS_FAST_LINKER -fuse-ld=gold)
  endif()
endif()

# freegs_add_test(NAME SOURCES a_test.cc ... LINK libraries ...) makes NAME. Its
# tests run in portions, NAME.0, NAME.1, ...: the loader needs up to 0.4 s for a
# program that uses OpenCV, too much for a process per test. There is a portion for
# every six files, or as many as PORTIONS says.
function(freegs_add_test name)
  cmake_parse_arguments(ARG "" "PORTIONS" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} freegs_warnings
    GTest::gmock GTest::gtest GTest::gtest_main)
  target_link_options(${name} PRIVATE ${FREEGS_FAST_LINKER})
  if(FREEGS_UNITY)
    set_target_properties(${name} PROPERTIES
      UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${FREEGS_UNITY_BATCH})
  endif()
  # Tests are compiled more often than they run.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O0>)
  if(FREEGS_PCH)
    target_precompile_headers(${name} REUSE_FROM freegs_pch_tests)
    # As the headers were compiled: an executable's flags differ otherwise.
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  endif()
  list(LENGTH ARG_SOURCES num_files)
  math(EXPR num_portions "(${num_files} + 5) / 6")
  if(ARG_PORTIONS)
    set(num_portions ${ARG_PORTIONS})
  endif()
  math(EXPR last "${num_portions} - 1")
  # An emulator takes some twenty times as long.
  set(timeout 600)
  if(CMAKE_CROSSCOMPILING)
    set(timeout 7200)
  endif()
  foreach(portion RANGE ${last})
    add_test(NAME ${name}.${portion} COMMAND ${name})
    set_tests_properties(${name}.${portion} PROPERTIES TIMEOUT ${timeout} ENVIRONMENT
      "GTEST_TOTAL_SHARDS=${num_portions};GTEST_SHARD_INDEX=${portion}")
  endforeach()
endfunction()
