#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Tests that a build can be repeated: builds the commit that is checked out twice, in
# folders whose paths differ in length, and compares the program, the page and the
# packages byte by byte.
#
#   scripts/reproducible.sh [FOLDER]
#
# FOLDER gets both builds, which take 1 GB. By default it is a new folder under TMPDIR
# that is deleted afterwards, unless the builds differ. No compile cache is used. The
# variable JOBS says how many compilers run at once (default: as many as there are
# cores).
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
here=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
jobs=${JOBS:-$(nproc)}
if (($# > 0)); then
  folder=$(cd "$here" && mkdir -p -- "$1" && realpath -- "$1")
  [[ -z $(ls -A -- "$folder") ]] || { echo "error: $folder is not empty" >&2; exit 3; }
else
  folder=$(mktemp -d --tmpdir freegs_reproducible.XXXXXX)
  trap 'rm -rf -- "$folder"' EXIT
fi
if [[ -n $(git status --porcelain) ]]; then
  echo "note: what is not committed is not built"
fi
export CCACHE_DISABLE=1

places=("$folder/a" "$folder/another_place/with_a_longer_name")
source=.
for place in "${places[@]}"; do
  echo "== $place ($SECONDS s)"
  git clone -q "$source" "$place"
  source=${places[0]}  # The second of the same commit, whatever happens here.
  cmake -S "$place" -B "$place/build" -G Ninja -DFREEGS_BUILD_TESTS=OFF >"$folder/log"
  cmake --build "$place/build" --parallel "$jobs" >>"$folder/log" ||
    { tail -n 30 "$folder/log" >&2; exit 1; }
  # The modes of a package's parts are in its header, and follow the umask of cpack.
  (umask 0022 && cd "$place/build" && cpack) >>"$folder/log" 2>&1 ||
    { tail -n 30 "$folder/log" >&2; exit 1; }
  # A second build on another day, and by somebody with other habits.
  umask 0027
  export TZ=Asia/Kolkata LC_ALL=C.UTF-8
done

echo "== comparing ($SECONDS s)"
list() {
  (cd "$1/build" && sha256sum bin/freegs_pipeline *.deb &&
    find share -type f -exec sha256sum {} + | LC_ALL=C sort -k 2)
}
list "${places[0]}" >"$folder/first"
list "${places[1]}" >"$folder/second"
cat "$folder/first"
if ! diff "$folder/first" "$folder/second"; then
  trap - EXIT  # Both builds stay.
  echo "error: the builds differ, see above; diffoscope tells where in a file." \
    "Both are kept:" >&2
  printf '  %s/build\n' "${places[@]}" >&2
  exit 1
fi
echo "the same bytes ($SECONDS s)"
