# shellcheck shell=bash
# SPDX-License-Identifier: BSD-3-Clause
# The functions that the reproduce_*.sh scripts share. They source this file, after they
# have set the variables benchmark (name), scenes (array) and get_data (a sentence that
# says where the data come from).
#
# It reads these variables of the environment:
#   PROGRAM   freegs_pipeline            (default: build/bin/freegs_pipeline)
#   OUT       folder for all results     (default: reproduce/NAME)
#   PRESET    fast, balanced or quality  (default: quality)
#   SCENES    names of scenes, to run only these

: "${benchmark:?}" "${get_data:?}"
unset CDPATH  # It would lead cd to other folders.
here=$PWD
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${PROGRAM:-$repository/build/bin/freegs_pipeline}
preset=${PRESET:-quality}
dry_run=0
# shellcheck disable=SC2034  # For those who source this.
data=""
run_options=()
failed=0

fail() {
  echo "$0: $*" >&2
  exit 3
}

# Reads [--dry-run] DATA [OPTION ...]; options go to `freegs_pipeline run`.
parse_arguments() {
  if [[ ${1:-} == --dry-run ]]; then
    dry_run=1
    shift
  fi
  if (($# == 0)) || [[ $1 == --* ]]; then
    echo "usage: $0 [--dry-run] DATA [OPTION ...]" >&2
    echo "$get_data" >&2
    exit 2
  fi
  [[ -d $1 ]] || fail "$1: no such folder. $get_data"
  # shellcheck disable=SC2034
  data=$(realpath -- "$1")
  shift
  run_options=("$@")
  out=${OUT:-$here/reproduce/$benchmark}
  if [[ -n ${SCENES:-} ]]; then
    read -r -a scenes <<<"$SCENES"
  fi
  if ((!dry_run)) && [[ ! -x $program ]]; then
    echo "$0: $program: no such program; build it first" \
      "(scripts/configure.sh build && cmake --build build), or name it in" \
      "PROGRAM" >&2
    exit 5
  fi
  mkdir -p -- "$out"  # Lists are written even when nothing is run.
}

# Says what it does, and does it.
do_it() {
  printf '+'
  printf ' %q' "$@"
  printf '\n'
  if ((!dry_run)); then "$@"; fi
}

# reproduce SCENE IMAGES TRUTH LAYOUT [OPTION ...]: runs the pipeline on IMAGES
# and evaluates against TRUTH. A scene that fails leaves its row of the table
# empty.
reproduce() {
  local scene=$1 images=$2 truth=$3 layout=$4
  shift 4
  rm -f -- "$out/$scene/eval.json"
  if ! do_it "$program" run "$images" "$out/$scene/workspace" \
    --preset "$preset" "$@" "${run_options[@]}" ||
    ! do_it "$program" eval "$out/$scene/workspace" --gt "$truth" \
      --layout "$layout" --json "$out/$scene/eval.json"; then
    echo "$0: $scene failed" >&2
    failed=1
  fi
}

# stem FILE: its name without folders, up to the first dot.
stem() {
  local name=${1##*/}
  printf '%s' "${name%%.*}"
}

# has_images FOLDER
has_images() {
  local file
  for file in "$1"/*; do
    case ${file,,} in
      *.jpg | *.jpeg | *.png) return 0 ;;
    esac
  done
  return 1
}

# sparse_of SCENE: its COLMAP model, if it has one.
sparse_of() {
  local folder
  for folder in "$1/sparse/0" "$1/sparse"; do
    if [[ -f $folder/images.bin || -f $folder/images.txt ]]; then
      printf '%s' "$folder"
      return
    fi
  done
}

# figure FILE KEY: a number at the top level of an evaluation, or nothing.
figure() {
  [[ -f $1 ]] || return 0
  sed -n "s/^  \"$2\": \\([-+.0-9eE]*\\),\\{0,1\\}\$/\\1/p" "$1"
}

# write_table KEYS PAPER: $out/results.csv and $out/results.md, one row per
# scene and one of means. PAPER is the name of an associative array: the paper's
# figure for the first key, by scene. Figures that are missing are
# left out of the mean.
write_table() {
  if ((dry_run)); then return; fi
  local -n keys_=$1 paper_=$2
  local scene key row
  {
    printf 'scene'
    for key in "${keys_[@]}"; do printf ',%s' "$key"; done
    printf ',paper_%s\n' "${keys_[0]}"
    for scene in "${scenes[@]}"; do
      row=$scene
      for key in "${keys_[@]}"; do
        row+=,$(figure "$out/$scene/eval.json" "$key")
      done
      printf '%s,%s\n' "$row" "${paper_[$scene]:-}"
    done
  } >"$out/results.csv"
  # In other locales numbers would have commas.
  LC_ALL=C awk -F, -v OFS=, '
    { print }
    NR == 1 { columns = NF; next }
    { for (i = 2; i <= NF; i++) if ($i != "") { sum[i] += $i; n[i]++ } }
    END {
      row = "mean"
      for (i = 2; i <= columns; i++)
        row = row OFS (n[i] ? sprintf("%.6g", sum[i] / n[i]) : "")
      print row
    }' "$out/results.csv" >"$out/results.csv.new"
  mv -- "$out/results.csv.new" "$out/results.csv"
  {
    awk -F, '
      { row = "|"; for (i = 1; i <= NF; i++) row = row " " $i " |"; print row }
      NR == 1 {
        row = "|"; for (i = 1; i <= NF; i++) row = row "---|"; print row
      }' "$out/results.csv"
    printf '\n%s, preset %s, %s; options:' "$benchmark" "$preset" \
      "$(git -C "$repository" describe --always --dirty 2>/dev/null ||
        echo 'unknown version')"
    printf ' %s' "${run_options[@]:-none}"
    printf '\n'
  } >"$out/results.md"
  cat -- "$out/results.md"
  # The table of what there is, and yet no success.
  if ((failed)); then exit 4; fi
}
