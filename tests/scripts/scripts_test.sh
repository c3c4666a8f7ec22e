#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Runs scripts of scripts/ in a copy of the checkout, with stand-ins for the programs
# that they call, so that nothing is installed or built.
#
#   tests/scripts/scripts_test.sh
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(realpath -- "$(mktemp -d)")
trap 'rm -rf "$folder"' EXIT
checkout="$folder/check out"
calls=$folder/calls
export calls
unset BUILD
mkdir -p "$checkout/build/bin" "$folder/programs" "$folder/elsewhere/garden"
cp -r -- "$here/../../scripts" "$checkout/"
echo colmap >"$checkout/scripts/packages.txt"
echo chromium-l10n >"$checkout/scripts/test_packages.txt"

fail() {
  echo "FAILED: $1" >&2
  tail -n 20 "$folder"/{out.txt,calls} >&2
  exit 1
}
has() { grep -qF -- "$2" "$1" || fail "$1 lacks: $2"; }
# stand_in PATH: a program whose script comes from standard input.
stand_in() {
  { echo '#!/bin/bash'; cat; } >"$1"
  chmod +x "$1"
}
programs=$folder/programs
stand_in "$programs/cmake" <<<'echo "cmake $*" >>"$calls"'
stand_in "$programs/clang-format-14" <<<'printf "format %s\n" "$@" >>"$calls"'
stand_in "$programs/ctest" <<<'exit 0'
stand_in "$programs/sudo" <<<'[[ $1 == -* ]] || exec "$@"'
stand_in "$programs/sleep" <<<'exec /bin/sleep 0.1'
stand_in "$programs/dpkg" <<<'echo amd64'
stand_in "$programs/dpkg-query" <<<'echo "installed all"'
stand_in "$checkout/build/bin/freegs_make_scene" <<<'mkdir -p "$2/images"'
stand_in "$checkout/build/bin/freegs_pipeline" <<'END'
printf '%s in %s:' "$1" "$PWD" >>"$calls"
printf ' <%s>' "${@:2}" >>"$calls"
echo >>"$calls"
[[ $1 != run ]] || echo "  freegs_pipeline query $3"
[[ $1 != eval ]] || echo "  holdout PSNR 30"
END
export PATH=$programs:$PATH
try() {
  : >"$calls"
  "$checkout/scripts/$1" "${@:2}" >"$folder/out.txt" 2>&1
}

# Help does nothing else.
for script in demo.sh test.sh install_packages.sh; do
  try $script --help || fail "$script --help"
  has "$folder/out.txt" "scripts/$script ["
  [[ ! -s $calls ]] || fail "$script --help began"
done

# Photos of one's own, from elsewhere: options hold there, and the workspace is not
# the one of the drawn photos.
cd "$folder/elsewhere"
try demo.sh garden --config own.ini || fail "demo.sh garden"
number=$(cksum <<<"$folder/elsewhere/garden" | cut -d ' ' -f 1)
has "$calls" "run in $folder/elsewhere: <$folder/elsewhere/garden> <$checkout/demo_workspace_garden_$number> <--preset> <fast> <--config> <own.ini>"
has "$folder/out.txt" "  $(printf %q "$checkout")/build/bin/freegs_pipeline query "
mkdir -p "$folder/other/garden"
try demo.sh "$folder/other/garden" || fail "demo.sh other/garden"
! grep -qF "demo_workspace_garden_$number>" "$calls" || fail "two folders have one workspace"
# `find` fails at a link that leads back to its folder, and the program does not.
ln -s . garden/self
try demo.sh garden || fail "demo.sh with a link that leads back"
has "$calls" "run in $folder/elsewhere: <$folder/elsewhere/garden> "
# A goal chooses the preset.
for goal in "--within 5m" --within=5m --at-least=psnr=27; do
  # shellcheck disable=SC2086
  try demo.sh garden $goal || fail "demo.sh $goal"
  has "$calls" "_$number> <${goal/ /> <}>"
  ! grep -q -e --preset "$calls" || fail "demo.sh $goal has a preset"
done
cd "$checkout"
try demo.sh || fail "demo.sh"
has "$calls" "<$checkout/demo_photos/images> <demo_workspace> "
has "$folder/out.txt" "  build/bin/freegs_pipeline query demo_workspace"
has "$folder/out.txt" "holdout PSNR"

# The formatting of all files is checked without git, but for those that are made.
touch build/CMakeCache.txt build/made.cc own.cc
mkdir -p build/Testing/Temporary core && touch build/Testing/Temporary/LastTest.log core/own.h
try test.sh || fail "test.sh"
has "$calls" "format ./own.cc"
has "$calls" "format ./core/own.h"
! grep -q made.cc "$calls" || fail "test.sh formats what was built"
has "$folder/out.txt" "the page, which is not built"
stand_in "$programs/clang-format-14" <<<'exit 1'
! try test.sh || fail "test.sh passes with wrong formatting"

# Installed is what there is for this processor or for all, even on hold or beside
# another architecture. The answers are those of dpkg-query to the format that it gets.
stand_in "$programs/apt-get" <<<'echo "apt-get $*" >>"$calls"'
stand_in "$programs/dpkg-query" <<'END'
[[ $2 == '-f=${db:Status-Status} ${Architecture}\n' && -n $states ]] || exit 1
printf '%b' "$states"
END
export states
for states in "installed amd64\n" "installed all\n" \
  "installed amd64\ninstalled i386\n"; do
  try install_packages.sh --check || fail "missing: $states"
  try install_packages.sh || fail "not installed: $states"
  [[ ! -s $calls ]] || fail "installs again: $states"
done
for states in "" "installed i386\n" "not-installed amd64\n" \
  "config-files amd64\ninstalled i386\n"; do
  ! try install_packages.sh --check || fail "not missing: $states"
  [[ ! -s $calls ]] || fail "--check installs"
  try install_packages.sh --tests || fail "install_packages.sh: $states"
  has "$calls" " colmap chromium-l10n"
done
for option in --test --cheque colmap; do
  code=0
  try install_packages.sh --check $option || code=$?
  [[ $code == 2 && ! -s $calls ]] || fail "install_packages.sh $option: exit $code"
  has "$folder/out.txt" "scripts/install_packages.sh ["
done

# Waits while somebody else has the lists of packages, and for nothing else.
stand_in "$programs/dpkg-query" <<<'exit 1'
stand_in "$programs/apt-get" <<'END'
echo "apt-get $1" >>"$calls"
if [[ $1 == update && $(grep -c update "$calls") -lt 3 ]]; then
  echo "E: $said" >&2
  exit 100
fi
END
export said="Could not get lock /var/lib/apt/lists/lock."
try install_packages.sh || fail "the lock is not waited for"
has "$calls" "apt-get install"
export said="no network"
code=0
try install_packages.sh || code=$?
[[ $code == 100 && $(grep -c update "$calls") == 1 ]] || fail "no network: exit $code"
has "$folder/out.txt" "no network"

# CDPATH leads no script to folders of the same names elsewhere.
mkdir -p "$folder/cdpath/scripts" "$folder/cdpath/build-asan" build-asan tests
touch tests/sanitizer_suppressions.txt
stand_in "$programs/dpkg-query" <<<'echo "installed all"'
for call in sanitize.sh "install_packages.sh --check" "demo.sh ../elsewhere/garden"; do
  # shellcheck disable=SC2086
  CDPATH=$folder/cdpath scripts/$call >"$folder/out.txt" 2>&1 || fail "$call with CDPATH"
done
[[ -f build-asan/leaks.txt && -z $(ls -A "$folder/cdpath/build-asan") ]] ||
  fail "sanitize.sh with CDPATH is elsewhere"
while IFS= read -r script; do
  has "$script" "unset CDPATH"
done < <(grep -rlE --include='*.sh' '(^|[;&(| ])cd ' "$here/../../scripts" "$here/..")

# A Python without PIL or without PyTorch skips the test of the exporter.
if python=$(command -v python3); then
  mkdir -p "$folder/modules"
  for missing in torch:python3-torch PIL:python3-pil; do
    echo "" >"$folder/modules/torch.py"
    echo "raise ImportError" >"$folder/modules/${missing%:*}.py"
    code=0
    PYTHONPATH=$folder/modules "$python" "$here/export_clip_test.py" \
      >"$folder/out.txt" 2>&1 || code=$?
    [[ $code == 77 ]] || fail "export_clip_test.py without ${missing%:*}: exit $code"
    has "$folder/out.txt" "skipped: ${missing#*:} is not installed"
  done
fi

# The browser is found wherever PATH says.
if node=$(command -v node); then
  browse() {
    PATH=$folder/browser "$node" "$here/../web/run.mjs" "$folder" none >"$folder/out.txt" || true
  }
  unset CHROMIUM
  browse
  has "$folder/out.txt" "there is no Chromium"
  mkdir "$folder/browser" && stand_in "$folder/browser/google-chrome" </dev/null
  browse
  has "$folder/out.txt" "the page is not built"
fi
echo "passed"
