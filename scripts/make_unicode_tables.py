#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes semantics/clip/unicode_tables.h: the character classes of CLIP's
tokeniser as CPython and the regex module, which the reference uses, see them.

  scripts/make_unicode_tables.py > semantics/clip/unicode_tables.h

Needs Debian's python3-regex.
"""
import sys
import unicodedata

import regex

CODE_POINTS = [c for c in range(0x110000) if not 0xD800 <= c < 0xE000]


def ranges(members):
    """Sorted code points as inclusive [first, last] ranges."""
    result = []
    for c in members:
        if result and result[-1][1] == c - 1:
            result[-1][1] = c
        else:
            result.append([c, c])
    return result


def matching(pattern):
    match = regex.compile(pattern).fullmatch
    return [c for c in CODE_POINTS if match(chr(c))]


def has_final_sigma(text):
    return text.lower().endswith("ς")


def case_properties():
    """What the rule for the final sigma skips, and what it looks for."""
    ignorable = [c for c in CODE_POINTS
                 if has_final_sigma("A" + chr(c) + "Σ")
                 and not has_final_sigma("." + chr(c) + "Σ")]
    cased = [c for c in CODE_POINTS if has_final_sigma("." + chr(c) + "Σ")]
    return cased, ignorable


def lower_mappings():
    """[first, last, step, delta]: every step-th code point from first to last
    becomes itself plus delta. Leaves out U+0130, which becomes two."""
    result = []
    for c in CODE_POINTS:
        lower = chr(c).lower()
        if len(lower) != 1 or ord(lower) == c:
            continue
        delta = ord(lower) - c
        if result and result[-1][3] == delta:
            last = result[-1]
            step = c - last[1]
            if step <= 2 and (last[0] == last[1] or last[2] == step):
                last[1], last[2] = c, step
                continue
        result.append([c, c, 1, delta])
    return result


def print_rows(kind, name, rows, numbers_per_line):
    print(f"\ninline constexpr {kind} {name}[] = {{")
    per_line = max(1, numbers_per_line // len(rows[0]))
    for i in range(0, len(rows), per_line):
        line = ", ".join(
            "{" + ", ".join(hex(n) if n >= 0 else str(n) for n in row) + "}"
            for row in rows[i:i + per_line])
        print(f"    {line},")
    print("};")


def main():
    cased, ignorable = case_properties()
    print(f"""\
// SPDX-License-Identifier: BSD-3-Clause
// Character classes of Unicode {unicodedata.unidata_version} or later. Written by
// scripts/make_unicode_tables.py; do not edit.

#ifndef FREEGS_SEMANTICS_CLIP_UNICODE_TABLES_H_
#define FREEGS_SEMANTICS_CLIP_UNICODE_TABLES_H_

#include <cstdint>

namespace freegs::semantics::unicode_tables {{

// first .. last, both included.
struct Range {{
  uint32_t first;
  uint32_t last;
}};

// Every step-th code point of first .. last becomes itself plus delta.
struct LowerMapping {{
  uint32_t first;
  uint32_t last;
  uint32_t step;
  int32_t delta;
}};

// clang-format off""")
    print_rows("Range", "kLetters", ranges(matching(r"\p{L}")), 6)
    print_rows("Range", "kNumbers", ranges(matching(r"\p{N}")), 6)
    print_rows("Range", "kCased", ranges(cased), 6)
    print_rows("Range", "kCaseIgnorable", ranges(ignorable), 6)
    print_rows("LowerMapping", "kLower", lower_mappings(), 8)
    print("""// clang-format on

}  // namespace freegs::semantics::unicode_tables

#endif  // FREEGS_SEMANTICS_CLIP_UNICODE_TABLES_H_""")


if __name__ == "__main__":
    sys.exit(main())
