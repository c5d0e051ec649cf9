#!/usr/bin/env python3
"""Only src/kernels/brick_map.h knows how a voxel is found.

Nobody else does arithmetic with bricks: the map's memory could be a cube, a table of pages or a hash of bricks.
Usage: check_voxel_layout.py [SRC]; exits with 1 and one line a finding if something is out of place.
"""

import pathlib
import re
import sys

FOLDERS = ["kernels", "map", "backend", "tracking", "fusion", "pipeline"]
OWNER = pathlib.PurePath("kernels/brick_map.h")
# Eight voxels a side are three bits of a position, and 512 a brick nine.
ARITHMETIC = re.compile(
    r"<<\s*9\b|>>\s*3\b|&\s*(?:Int<F>\()?7\b|(?<![\w:])(?:kernels::)?shift_(?:left|right)<[39]>|\bterm_[xyz]\b|"
    r"\bbrick_(?:stride|index)_?\b|\bbricks_?\s*\*\s*\w*\.?bricks|(?:[*/%]\s*)(?:kernels::)?kBrickSide\b"
)
COMMENT = re.compile(r"//.*$")


def findings(source: pathlib.Path):
    for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
        found = ARITHMETIC.search(COMMENT.sub("", line))
        if found:
            yield number, f"'{found[0]}' is about where voxels lie; ask src/{OWNER}"


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent / "src")
    sources = [p for folder in FOLDERS for p in sorted((root / folder).glob("**/*"))
               if p.suffix in {".h", ".cpp", ".cu", ".cuh"} and p.relative_to(root) != OWNER]
    bad = 0
    for source in sources:
        for number, message in findings(source):
            print(f"{source}:{number}: {message}")
            bad += 1
    print(f"{len(sources)} files, {bad} findings")
    return 1 if bad or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
