# SPDX-License-Identifier: BSD-3-Clause
# The program, the headers, the libraries and the CMake package files. Component
# program is what a user needs, development what a program of one's own needs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(freegs_libraries GLOBAL PROPERTY FREEGS_LIBRARIES)
install(TARGETS ${freegs_libraries} EXPORT freegs_targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(TARGETS freegs_pipeline
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
foreach(folder core photos sfm splat semantics pipeline stages)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/freegs COMPONENT development
    FILES_MATCHING PATTERN "*.h")
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/workspace_template/
  DESTINATION ${CMAKE_INSTALL_DATADIR}/freegs_pipeline/workspace_template
  COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/models
  DESTINATION ${CMAKE_INSTALL_DATADIR}/freegs_pipeline COMPONENT program)
# Packages have these in Debian's form (FreegsPackage).
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/freegs_pipeline)
install(EXPORT freegs_targets NAMESPACE freegs::
  FILE freegs_pipelineTargets.cmake DESTINATION ${package_folder}
  COMPONENT development)
configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/freegs_pipelineConfig.cmake.in
  ${CMAKE_BINARY_DIR}/freegs_pipelineConfig.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(
  ${CMAKE_BINARY_DIR}/freegs_pipelineConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_BINARY_DIR}/freegs_pipelineConfig.cmake
  ${CMAKE_BINARY_DIR}/freegs_pipelineConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FreegsDependencies.cmake
  DESTINATION ${package_folder} COMPONENT development)
