#!/usr/bin/env python3
"""The house rules that a compiler does not see.

Every folder of src/ includes only those below it (docs/design.md), only src/app prints or exits, and CUDA stays in
src/backend. Usage: check_layers.py [SRC]; exits with 1 and one line a finding if something is out of place.
"""

import pathlib
import re
import sys

# What each folder may include beside itself and include/plumbline.
LIBRARY = {
    "core": set(),
    "kernels": {"core"},
    "io": {"core"},
    "eval": {"core"},
    "sensor": {"core"},
    "sim": {"core", "sensor"},
    "capture": {"core", "io"},
    "backend": {"core", "kernels"},
    "map": {"core", "kernels", "backend"},
    "tracking": {"core", "kernels", "backend"},
    "pipeline": {"core", "kernels", "sensor", "backend", "map", "tracking"},
    "calibration": {"core", "kernels", "io", "sensor", "backend", "tracking", "pipeline"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"/]+)/')
PRINTS = re.compile(r"std::(cout|cerr|clog)|\b(printf|puts|exit|abort|_exit)\s*\(|fmt::print|\bstderr\b|\bstdout\b")
CUDA = re.compile(r"__global__|cudaMalloc|<<<")
COMMENT = re.compile(r"//.*$")
STRING = re.compile(r'"(\\.|[^"\\])*"')


def findings(source: pathlib.Path, folder: str):
    for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
        include = INCLUDE.match(line)
        if include and include[1] != folder and include[1] not in ALLOWED[folder]:
            yield number, f"{folder} must not include {include[1]}"
        code = COMMENT.sub("", STRING.sub('""', line))
        if folder != "app" and PRINTS.search(code):
            yield number, "only src/app prints or exits"
        if folder != "backend" and CUDA.search(code):
            yield number, "CUDA belongs in src/backend"


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent / "src")
    sources = [p for p in sorted(root.glob("*/**/*")) if p.suffix in {".h", ".cpp", ".cu", ".cuh"}]
    bad = 0
    for source in sources:
        folder = source.relative_to(root).parts[0]
        if folder not in ALLOWED:
            print(f"{source}: the folder '{folder}' has no place in ALLOWED of {__file__}")
            bad += 1
            continue
        for number, message in findings(source, folder):
            print(f"{source}:{number}: {message}")
            bad += 1
    print(f"{len(sources)} files, {bad} findings")
    return 1 if bad or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
