# SPDX-License-Identifier: BSD-3-Clause
# Run by cpack before it packs. Folders that lead to what is installed are made
# with the umask of whoever builds; in a package everybody may enter them.
file(CHMOD_RECURSE ${CPACK_TEMPORARY_DIRECTORY}
  DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE
    GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
