#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Does what somebody does who has a new Debian 12 and nothing else: clones the
# commit that is checked out, and runs scripts/demo.sh. Then it asks the three
# questions that the demo ends with.
#
#   scripts/demo_test.sh [PHOTOS [OPTION ...]]       as for scripts/demo.sh
#
# It needs root and debootstrap; scripts/new_system.sh tells what the environment
# may say. The new system takes 5 GB.
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
here=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/new_system.sh
photos=()
if (($# > 0)) && [[ $1 != --* ]]; then
  photos=(/trial/photos)
  source_photos=$(cd "$here" && realpath -- "$1")
  shift
fi
make_system

step "git, and a clone of $(git rev-parse --short HEAD)"
inside apt-get install -q -y --no-install-recommends git ca-certificates \
  >/dev/null 2>&1
# /trial is a folder of the new system.
mkdir -- "$system/trial"
git clone -q . "$system/trial/freegs"
((${#photos[@]} == 0)) || cp -rL -- "$source_photos" "$system/trial/photos"
# The network is reached as from here.
for file in /etc/resolv.conf /etc/hosts /etc/npmrc /etc/ssl/certs/ca-certificates.crt; do
  [[ ! -f $file ]] || cp -L -- "$file" "$system$file"
done

step "scripts/demo.sh"
start=$SECONDS
inside sh -c 'cd /trial/freegs && exec scripts/demo.sh "$@"' sh \
  "${photos[@]}" "$@" </dev/null | tee "$system/trial/end"
step "the demo took $((SECONDS - start)) s"

step "what it proposes"
questions=$(grep -E '^  build/bin/freegs_pipeline query ' "$system/trial/end") ||
  fail 1 "the demo ends without a question"
while read -r question; do
  echo "$question"
  inside sh -c "cd /trial/freegs && $question" </dev/null
done <<<"$questions"
page=$(sed -nE 's|^  file://(.*)|\1|p' "$system/trial/end")
[[ -s $system$page ]] || fail 1 "there is no page at $page"
grep -q 'WebGL' "$system$page" || fail 1 "the page has no 3D view"
step "passed"
