# SPDX-License-Identifier: BSD-3-Clause
# A new Debian 12 in a folder, for scripts that try what somebody with an empty
# machine would do. It is read by them with `source`, and offers
#
#   make_system           makes the system in the folder $system
#   inside COMMAND...     runs a command in it
#   step TEXT             prints what is done next, and the seconds so far
#   fail CODE TEXT        ends the script with an error
#
# It needs root, for chroot, and Debian's package debootstrap. The environment may
# say
#   MIRROR   where Debian's packages come from (default: as this system's apt)
#   SYSTEM   the folder of the new system (default: a new one under TMPDIR); it is
#            deleted at the end of the script unless KEEP is set
# shellcheck shell=bash
# shellcheck source=scripts/debian.sh
source "$(dirname "${BASH_SOURCE[0]}")/debian.sh"

fail() {
  echo "error: $2" >&2
  exit "$1"
}
step() { printf '== %s (%d s)\n' "$1" "$SECONDS"; }

mounted=()
clean_up_system() {
  local place
  for place in "${mounted[@]}"; do umount -- "$place"; done
  [[ -n ${KEEP:-} ]] || rm -rf --one-file-system -- "$system"
}
inside() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 HOME=/root \
    DEBIAN_FRONTEND=noninteractive chroot "$system" "$@"
}
make_system() {
  ((EUID == 0)) || fail 2 "only root can make and enter a new system; run sudo $0"
  command -v debootstrap >/dev/null ||
    fail 5 "debootstrap is missing; run apt-get install debootstrap"
  local mirror
  mirror=$(debian_mirror) || exit
  system=${SYSTEM:-$(mktemp -d --tmpdir freegs_new_system.XXXXXX)}
  mkdir -p -- "$system"
  [[ -z $(ls -A -- "$system") ]] || fail 3 "$system is not empty"
  chmod 755 -- "$system"
  trap clean_up_system EXIT
  step "a new system in $system"
  debootstrap --variant=minbase bookworm "$system" "$mirror" >"$system.log" ||
    fail 1 "debootstrap failed; see $system.log"
  rm -f -- "$system.log"
  mount -t proc proc "$system/proc"
  mounted+=("$system/proc")
  inside apt-get update -q >/dev/null
}
