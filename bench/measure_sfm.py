#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Camera poses in several ways, COLMAP's defaults among them: how long, how
right.

  bench/measure_sfm.py PROGRAM PHOTOS --csv OUT.csv
      [--truth cameras.json | --reference MODEL]
      [--settings colmap,auto,...] [--setting NAME "--sfm.neighbours 5"]
      [--rounds 3] [--work FOLDER]

PROGRAM is freegs_pipeline, PHOTOS a folder. Errors are those of
bench/camera_poses.py against gt/cameras.json, a transforms.json, or another
COLMAP model; with neither, against the model that "colmap" makes here.
"colmap" runs feature_extractor (images of at most 1600 pixels, on the
processor), exhaustive_matcher and mapper with nothing else set, "colmap one
camera" the same with ImageReader.single_camera. Ours is stage sfm, without
ingest. Nothing else should run on the machine.

CSV columns: setting; seconds, and of them features, matching, mapping, other
(as the log tells them apart); cpu_seconds; registered, total, models, points;
rotation_deg_median, rotation_deg_max; position_percent_median,
position_percent_max (of the scene's size); misplaced (photos more than 5
degrees or 5 % off); reprojection_px (mean over observations); verdict, code;
error, which is position_percent_median, or empty with fewer than half of the
photos. With several rounds, which take turns, a row is the round with the
median seconds; seconds_min and seconds_max say how they differ. A chart:

  node BUILD/web/plot.mjs NAME=OUT.csv --label setting --x seconds --y error
      --y-name "camera position, % of the scene's size" --log-x --log-y
      --title TITLE --out OUT.svg
"""
import csv
import shlex
import sys
import tempfile
from pathlib import Path

import camera_poses
import sfm_programs
from peer_figures import add_rounds, argument_parser

# Options of ours; None is a way of COLMAP alone.
SETTINGS = {
    "colmap": None,
    "auto": [],
    "fast": ["--preset", "fast"],
    "quality": ["--preset", "quality"],
    "exhaustive": ["--sfm.matcher", "exhaustive"],
    "sequential": ["--sfm.matcher", "sequential"],
    "retrieval": ["--sfm.matcher", "retrieval"],
    "500 features": ["--sfm.max_features", "500"],
    "1000 features": ["--sfm.max_features", "1000"],
    "8192 features": ["--sfm.max_features", "8192"],
    "800 pixels": ["--sfm.max_image_size", "800"],
    "400 pixels": ["--sfm.max_image_size", "400"],
    "simple camera": ["--sfm.camera_model", "SIMPLE_RADIAL"],
    "opencv camera": ["--sfm.camera_model", "OPENCV"],
    "camera per photo": ["--sfm.camera", "per_image"],
    "colmap one camera": None,
}
DEFAULT_SETTINGS = ("colmap,auto,fast,quality,exhaustive,sequential,retrieval,"
                    "1000 features,800 pixels,simple camera")
COLUMNS = ["setting", "seconds", *sfm_programs.PARTS, "cpu_seconds",
           "seconds_min", "seconds_max", "registered", "total", "models",
           "points", "rotation_deg_median", "rotation_deg_max",
           "position_percent_median", "position_percent_max", "misplaced",
           "reprojection_px", "verdict", "code", "error"]
PHOTO_SUFFIXES = (".jpg", ".jpeg", ".png", ".tif", ".tiff")


def measure(setting, options, arguments, folder):
    if options is None:
        extra = (["--ImageReader.single_camera", "1"]
                 if setting == "colmap one camera" else [])
        row = sfm_programs.run_colmap(arguments.photos, folder,
                                      arguments.limit, arguments.colmap,
                                      extra=extra)
    else:
        if arguments.colmap != "colmap":
            options = options + ["--sfm.colmap", arguments.colmap]
        row = sfm_programs.run_ours(arguments.program, arguments.photos,
                                    folder, arguments.limit, options)
    row["setting"] = setting
    if row["timed_out"]:
        row["verdict"] = "not done in time"
    elif row["code"] == 2:
        row["verdict"] = "not offered"
    return row


def add_errors(row, truth):
    """Fills in what the truth tells of the row's model."""
    errors = None
    if truth and "model" in row:
        errors = camera_poses.pose_errors(
            camera_poses.read_model(row["model"]), truth)
    if errors is None:
        return
    for key in ("median", "max"):
        row["rotation_deg_" + key] = errors["rotation_deg_" + key]
        row["position_percent_" + key] = 100 * errors["position_share_" + key]
    row["misplaced"] = len(errors["misplaced"])
    if 2 * row["registered"] >= row["total"]:
        row["error"] = row["position_percent_median"]


def text(value):
    if isinstance(value, float):
        return f"{value:.4g}" if value < 1000 else f"{value:.0f}"
    if isinstance(value, list):
        return "+".join(str(item) for item in value)
    return "" if value is None else str(value)


def middle_rounds(rounds):
    """One row of each setting: the round with the median seconds."""
    rows = []
    for same in zip(*rounds):
        order = sorted(same, key=lambda row: row["seconds"])
        rows.append(order[(len(order) - 1) // 2] |
                    {"seconds_min": order[0]["seconds"],
                     "seconds_max": order[-1]["seconds"]})
    return rows


def write_csv(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows([[text(row.get(name)) for name in COLUMNS]
                          for row in rows])


def main():
    parser = argument_parser(__doc__, "program", "photos")
    parser.add_argument("--csv", required=True)
    parser.add_argument("--truth", help="cameras.json or transforms.json")
    parser.add_argument("--reference", help="folder of a COLMAP model")
    parser.add_argument("--settings", default=DEFAULT_SETTINGS,
                        help="of " + ", ".join(SETTINGS))
    parser.add_argument("--setting", nargs=2, action="append", default=[],
                        metavar=("NAME", "OPTIONS"), help="one more")
    add_rounds(parser, 1)
    parser.add_argument("--limit", type=float, default=3600,
                        help="seconds of a run")
    parser.add_argument("--work", help="keeps databases, models, logs here")
    parser.add_argument("--colmap", default="colmap")
    arguments = parser.parse_args()
    settings = [(name, SETTINGS.get(name, 0))
                for name in arguments.settings.split(",") if name]
    settings += [(name, shlex.split(options))
                 for name, options in arguments.setting]
    unknown = [name for name, options in settings if options == 0]
    if unknown:
        parser.error("unknown settings: " + ", ".join(unknown))
    photos = [path for path in Path(arguments.photos).rglob("*")
              if path.suffix.lower() in PHOTO_SUFFIXES]
    if not photos:
        parser.error(f"no photos in {arguments.photos}")
    path = arguments.truth or arguments.reference
    truth = camera_poses.read_truth(path) if path else None

    with tempfile.TemporaryDirectory() as scratch:
        work = Path(arguments.work or scratch)
        rounds = []
        for index in range(arguments.rounds):
            rows = []
            for name, options in settings:
                row = measure(name, options, arguments,
                              work / f"{name.replace(' ', '_')}_{index}")
                row["total"] = len(photos)
                add_errors(row, truth)
                if truth is None and name == "colmap" and "model" in row:
                    truth = camera_poses.read_model(row["model"])
                rows.append(row)
                print(", ".join(f"{key} {text(row[key])}" for key in COLUMNS
                                if text(row.get(key))), flush=True)
                if row.get("message") and row["code"] != 0:
                    print("  " + row["message"], file=sys.stderr, flush=True)
                if index == 0:  # What there is, should it be stopped.
                    write_csv(arguments.csv, middle_rounds([rows]))
            rounds.append(rows)
        write_csv(arguments.csv, middle_rounds(rounds))


if __name__ == "__main__":
    main()
