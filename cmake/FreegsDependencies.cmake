# SPDX-License-Identifier: BSD-3-Clause
# Everything comes from the system (scripts/packages.txt lists Debian's names);
# nothing is downloaded at configure time. Also used by the installed package.
include(CMakeFindDependencyMacro)

find_dependency(Threads)
find_dependency(Eigen3 3.3 NO_MODULE)
find_dependency(Ceres)
find_dependency(OpenCV COMPONENTS core imgproc imgcodecs features2d dnn video videoio)
find_dependency(JPEG)
find_dependency(Protobuf)
find_dependency(ONNX)
find_dependency(ZLIB)
find_dependency(Boost COMPONENTS program_options)
find_dependency(hwy)
find_dependency(nlohmann_json)
find_dependency(PkgConfig)
pkg_check_modules(FLANN REQUIRED IMPORTED_TARGET flann)
pkg_check_modules(HTTPLIB REQUIRED IMPORTED_TARGET cpp-httplib)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(SQLITE3 REQUIRED IMPORTED_TARGET sqlite3)
