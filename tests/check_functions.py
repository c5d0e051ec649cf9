#!/usr/bin/env python3
"""Functions fit on a screen and folders stay small: 90 % of the functions have at most 18 lines, none more than 60, and no
folder more than 5000.

A function is what stands between a line that opens a brace and the line that closes it, at the same indentation, and is no
namespace, type, enumeration, initialiser or statement; clang-format makes that regular. A length counts the lines of the
body and its head, as an editor shows them. Usage: check_functions.py [ROOT]; exits with 1 and one line a finding.
"""

import collections
import pathlib
import re
import sys

P90, LONGEST, FOLDER = 18, 60, 5000
NOT_A_FUNCTION = re.compile(r"^\s*(namespace|class|struct|union|enum|extern|if|else|for|while|do|switch|case|default|try|catch|return|\})\b|^\s*\}")
ONE_LINE = re.compile(r"^ {0,4}[\w~].*\)( const)?( noexcept)?( override)?( ->.*)?( : .*)? \{.*\}$")  # on one line


def head_of(lines: list[str], at: int) -> int:
    """The first line of the statement whose brace opens in line `at`."""
    first = at
    while first > 0:
        before = lines[first - 1].rstrip()
        if not before or re.search(r"[;{}]$|:$|^\s*(//|#|\*)|^template\b.*>$", before):
            break
        first -= 1
    return first


def functions(lines: list[str]):
    """(line, name, length) of every function that takes more than one line or stands on one."""
    for at, line in enumerate(lines):
        text = line.rstrip()
        if ONE_LINE.match(text) and not NOT_A_FUNCTION.match(text):
            yield at + 1, text.split("(")[0].split()[-1], 1
            continue
        if not text.endswith("{") or text.lstrip().startswith(("//", "#")):
            continue
        first = head_of(lines, at)
        head = " ".join(part.strip() for part in lines[first:at + 1])
        indent = re.match(r" *", lines[first])[0]
        # A body stands at the indentation of a namespace or of a class: a lambda or a block is part of its function.
        if len(indent) > 4 or "(" not in head or NOT_A_FUNCTION.match(head) or re.search(r"=\s*\{$|\[[^\]]*\]\s*(\([^)]*\))?\s*(mutable|->.*)?\{$", head):
            continue
        for last in range(at + 1, len(lines)):
            if lines[last].startswith(indent + "}"):
                yield first + 1, head.split("(")[0].split()[-1], last - first + 1
                break
            if lines[last].strip() and not lines[last].startswith((indent + " ", "#", indent + "public", indent + "private")):
                break  # not a body of this indentation


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    lengths, folders, bad = [], collections.Counter(), []
    for top in ("include", "src", "apps", "lab"):
        for source in sorted((root / top).rglob("*")):
            if source.suffix not in {".h", ".cpp", ".cu", ".cuh"}:
                continue
            relative = source.relative_to(root)
            lines = source.read_text(encoding="utf-8").splitlines()
            folders[str(relative.parent)] += len(lines)
            seen = 0  # a block within a function is no function
            for line, name, length in functions(lines):
                if line <= seen:
                    continue
                seen = line + length - 1
                lengths.append(length)
                if length > LONGEST:
                    bad.append(f"{relative}:{line}: {name} has {length} lines, more than {LONGEST}")
    bad += [f"{folder}: {lines} lines, more than {FOLDER}" for folder, lines in folders.items() if lines > FOLDER]
    lengths.sort()
    p90 = lengths[9 * len(lengths) // 10] if lengths else 0
    if p90 > P90:
        bad.append(f"90 % of the functions have at most {p90} lines, more than {P90}")
    print("\n".join(bad + [f"{len(lengths)} functions: median {lengths[len(lengths) // 2] if lengths else 0} lines, "
                           f"90 % at most {p90}, longest {lengths[-1] if lengths else 0}; {len(bad)} findings"]))
    return 1 if bad or not lengths else 0


if __name__ == "__main__":
    sys.exit(main())
