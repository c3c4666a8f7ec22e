# shellcheck shell=bash
# SPDX-License-Identifier: BSD-3-Clause
# Debian's packages, for scripts that read this with `source`.

# The names in lists like packages.txt, one on a line: package_names LIST...
package_names() { sed 's/#.*//' "$@" | tr -s '[:space:]' '\n' | sed '/^$/d'; }

# Prints where packages of Debian 12 come from: MIRROR of the environment, or else
# what apt uses.
debian_mirror() {
  local mirror=${MIRROR:-}
  # shellcheck disable=SC2016  # apt-get expands it.
  [[ -n $mirror ]] || mirror=$(apt-get indextargets --format '$(REPO_URI)' \
    'Created-By: Packages' 'Release: bookworm' | head -n 1)
  if [[ -z $mirror ]]; then
    echo "error: apt knows no place of Debian 12; say it in MIRROR" >&2
    return 3
  fi
  echo "$mirror"
}
