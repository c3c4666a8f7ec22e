#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Asks a scene for things that are there and for things that are not.

  bench/query_words.py PROGRAM WORKSPACE --there "red apple,blue mug,..."
      --not-there "elephant,pink lamp,..."

PROGRAM is freegs_pipeline; WORKSPACE is bootstrapped. Prints the best relevancy
of each, and how many pass the threshold. Whether the instance found is the
right one is for eval --gt to say.
"""
import argparse
import json
import subprocess


def best_score(program, workspace, words):
    """(the best relevancy as text, whether anything was found)"""
    done = subprocess.run([program, "query", workspace, "--text", words,
                           "--json"], text=True, capture_output=True,
                          check=True)
    answer = json.loads(done.stdout)
    score = answer["best_score"]  # None where no instance can answer.
    return "none" if score is None else f"{score:.2f}", answer["found"]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("workspace")
    parser.add_argument("--there", default="")
    parser.add_argument("--not-there", default="")
    arguments = parser.parse_args()
    for title, texts in (("there", arguments.there),
                         ("not there", arguments.not_there)):
        scores = {words: best_score(arguments.program, arguments.workspace,
                                    words)
                  for words in filter(None, texts.split(","))}
        passed = sum(found for _, found in scores.values())
        print(f"{title}: {passed} of {len(scores)} found; " + ", ".join(
            f"{words} {score}" for words, (score, _) in scores.items()))


if __name__ == "__main__":
    main()
