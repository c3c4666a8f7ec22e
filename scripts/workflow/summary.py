#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes one page of many scenes: what became of each, with links to their reports.

    summary.py WORKSPACES [PAGE]

WORKSPACES is a folder of workspaces, PAGE the file to write (default:
WORKSPACES/index.html). All that it shows is read from the workspaces, so it can be
written at any time, also while the workflow runs.
"""
import json
import os
import sys
from html import escape
from pathlib import Path
from urllib.parse import quote

STAGES = ["ingest", "sfm", "undistort", "reconstruct", "bootstrap", "export"]

# The colours and the type of the reports (stages/export/report_style.h).
STYLE = """
:root { color-scheme: light dark; --page: #fbfaf8; --line: #e4e1db; --text: #23211e;
  --quiet: #6d6961; --accent: #1f6f8b; --warn: #9a5b00; }
@media (prefers-color-scheme: dark) { :root { --page: #17181a; --line: #34373a;
  --text: #e8e6e2; --quiet: #9d9a94; --accent: #6fc0dc; --warn: #e0a85a; } }
body { margin: 0; background: var(--page); color: var(--text);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
main { max-width: 82rem; margin: 0 auto; padding: 2rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0; }
a { color: var(--accent); }
.scroll { overflow-x: auto; margin-top: 1.6rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem 1.2rem .35rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
th { font-weight: 400; font-size: .85rem; }
th, .quiet { color: var(--quiet); }
.number { text-align: right; white-space: nowrap; }
th.number { white-space: normal; }
.failed { color: var(--warn); }
.words { max-width: 36rem; font-size: .85rem; overflow-wrap: anywhere; }
img { display: block; width: 8rem; border-radius: .25rem; background: var(--line); }
"""


def read_json(path):
    """What a JSON file holds; {} where it is missing or damaged."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def number(value, digits=0):
    return "" if value is None else f"{value:.{digits}f}"


def duration(seconds):
    if seconds < 60:
        return f"{seconds:.0f} s"
    if seconds < 3600:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def read_failure(workspace, stage):
    """The exit code and the words of a job that failed; None if it did not."""
    try:
        path = workspace / ".workflow" / f"{stage}.failed"
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return None
    return lines[0] if lines else "?", "\n".join(lines[2:])


def read_scene(workspace):
    """What a row of the table shows."""
    records = {stage: read_json(workspace / stage / "stage.json") for stage in STAGES}
    done = [stage for stage in STAGES if records[stage].get("status") == "done"]
    failures = {stage: read_failure(workspace, stage) for stage in STAGES}
    scene = {"state": "complete", "class": "done", "words": ""}
    failed = next((stage for stage in STAGES if failures[stage]), None)
    unfinished = next((stage for stage in STAGES if stage not in done), None)
    if failed:
        code, words = failures[failed]
        scene["class"] = "failed"
        scene["state"] = f"failed in {failed} (exit code {code})"
        scene["words"] = words or "ended without a word; see log.txt of the workspace"
    elif unfinished:
        begun = (workspace / f"{unfinished}.partial").exists()
        scene["class"] = "quiet"
        scene["state"] = f"{unfinished} {'unfinished' if begun else 'not begun'}"
    # What did not end well keeps its figures where it was made.
    for stage in set(STAGES) - set(done):
        records[stage] = read_json(workspace / f"{stage}.partial" / "stage.json")
    sfm = records["sfm"].get("summary", {})
    if sfm.get("images"):
        scene["photos"] = f"{sfm.get('registered', 0)} of {sfm['images']}"
    elif records["ingest"].get("summary"):
        scene["photos"] = records["ingest"]["summary"].get("photos", "")
    if sfm.get("verdict") == "degraded" and not failed:
        scene["words"] = read_json(workspace / "sfm" / "health.json").get("reason", "")
    trained = records["reconstruct"].get("summary", {})
    truth = read_json(workspace / ".workflow" / "eval.json")
    scene["psnr"] = number(trained.get("holdout_psnr"), 2)
    scene["gaussians"] = number(trained.get("num_gaussians"))
    scene["instances"] = number(records["bootstrap"].get("summary", {}).get("num_instances"))
    scene["miou"] = number(truth.get("instance_miou"), 3)
    times = [record.get("wall_seconds", 0) for record in records.values()]
    peaks = [record.get("peak_memory_bytes", 0) for record in records.values()]
    scene["time"] = duration(sum(times)) if done else ""
    scene["memory"] = f"{max(peaks) / 1e6:.0f}" if done else ""
    return scene


COLUMNS = [
    ("photos", "photos with a pose"),
    ("psnr", "holdout PSNR, dB"),
    ("gaussians", "Gaussians"),
    ("instances", "objects"),
    ("miou", "mIoU"),
    ("time", "time"),
    ("memory", "memory, MB"),
]


def row(workspace, name, place):
    """One scene; `place` is the folder from which the page links."""
    scene = read_scene(workspace)

    def link(path):
        return quote(os.path.relpath(path, place))

    picture = workspace / "export" / "report" / "views" / "1_render.jpg"
    report = workspace / "export" / "report" / "index.html"
    image = f'<img loading="lazy" alt="" src="{link(picture)}">' if picture.exists() else ""
    title = f'<a href="{link(report)}">{escape(name)}</a>' if report.exists() else escape(name)
    cells = "".join(
        f'<td class="number">{escape(str(scene.get(key, "")))}</td>' for key, _ in COLUMNS
    )
    return scene["class"], (
        f"<tr><td>{image}</td><td>{title}</td>"
        f'<td class="{scene["class"]}">{escape(scene["state"])}</td>{cells}'
        f'<td class="words">{escape(scene["words"])}</td></tr>\n'
    )


def write_page(workspaces, names, page):
    """Writes the page of workspaces / NAME for each name, failed scenes first."""
    rows = [row(workspaces / name, name, page.parent) for name in names]
    count = {kind: sum(found == kind for found, _ in rows) for kind in ("failed", "quiet", "done")}
    rows.sort(key=lambda found: ["failed", "quiet", "done"].index(found[0]))
    heads = "".join(f'<th class="number">{title}</th>' for _, title in COLUMNS)
    page.parent.mkdir(parents=True, exist_ok=True)
    part = page.with_name(page.name + ".part")
    part.write_text(
        '<!doctype html>\n<html lang="en"><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{len(rows)} scenes</title>\n<style>{STYLE}</style>\n<main>\n"
        f"<h1>{len(rows)} scenes</h1>\n<p>{count['done']} complete, "
        f"{count['failed']} failed, {count['quiet']} unfinished</p>\n"
        '<div class="scroll"><table>\n'
        f"<tr><th></th><th>scene</th><th>state</th>{heads}<th>remarks</th></tr>\n"
        + "".join(text for _, text in rows)
        + "</table></div>\n</main></html>\n",
        encoding="utf-8",
    )
    part.replace(page)


def main(arguments):
    if len(arguments) not in (1, 2) or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    workspaces = Path(arguments[0])
    if not workspaces.is_dir():
        print(f"summary.py: {workspaces}: no such folder", file=sys.stderr)
        return 3
    names = sorted(p.name for p in workspaces.iterdir() if (p / ".workflow").is_dir())
    write_page(workspaces, names, Path(arguments[-1]) if arguments[1:] else workspaces / "index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
