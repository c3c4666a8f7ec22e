# SPDX-License-Identifier: BSD-3-Clause
"""What the scripts share that compare with other programs: their arguments, the
time of a program, figures of several rounds and their medians. Charts of what
they write are drawn by web/plot.mjs (docs/bench.md).
"""
import argparse
import os
import statistics
import subprocess
import time


def argument_parser(doc, *names):
    """A parser whose help is the script's text, with positional arguments."""
    parser = argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in names:
        parser.add_argument(name)
    return parser


def add_rounds(parser, default):
    parser.add_argument("--rounds", type=int, default=default,
                        help="how often everything runs, in turn")


def timed(command, **kwargs):
    """Wall and CPU seconds of a command with its children, and what it printed."""
    before = os.times()
    begin = time.monotonic()
    done = subprocess.run(command, check=True, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          **kwargs)
    wall = time.monotonic() - begin
    after = os.times()
    cpu = (after.children_user - before.children_user +
           after.children_system - before.children_system)
    return wall, cpu, done.stdout


class Figures:
    """Figures of several rounds, printed as they come."""

    def __init__(self, prefix=""):
        self.prefix = prefix
        self.values = {}

    def note(self, name, value):
        self.values.setdefault(name, []).append(value)
        print(f"{self.prefix}{name}: {value:.4g}", flush=True)

    def print_medians(self, title):
        print(f"\n{title}")
        for name, values in self.values.items():
            print(f"{name}: {statistics.median(values):.4g} "
                  f"({min(values):.4g} to {max(values):.4g})")
        print(flush=True)
