#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Too little memory, and threads that cannot be made.
#
#   tests/faults/memory.sh BIN FOLDER [short]
#
# A limit of threads needs root and is left out without it. common.sh says the rest.
# shellcheck disable=SC2034  # common.sh reads it.
num_threads=2
# shellcheck source=tests/faults/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

options+=(--reconstruct.iterations 60)

# survives_memory_limit KB SAME OPTION...: a run with the limit is done or says why not,
# and one without it ends with what SAME asks for. With few bytes, GDAL, which OpenCV
# calls when it reads the first photo, and Ceres, whose timer throws while it is
# destroyed, end the process themselves (134 or 139), and say so.
survives_memory_limit() {
  rm -rf w
  { (ulimit -c 0 -v "$1" && run w "${@:3}"); } 2>/dev/null
  case $? in
    0) ;;
    1) grep -q "memory" out.txt ;;
    134 | 139) grep -qE "GDAL|std::bad_alloc" out.txt ;;
    *) false ;;
  esac && run w "${@:3}" && "$2" w
}
# survives_thread_limit THREADS: root has no limit, so another user runs it.
survives_thread_limit() {
  rm -rf w && mkdir -m 777 w
  setpriv --reuid 61234 --clear-groups bash -c "ulimit -u $1; exec \"\$@\"" bash \
    "$program" run scene/images w "${known_poses[@]}" "${options[@]}" >out.txt 2>&1 &&
    same_scene w
}

run_undisturbed reference "${known_poses[@]}" --to bootstrap
run_undisturbed reference_poses --to sfm
limits=0
for limit in $(every_fifth_if_short {320000..390000..6000}); do
  # Below some limit not even the libraries can be loaded.
  { (ulimit -c 0 -v "$limit" && "$program" --version); } >/dev/null 2>&1 || continue
  limits=$((limits + 1))
  report "ulimit -v $limit" survives_memory_limit "$limit" same_scene \
    "${known_poses[@]}" --to bootstrap
done
[ $limits -gt 0 ] || report "none of the limits lets the libraries be loaded" false
for limit in $(every_fifth_if_short {400000..520000..40000}); do
  report "ulimit -v $limit with COLMAP" survives_memory_limit "$limit" same_poses --to sfm
done
if [ "$(id -u)" = 0 ] && setpriv --reuid 61234 --clear-groups \
  test -x "$program" -a -r scene/images; then
  for threads in $(every_fifth_if_short 1 2 3); do
    report "ulimit -u $threads" survives_thread_limit "$threads"
  done
else
  echo "left out: a limit of threads needs root, and folders that all may read"
fi
verdict
