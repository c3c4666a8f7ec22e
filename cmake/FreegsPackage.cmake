# SPDX-License-Identifier: BSD-3-Clause
# `cpack` in the build folder makes two Debian packages: freegs-pipeline, the
# program with all that it needs, and freegs-pipeline-dev, libraries and headers.
# docs/packaging.md says more.
set(FREEGS_MAINTAINER "FreeGS pipeline authors <freegs-pipeline@localhost>"
  CACHE STRING "Name and address that packages give as their maintainer's")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME freegs-pipeline)
set(CPACK_PACKAGE_CONTACT "${FREEGS_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/PackagePermissions.cmake)
set(CPACK_FREEGS_SOURCE ${PROJECT_SOURCE_DIR})
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/PackageOptions.cmake)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME freegs-pipeline)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS colmap)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
"photographs in, a 3D scene that knows its objects out
Reconstructs cameras with COLMAP, trains 3D Gaussian Splatting on the CPU and
finds the objects of the scene in 3D, without labels and without masks. Scenes
can be asked in words, by clicks and with example pictures, rendered from any
camera, and exported in common formats.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME freegs-pipeline-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
"libraries of freegs_pipeline for programs of one's own
Static libraries, headers and CMake package files: Gaussian Splatting on the
CPU, cameras from photographs, instances in 3D and queries of them.")
# What links the libraries needs all that the build needs.
file(STRINGS ${PROJECT_SOURCE_DIR}/scripts/packages.txt lines)
set(depends pkg-config)
set(heading "")
foreach(line IN LISTS lines)
  if(line MATCHES "^# (.*)$")
    set(heading "${CMAKE_MATCH_1}")
  elseif(heading STREQUAL "Libraries" AND line)
    list(APPEND depends ${line})
  endif()
endforeach()
list(JOIN depends ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)

# Documents of Debian's form are written when a component is packed, and are no
# part of `cmake --install`.
set(documents ${CMAKE_BINARY_DIR}/debian_documents)
foreach(component program development)
  string(TOUPPER ${component} upper)
  set(web_licences "")
  if(component STREQUAL "program" AND FREEGS_BUILD_WEB)
    set(web_licences ${CMAKE_BINARY_DIR}/share/freegs_pipeline/web/licenses.txt)
  endif()
  install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\"
      \"-DSOURCE=${PROJECT_SOURCE_DIR}\" \"-DOUTPUT=${documents}/${component}\"
      \"-DVERSION=${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}\"
      \"-DMAINTAINER=${FREEGS_MAINTAINER}\" \"-DWEB_LICENCES=${web_licences}\"
      -P \"${PROJECT_SOURCE_DIR}/cmake/DebianDocuments.cmake\"
      COMMAND_ERROR_IS_FATAL ANY)"
    COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(DIRECTORY ${documents}/${component}/
    DESTINATION share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()

if(NOT CMAKE_CROSSCOMPILING)
  find_program(FREEGS_SHLIBDEPS dpkg-shlibdeps)
  if(NOT FREEGS_SHLIBDEPS)
    message(STATUS "Packages would not name the libraries that they need: "
      "install dpkg-dev before cpack")
  endif()
endif()
include(CPack)
