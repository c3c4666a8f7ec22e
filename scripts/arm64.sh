#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds for 64-bit ARM on a machine of another kind, runs the tests of splat and
# semantics in QEMU, and finds the objects of one small scene with the program for
# ARM and with this machine's own: the field, instances, hierarchy and masks must
# have the same bytes.
#
#   scripts/arm64.sh [TEST_PROGRAM ...]     default: splat_test semantics_test
#   scripts/arm64.sh --scene                the scene without the tests
#
# Installs Debian's cross compiler, QEMU and mmdebstrap if they are missing. The
# libraries for ARM are unpacked in a folder of their own, so that nothing that is
# installed on this system is replaced. The script reads these variables of the
# environment:
#   BUILD     the build folder (default: build-arm64)
#   NATIVE    the build folder of this machine's own program (default: build)
#   FREEGS_SYSROOT   the folder of the libraries for ARM (default: BUILD/sysroot).
#             It is made if it is not there, and takes 2 GB.
#   MIRROR    the address of Debian's packages (default: the one that apt uses)
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=scripts/debian.sh
source scripts/debian.sh
build=${BUILD:-build-arm64}
native=${NATIVE:-build}
tests=("$@")
((${#tests[@]} > 0)) || tests=(splat_test semantics_test)
[[ ${tests[0]} != --scene ]] || tests=()

scripts/install_packages.sh --arm64
mkdir -p -- "$build"
build=$(cd "$build" && pwd)
export FREEGS_SYSROOT=${FREEGS_SYSROOT:-$build/sysroot}
lib=usr/lib/aarch64-linux-gnu

make_sysroot() {
  local mirror packages link target
  mirror=$(debian_mirror) || exit
  packages=$(package_names scripts/packages.txt | grep -E -- '-dev$' | paste -sd,)
  rm -rf -- "$FREEGS_SYSROOT.part"  # Of a run that was stopped.
  # Unpacked, not installed: no program for ARM runs.
  mmdebstrap --quiet --variant=extract --architectures=arm64 \
    --hook-dir=/usr/share/mmdebstrap/hooks/merged-usr \
    --include="$packages,libc6,libstdc++6,libgcc-s1" \
    bookworm "$FREEGS_SYSROOT.part" "deb $mirror bookworm main"
  # Links that begin with / would lead out of the folder.
  find "$FREEGS_SYSROOT.part" -type l -lname '/*' -print0 |
    while IFS= read -r -d '' link; do
      target=$FREEGS_SYSROOT.part$(readlink -- "$link")
      ln -sfnr -- "$target" "$link"
    done
  # What Debian's alternatives would link.
  for name in libblas.so libblas.so.3 liblapack.so liblapack.so.3 pkgconfig/hdf5.pc; do
    link=$FREEGS_SYSROOT.part/$lib/$name
    target=$(compgen -G "${link%/*}/*/${name##*/}" ||
      compgen -G "${link%.pc}-*.pc" || true)
    ln -sfnr -- "${target%%$'\n'*}" "$link"
  done
  # Libraries that CMake package files name as they would be on their own machine.
  sed -i "s|\([;\"]\)/$lib/|\1\${_IMPORT_PREFIX}/${lib#usr/}/|g" \
    "$FREEGS_SYSROOT.part/$lib/cmake/Ceres/CeresTargets.cmake"
  mv -- "$FREEGS_SYSROOT.part" "$FREEGS_SYSROOT"
}
if [[ ! -d $FREEGS_SYSROOT ]]; then
  echo "== libraries for arm64"
  make_sysroot
fi

echo "== build"
scripts/configure.sh "$build" --preset arm64 -DFREEGS_BUILD_TESTS=ON >/dev/null
cmake --build "$build" --parallel "$(nproc)" --target freegs_pipeline "${tests[@]}"

program=(qemu-aarch64-static -L "$FREEGS_SYSROOT" "$build/bin/freegs_pipeline")
"${program[@]}" --version
if ((${#tests[@]} > 0)); then
  echo "== tests ($SECONDS s)"
  ctest --test-dir "$build" --output-on-failure --no-tests=error \
    --parallel "$(nproc)" \
    --tests-regex "^($(IFS='|'; echo "${tests[*]}"))[.]"
fi

echo "== the same scene on both ($SECONDS s)"
scripts/configure.sh "$native" -DFREEGS_BUILD_TESTS=ON >/dev/null
cmake --build "$native" --parallel "$(nproc)" \
  --target freegs_pipeline freegs_make_scene
scene=$build/same_scene
rm -rf -- "$scene"
mkdir -- "$scene"
"$native/bin/freegs_make_scene" --out "$scene/drawn" --views 12 --width 240 \
  --height 180 --seed 1 >"$scene/drawn.log" 2>&1
"$native/bin/freegs_pipeline" run "$scene/drawn/images" "$scene/native" \
  --preset fast --bootstrap.mode geometry >"$scene/native.log" 2>&1
cp -r -- "$scene/native" "$scene/arm64"
rm -r -- "$scene/arm64/bootstrap" "$scene/arm64/export"
"${program[@]}" run "$scene/arm64" >"$scene/arm64.log" 2>&1
# compare FOLDER KIND: all files of that kind must have the same bytes.
compare() {
  local file all=0
  while IFS= read -r -d '' file; do
    cmp -- "$scene/native/$file" "$scene/arm64/$file"
    all=$((all + 1))
  done < <(cd "$scene/native" && find "$1" -name "$2" -print0)
  echo "$1/$2: $all of $all have the same bytes"
  ((all > 0))
}
compare bootstrap idsf.bin
compare bootstrap instances.json
compare bootstrap hierarchy.json
compare export/masks '*.png'
echo "passed ($SECONDS s)"
