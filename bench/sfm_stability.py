#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Photo sets on which structure from motion fails or may fail: what COLMAP
alone says, what our stage sfm says, and whether that is right.

  bench/sfm_stability.py PROGRAM DATA OUT [--only SETS] [--skip-colmap]
      [--make-scene FILE] [--limit 1800] [--again ours|colmap|both] [--list]

PROGRAM is freegs_pipeline; DATA holds fox, tabletop, playroom and plainwall,
each with images/ and gt/cameras.json or transforms.json, and bonsai, real/desk,
real/fruit, real/kumamon and real/flower, which have images/ only. The sets are made in
OUT/sets, runs leave logs and models in OUT/runs. What was measured is kept in
OUT/results, one file per set and program, and not measured again unless
--again says so; so the script can be run in pieces. Prints a table in Markdown
of all that is there, with what each attempt did, and writes it to OUT/table.md. Blurred and darkened photos
need Pillow (Debian: python3-pil, /usr/bin/python3).

A run is wrong when its verdict is not among those allowed for the set, its exit
code contradicts the verdict (0 ok and degraded, 4 failed), a verdict other than
ok lacks reason or advice, or photos left out are not named. A silent failure:
exit code 0 and verdict ok, or COLMAP's exit code 0, although fewer than 90 % of
the photos have a pose, a photo stands more than 5 degrees or 5 % of the scene's
size from its place, photos of another scene are in the model, or there is
nothing to be had. COLMAP is judged by its largest model, in its favour.
"""
import hashlib
import json
import sys
from pathlib import Path

import camera_poses
import sfm_programs
from peer_figures import argument_parser
from sfm_photo_sets import DEGRADED, FAILED, FOREIGN, OK, SETS

GOOD_SHARE = 0.9
EXIT_CODES = {OK: 0, DEGRADED: 0, FAILED: 4}


def make_set(name, arguments):
    """(folder of images, what is known of it)."""
    folder = Path(arguments.out, "sets", name)
    known = folder / "set.json"
    if not known.is_file():
        sfm_programs.fresh(folder)
        (folder / "images").mkdir()
        maker = arguments.make_scene or str(
            Path(arguments.program).resolve().parent / "freegs_make_scene")
        truth = SETS[name].build(arguments.data, maker, folder)
        known.write_text(json.dumps({
            "photos": len(list((folder / "images").iterdir())),
            "foreign": len(list((folder / "images").glob(FOREIGN + "*"))),
            "truth": str(truth.resolve()) if truth else None}),
            encoding="utf-8")
    return folder / "images", json.loads(known.read_text(encoding="utf-8"))


def add_truth(row, known):
    """How many photos of the model are where they should not be."""
    row["total"] = known["photos"]
    if "model" not in row:
        return
    poses = camera_poses.read_model(row["model"])
    row["foreign"] = sum(name.startswith(FOREIGN) for name in poses)
    if known["foreign"] and row["foreign"] > len(poses) / 2:
        return  # A model of the other scene.
    if known["truth"]:
        row["errors"] = camera_poses.pose_errors(
            poses, camera_poses.read_truth(known["truth"]))


def measure(program, name, arguments):
    images, known = make_set(name, arguments)
    folder = Path(arguments.out, "runs", name, program)
    if program == "colmap":
        extra = []
        if arguments.colmap_features:
            extra = ["--SiftExtraction.max_num_features",
                     str(arguments.colmap_features)]
        row = sfm_programs.run_colmap(images, folder, arguments.limit,
                                      arguments.colmap, extra=extra)
    else:
        options = [text for option, value in arguments.option
                   for text in ("--" + option, value)]
        if arguments.colmap != "colmap":
            options += ["--sfm.colmap", arguments.colmap]
        build = md5(arguments.program)
        row = sfm_programs.run_ours(arguments.program, images, folder,
                                    arguments.limit, options)
        row["options"] = options
        row["program_md5"] = build
    add_truth(row, known)
    return row


def md5(path):
    return hashlib.md5(Path(path).read_bytes()).hexdigest()


def untold(row):
    """What a result that claims to be good hides."""
    faults = []
    if row["registered"] < GOOD_SHARE * row["total"]:
        faults.append(f"{row['registered']} of {row['total']} photos")
    misplaced = (row.get("errors") or {}).get("misplaced", [])
    if misplaced:
        faults.append(f"{len(misplaced)} misplaced")
    if row.get("foreign"):
        faults.append(f"{row['foreign']} of another scene")
    return faults


def judge_colmap(row, allowed):
    if row["timed_out"]:
        return f"not done in {row['seconds']:.0f} s"
    if row["code"] != 0:
        return "right" if FAILED in allowed else "wrong: gives up"
    faults = untold(row)
    if allowed == {FAILED}:
        faults.append("there is nothing to be had")
    return "silent failure: " + ", ".join(faults) if faults else "right"


def judge_ours(row, allowed):
    if row["timed_out"]:
        return f"wrong: not done in {row['seconds']:.0f} s"
    verdict = row.get("verdict")
    if verdict is None:
        return f"wrong: exit code {row['code']} without a verdict"
    faults = []
    if row["code"] != EXIT_CODES.get(verdict):
        faults.append(f"exit code {row['code']} for {verdict}")
    if verdict not in allowed:
        faults.append("should be " + " or ".join(sorted(allowed)))
    if verdict != OK and not (row.get("reason") and row.get("advice")):
        faults.append("no reason or advice")
    if len(row.get("unregistered", [])) != row["total"] - row["registered"]:
        faults.append("photos left out are not all named")
    if verdict == OK and (untold(row) or OK not in allowed):
        return "silent failure: " + ", ".join(untold(row) + faults)
    if faults:
        return "wrong: " + ", ".join(faults)
    wrong_poses = [fault for fault in untold(row) if "photos" not in fault]
    return "right" + (", but " + ", ".join(wrong_poses)
                      if verdict == DEGRADED and wrong_poses else "")


def poses_cell(row):
    errors = row.get("errors")
    if not errors:
        return ""
    return (f"{errors['rotation_deg_median']:.2f} deg, "
            f"{100 * errors['position_share_median']:.2f} %"
            + (f", {len(errors['misplaced'])} misplaced"
               if errors["misplaced"] else ""))


def models_cell(row):
    return "+".join(str(size) for size in row["models"]) or "none"


def brief(value):
    """A finding, an attempt or a warning of health.json in a few words."""
    if not isinstance(value, dict):
        return str(value)
    if "message" in value:
        return f"({value.get('severity', 'finding')}) {value['message']}"
    text = str(value.get("name", "?"))
    if "registered" in value:
        text += f" {value['registered']} photos"
    if value.get("kept"):
        text += ", kept"
    return text + (f" ({value['problem']})" if value.get("problem") else "")


def share_verdict(registered, total):
    """The verdict by the share of registered photos alone."""
    if registered < 3 or registered < 0.5 * total:
        return FAILED
    return OK if registered >= GOOD_SHARE * total else DEGRADED


def attempts_table(rows):
    """What each attempt after the plain one did, over all sets, as Markdown.

    An attempt helped when it was kept and made a better verdict, as far as the
    share of registered photos decides.
    """
    tried = {}  # Of each attempt: (set, kept, before, after), photos and verdict.
    for name, row in rows:
        best = 0
        for attempt in row.get("attempts", []):
            after = attempt["registered"] if attempt["kept"] else best
            if attempt["why"] and not attempt["problem"].startswith(
                    "not tried"):
                tried.setdefault(attempt["name"], []).append(
                    (name, attempt["kept"], best, after, row["total"]))
            best = after
    lines = ["| attempt | tried on | kept on | better verdict on |",
             "|---|---|---|---|"]
    for attempt, uses in tried.items():
        better = [f"{name} ({share_verdict(before, total)} to "
                  f"{share_verdict(after, total)})"
                  for name, kept, before, after, total in uses
                  if share_verdict(before, total) != share_verdict(after, total)
                  and after > before]
        kept = [f"{name} ({before} to {after} of {total})"
                for name, kept, before, after, total in uses if kept]
        lines.append(f"| {attempt} | {len(uses)} sets: "
                     + ", ".join(use[0] for use in uses) + " | "
                     + ", ".join(kept) + " | " + ", ".join(better) + " |")
    return lines


def load(arguments, name, program):
    path = Path(arguments.out, "results", f"{name}.{program}.json")
    if not path.is_file():
        return None
    return json.loads(path.read_text(encoding="utf-8"))


def table(arguments):
    """All that was measured, as Markdown."""
    lines = ["| set | photos | COLMAP: exit code, models | poses | s | check "
             "| ours: verdict, exit code, models | poses | s | check |",
             "|" + "---|" * 10]
    said, programs = [], set()
    for name, photo_set in SETS.items():
        colmap = load(arguments, name, "colmap")
        ours = load(arguments, name, "ours")
        if colmap is None and ours is None:
            continue
        cells = [f"{name}: {photo_set.what}", str((colmap or ours)["total"])]
        if colmap:
            cells += [f"{colmap['code']}, {models_cell(colmap)}",
                      poses_cell(colmap), f"{colmap['seconds']:.0f}",
                      judge_colmap(colmap, photo_set.allowed)]
        else:
            cells += [""] * 4
        if ours:
            programs.add(ours["program_md5"])
            cells += [f"{ours.get('verdict', 'none')}, {ours['code']}, "
                      f"{models_cell(ours)}", poses_cell(ours),
                      f"{ours['seconds']:.0f}",
                      judge_ours(ours, photo_set.allowed)]
            said.append((name, ours))
        else:
            cells += [""] * 4
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "Poses: median error of orientation and, in % of the scene's "
              "size, of position.", "", "What ours said:", ""]
    for name, row in said:
        lines.append(f"- {name}: " + (row.get("reason") or row.get("verdict")
                                      or row.get("message", "")))
        for key, title in (("advice", "Advice"), ("findings", "Found"),
                           ("attempts", "Tried"), ("warnings", "Warnings")):
            value = row.get(key)
            if value:
                text = value if isinstance(value, str) else "; ".join(
                    brief(item) for item in value)
                lines.append(f"  - {title}: {text}")
    lines += ["", "Attempts after the plain one:", "", *attempts_table(said)]
    if len(programs) > 1:
        lines += ["", "Ours was measured with more than one build: see "
                  "program_md5 in OUT/results; --again ours."]
    return "\n".join(lines) + "\n"


def main():
    parser = argument_parser(__doc__, "program", "data", "out")
    parser.add_argument("--only", default=",".join(SETS),
                        help="of " + ", ".join(SETS))
    parser.add_argument("--skip-colmap", action="store_true")
    parser.add_argument("--skip-ours", action="store_true")
    parser.add_argument("--again", choices=["ours", "colmap", "both"],
                        help="measure the sets anew")
    parser.add_argument("--limit", type=float, default=1800,
                        help="seconds of a run")
    parser.add_argument("--make-scene",
                        help="default: freegs_make_scene beside PROGRAM")
    parser.add_argument("--colmap", default="colmap")
    parser.add_argument("--colmap-features", type=int, default=0,
                        help="SiftExtraction.max_num_features of COLMAP "
                        "alone; 0 leaves its default")
    parser.add_argument("--option", nargs=2, action="append", default=[],
                        metavar=("NAME", "VALUE"),
                        help="of ours, such as sfm.matcher retrieval")
    parser.add_argument("--list", action="store_true",
                        help="says what sets there are, and stops")
    arguments = parser.parse_args()
    if arguments.list:
        for name, photo_set in SETS.items():
            print(f"{name}: {photo_set.what}; allowed: "
                  + ", ".join(sorted(photo_set.allowed)))
        return
    names = [name for name in arguments.only.split(",") if name]
    unknown = [name for name in names if name not in SETS]
    if unknown:
        parser.error("unknown sets: " + ", ".join(unknown))
    results = Path(arguments.out, "results")
    results.mkdir(parents=True, exist_ok=True)
    for name in names:
        for program, skip in (("ours", arguments.skip_ours),
                              ("colmap", arguments.skip_colmap)):
            path = results / f"{name}.{program}.json"
            again = arguments.again in (program, "both")
            if skip or (path.is_file() and not again):
                continue
            row = measure(program, name, arguments)
            path.write_text(json.dumps(row, indent=1), encoding="utf-8")
            judge = judge_ours if program == "ours" else judge_colmap
            print(f"{name}, {program}: exit code {row['code']}, "
                  f"{row['registered']} of {row['total']} photos, "
                  f"{row['seconds']:.0f} s: "
                  + judge(row, SETS[name].allowed),
                  file=sys.stderr, flush=True)
    text = table(arguments)
    Path(arguments.out, "table.md").write_text(text, encoding="utf-8")
    print(text, end="")


if __name__ == "__main__":
    main()
