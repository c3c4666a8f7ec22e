# SPDX-License-Identifier: BSD-3-Clause
"""Runs COLMAP alone and our stage sfm, for measure_sfm and sfm_stability.

Both give the same keys: code, timed_out, seconds, cpu_seconds, features,
matching, mapping, other (seconds of each part), registered, models, and, where
there is a model, model (its folder), points, reprojection_px.
"""
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

import camera_poses

PARTS = ("features", "matching", "mapping", "other")

# What stage sfm says that it does, and which part that is.
PART_OF_WORD = (("feature", "features"), ("reading photos", "features"),
                ("match", "matching"), ("retriev", "matching"),
                ("pairs", "matching"), ("mapping", "mapping"),
                ("mapper", "mapping"), ("regist", "mapping"))
PROGRESS = re.compile(r"sfm: (.+?) \d+/\d+ \d+%")


def run(command, log, limit, on_line=None):
    """(exit code, timed out, wall seconds, CPU seconds) of a command.

    What it prints is added to the file `log`; on_line(seconds, line) gets it
    too. After `limit` seconds the command and its children are killed.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    timed_out = threading.Event()
    environment = dict(os.environ, QT_QPA_PLATFORM="offscreen")
    with open(log, "a", encoding="utf-8") as file:
        file.write("$ " + " ".join(command) + "\n")
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, errors="replace",
            start_new_session=True, env=environment)

        def kill():
            if process.poll() is None:
                timed_out.set()
                os.killpg(process.pid, signal.SIGKILL)

        timer = threading.Timer(limit, kill)
        timer.start()
        try:
            for line in process.stdout:
                file.write(line)
                if on_line:
                    on_line(time.monotonic() - begin, line)
            code = process.wait()
        except BaseException:
            kill()
            process.wait()
            raise
        finally:
            timer.cancel()
        seconds = time.monotonic() - begin
        file.write(f"exit code {code} after {seconds:.1f} s\n")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = (after.ru_utime - before.ru_utime +
           after.ru_stime - before.ru_stime)
    return code, timed_out.is_set(), seconds, cpu


def fresh(folder):
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    return Path(folder)


def add_model(row, folder):
    """The figures of a model."""
    row["model"] = str(folder)
    row["registered"] = len(camera_poses.read_model(folder))
    if Path(folder, "points3D.bin").is_file():
        row["points"], row["reprojection_px"] = camera_poses.read_points(folder)


def model_sizes(sparse):
    """[(registered, folder)] of the models in a folder, largest first."""
    sizes = [(len(camera_poses.read_model(folder)), folder)
             for folder in sorted(Path(sparse).glob("[0-9]*"))
             if folder.joinpath("images.bin").is_file()]
    return sorted(sizes, key=lambda size: -size[0])


def colmap_option(colmap, command, name):
    """--Group.name, as this release of COLMAP calls the group."""
    text = subprocess.run([colmap, command, "--help"], text=True, check=False,
                          stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT).stdout
    found = re.search(r"--(\w+\." + name + r")\b", text)
    return "--" + found.group(1) if found else None


def run_colmap(photos, folder, limit, colmap="colmap", max_image_size=1600,
               extra=()):
    """COLMAP's defaults: three commands, on the processor, all its threads.

    extra: further options of feature_extractor. Its model is the largest one.
    """
    folder = fresh(folder)
    database, sparse = folder / "database.db", folder / "sparse"
    sparse.mkdir()
    log = folder / "colmap.log"
    both = ["--database_path", str(database)]
    images = ["--image_path", str(photos)]
    steps = {"features": [colmap, "feature_extractor", *both, *images, *extra],
             "matching": [colmap, "exhaustive_matcher", *both],
             "mapping": [colmap, "mapper", *both, *images,
                         "--output_path", str(sparse)]}
    for part, name, value in (("features", "use_gpu", 0),
                              ("features", "max_image_size", max_image_size),
                              ("matching", "use_gpu", 0)):
        option = colmap_option(colmap, steps[part][1], name)
        if option:
            steps[part] += [option, str(value)]
    row = {"code": 0, "timed_out": False, "seconds": 0.0, "cpu_seconds": 0.0,
           "registered": 0, "models": []}
    for part, command in steps.items():
        code, timed_out, seconds, cpu = run(command, log,
                                            limit - row["seconds"])
        row[part] = seconds
        row["seconds"] += seconds
        row["cpu_seconds"] += cpu
        row["code"], row["timed_out"] = code, timed_out
        if code != 0:
            row["stopped_at"] = part
            break
    sizes = model_sizes(sparse)
    row["models"] = [size for size, _ in sizes]
    if sizes:
        add_model(row, sizes[0][1])
    return row


def run_ours(program, photos, folder, limit, options=()):
    """Stage sfm in a new workspace; ingest is not in the times.

    Adds verdict, reason, advice, message (the last line said), warnings,
    unregistered, attempts, findings as far as they are there.
    """
    folder = fresh(folder)
    workspace = folder / "workspace"
    log = folder / "ours.log"
    row = {"timed_out": False, "seconds": 0.0, "cpu_seconds": 0.0,
           "registered": 0, "models": []}
    lines = []
    code, row["timed_out"], _, _ = run(
        [program, "run", str(photos), str(workspace), "--to", "ingest",
         *options], log, limit, lambda _, line: lines.append(line))
    if code == 0:
        changes = []  # When which part began.

        def note(seconds, line):
            lines.append(line)
            found = PROGRESS.search(line)
            if found:
                part = next((part for word, part in PART_OF_WORD
                             if word in found.group(1)), "other")
                if not changes or changes[-1][1] != part:
                    changes.append((seconds, part))

        code, row["timed_out"], row["seconds"], row["cpu_seconds"] = run(
            [program, "stage", "sfm", str(workspace), *options], log, limit,
            note)
        if changes:
            changes[0] = (0.0, changes[0][1])
        ends = [begin for begin, _ in changes[1:]] + [row["seconds"]]
        for (begin, part), end in zip(changes, ends):
            row[part] = row.get(part, 0.0) + end - begin
    row["code"] = code
    row["message"] = lines[-1].strip() if lines else ""
    for stage in ("sfm", "sfm.partial"):
        health = workspace / stage / "health.json"
        if not health.is_file():
            continue
        value = json.loads(health.read_text(encoding="utf-8"))
        for key in ("verdict", "reason", "advice", "warnings", "registered",
                    "unregistered", "attempts", "findings"):
            if key in value:
                row[key] = value[key]
        row["models"] = value.get("model_sizes", [])
        model = workspace / stage / "sparse" / "0"
        if model.is_dir():
            add_model(row, model)
        break
    return row
