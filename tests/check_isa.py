#!/usr/bin/env python3
"""Fails if an object compiled for one instruction set defines a weak symbol that another object could define too.

The linker keeps one copy of a weak symbol. If it kept that of the AVX2 object for a function that everybody calls, the
program would crash on a processor without AVX2. So each weak symbol must name its lane type.

usage: check_isa.py NM OBJECT...
"""
import subprocess
import sys


def main() -> int:
    nm, objects = sys.argv[1], sys.argv[2:]
    bad = checked = 0
    for path in objects:
        listing = subprocess.run([nm, "-C", "--defined-only", path], check=True, capture_output=True, text=True).stdout
        for line in listing.splitlines():
            kind, _, name = line[17:].partition(" ")
            if kind not in "WVu" or name.startswith("DW.ref."):
                continue
            checked += 1
            if "xsimd::" not in name:
                bad += 1
                print(f"{path}: weak symbol without a lane type: {name}")
    print(f"{checked} weak symbols in {len(objects)} objects checked, {bad} bad")
    return 1 if bad or not checked else 0


if __name__ == "__main__":
    sys.exit(main())
