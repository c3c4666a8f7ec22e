# SPDX-License-Identifier: BSD-3-Clause
# cpack reads this file before it packs anything; CPACK_FREEGS_SOURCE is the
# source folder.
include(${CPACK_FREEGS_SOURCE}/cmake/SourceDate.cmake)
freegs_set_source_date(${CPACK_FREEGS_SOURCE})
