#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the Debian packages of packages.txt that are missing.
#
#   scripts/install_packages.sh [--check] [--tests] [--arm64] [--workflow]
#
# With --tests it also installs those of test_packages.txt, with --arm64 those of
# arm64_packages.txt, and with --workflow those of workflow_packages.txt. If none is
# missing, it does nothing and needs no network. With --check it only tells, by the exit
# status 0, whether none of them is missing.
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
cd "$(dirname "${BASH_SOURCE[0]}")"
# shellcheck source=scripts/debian.sh
source ./debian.sh

usage() { sed -n '3,/^set /s/^# \{0,1\}//p' "$(basename "${BASH_SOURCE[0]}")"; }
lists=(packages.txt)
check=0
for option in "$@"; do
  case $option in
    --check) check=1 ;;
    --tests) lists+=(test_packages.txt) ;;
    --arm64) lists+=(arm64_packages.txt) ;;
    --workflow) lists+=(workflow_packages.txt) ;;
    --help | -h) usage; exit ;;
    *) usage >&2; exit 2 ;;
  esac
done
mapfile -t packages < <(package_names "${lists[@]}")
# Programs that many people have from elsewhere, which Debian's would be in the
# way of.
declare -A program_of=([nodejs]=node [npm]=npm)
# The page needs Node.js 18.
usable() {
  command -v "$1" >/dev/null || return 1
  [[ $1 != node ]] || node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'
}
native=$(dpkg --print-architecture)
missing=()
for package in "${packages[@]}"; do
  program=${program_of[$package]:-}
  [[ -z $program ]] || ! usable "$program" || continue
  # One line for each architecture. A package that is on hold is installed, too.
  dpkg-query -W -f='${db:Status-Status} ${Architecture}\n' "$package" 2>/dev/null |
    grep -xE "installed ($native|all)" >/dev/null || missing+=("$package")
done
((${#missing[@]} > 0)) || exit 0
((!check)) || exit 1

echo "installing: ${missing[*]}"
as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "error: not root and no sudo; ask somebody who is to run:" >&2
    echo "  apt-get install ${missing[*]}" >&2
    exit 5
  fi
  as_root=(sudo)
fi
# When somebody else updates the lists, apt-get fails at once. Waits five minutes.
for ((tries = 60; ; --tries)); do
  said=$("${as_root[@]}" env LC_ALL=C apt-get update -q 2>&1) && break
  status=$?
  if ((tries == 0)) || [[ $said != *"Could not get lock"* ]]; then
    echo "$said" >&2
    exit "$status"
  fi
  echo "waiting: somebody else updates the lists of packages" >&2
  sleep 5
done
echo "$said"
# Waits when somebody else is installing.
"${as_root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive \
  apt-get install -q -y --no-install-recommends -o DPkg::Lock::Timeout=600 \
  "${missing[@]}"
