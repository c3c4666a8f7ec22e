# SPDX-License-Identifier: BSD-3-Clause
# Writes the documents that every Debian package has: the folder OUTPUT gets
# copyright, changelog.gz and changelog.Debian.gz.
#   cmake -DSOURCE=... -DOUTPUT=... -DVERSION=0.1.0-1 -DMAINTAINER="A <a@b>" \
#     [-DWEB_LICENCES=FILE] -P DebianDocuments.cmake
include(${CMAKE_CURRENT_LIST_DIR}/SourceDate.cmake)
file(REMOVE_RECURSE ${OUTPUT})
file(MAKE_DIRECTORY ${OUTPUT})

function(write_compressed name text)
  file(WRITE ${OUTPUT}/${name} "${text}")
  execute_process(COMMAND gzip -9n ${OUTPUT}/${name} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "gzip ${OUTPUT}/${name} failed (${result})")
  endif()
endfunction()

# The date of the commit; string(TIMESTAMP) heeds SOURCE_DATE_EPOCH.
freegs_set_source_date(${SOURCE})
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
write_compressed(changelog.Debian "freegs-pipeline (${VERSION}) bookworm; urgency=medium

  * What is new is said in changelog.gz.

 -- ${MAINTAINER}  ${date}
")
file(READ ${SOURCE}/CHANGELOG.md changelog)
write_compressed(changelog "${changelog}")

file(READ ${SOURCE}/LICENSE licence)
set(copyright "freegs_pipeline makes 3D scenes that know their objects of photographs.
The program, its page, the small CLIP model and the texts are under this licence:

${licence}
Parts of these libraries are compiled into the program:

  Ceres Solver     Google Inc. and others       BSD-3-Clause
  nlohmann JSON    Niels Lohmann                MIT
  Eigen            the Eigen developers         MPL-2.0, with parts in BSD-3-Clause
  Boost            the Boost developers         BSL-1.0
  FLANN            Marius Muja, David Lowe      BSD-3-Clause
  Highway          Google LLC and others        Apache-2.0
  cpp-httplib      Yuji Hirose                  MIT

Eigen's source is that of Debian's package eigen3; its licence, MPL-2.0, is
/usr/share/common-licenses/MPL-2.0. What Debian says of the others follows; Boost's
licence asks for nothing in programs.
")
foreach(package libceres-dev nlohmann-json3-dev libflann-dev libhwy-dev
    libcpp-httplib-dev)
  if(EXISTS /usr/share/doc/${package}/copyright)
    file(READ /usr/share/doc/${package}/copyright text)
    string(APPEND copyright "\n== ${package}\n\n${text}")
  endif()
endforeach()
if(WEB_LICENCES AND EXISTS ${WEB_LICENCES})
  file(READ ${WEB_LICENCES} web)
  # Debian has this long text once for all packages.
  string(FIND "${web}" "Apache License\n" begin)
  string(FIND "${web}" "limitations under the License." end)
  if(begin GREATER -1 AND end GREATER begin)
    string(SUBSTRING "${web}" 0 ${begin} before)
    string(SUBSTRING "${web}" ${end} -1 after)
    string(REPLACE "limitations under the License."
      "The Apache License is /usr/share/common-licenses/Apache-2.0." after "${after}")
    set(web "${before}${after}")
  endif()
  string(APPEND copyright
    "\nOf the page, /usr/share/freegs_pipeline/web: ${web}")
endif()
file(WRITE ${OUTPUT}/copyright "${copyright}")
