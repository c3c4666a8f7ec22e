# SPDX-License-Identifier: BSD-3-Clause
# Builds for 64-bit ARM on another machine with Debian's g++-aarch64-linux-gnu.
# Libraries come from the folder FREEGS_SYSROOT, a variable of CMake or of the
# environment, which scripts/arm64.sh makes; programs run in qemu-user-static.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

# Checks of CMake compile small projects, which read this file as well.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FREEGS_SYSROOT)
set(FREEGS_SYSROOT "$ENV{FREEGS_SYSROOT}" CACHE PATH
  "Folder of the libraries for arm64")
if(NOT FREEGS_SYSROOT OR NOT IS_DIRECTORY "${FREEGS_SYSROOT}/usr/lib/aarch64-linux-gnu")
  message(FATAL_ERROR "FREEGS_SYSROOT=${FREEGS_SYSROOT} is no folder with libraries "
    "for arm64; scripts/arm64.sh makes one")
endif()
set(CMAKE_SYSROOT ${FREEGS_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${FREEGS_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR}
  ${FREEGS_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${FREEGS_SYSROOT}/usr/share/pkgconfig)

find_program(FREEGS_QEMU qemu-aarch64-static NO_CMAKE_FIND_ROOT_PATH)
if(FREEGS_QEMU)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${FREEGS_QEMU} -L ${FREEGS_SYSROOT})
endif()
