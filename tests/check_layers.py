#!/usr/bin/env python3
"""The house rules that a compiler does not see (docs/architecture.md).

Every folder includes only those below it, none the inside of another's room ("backend/cpu/..."), the public headers only
one another, Eigen and the standard library; only apps/ and lab/ print or exit, and CUDA stays in src/backend.
Usage: check_layers.py [ROOT]; exits with 1 and one line a finding if something is out of place.
"""

import pathlib
import re
import sys

# What each folder of src/ may include beside itself and include/plumbline.
LIBRARY = {
    "core": set(),
    "kernels": {"core"},
    "io": {"core"},
    "eval": {"core"},
    "sensor": {"core"},
    "sim": {"core", "sensor", "io"},
    "capture": {"core", "io"},
    "backend": {"core", "kernels"},
    "map": {"core", "kernels", "backend"},
    "tracking": {"core", "kernels", "backend"},
    "place": {"core", "kernels", "backend", "tracking"},
    "graph": {"core", "kernels", "io", "backend", "tracking", "place"},
    "fusion": {"core", "kernels", "io", "backend", "map", "tracking"},
    "pipeline": {"core", "kernels", "sensor", "backend", "map", "tracking", "place"},
    "calibration": {"core", "kernels", "io", "sensor", "backend", "tracking", "pipeline"},
    "reconstruction": {"core", "io", "sensor", "backend", "fusion", "graph", "pipeline", "calibration"},
}
# The same for apps/plumbline and lab, beside the library; main.cpp joins all of them.
PROGRAM = {
    "cli": set(),
    "view": {"cli"},
    "run": {"cli", "view"},
    "report": {"cli", "run", "view"},
    "commands": {"cli", "run", "report", "view"},
    "lab": {"cli", "run", "report", "view"},
    "main": {"cli", "run", "report", "view", "commands", "lab"},
}
ALLOWED = {"plumbline": set(), **LIBRARY, **{name: below | set(LIBRARY) for name, below in PROGRAM.items()}}
PRINTING = set(PROGRAM)
OPEN = {"io/images"}  # rooms within a room that are for others, too: image files are read and written everywhere
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"')
SYSTEM_INCLUDE = re.compile(r"^\s*#\s*include\s*<([^>]+)>")
STANDARD = re.compile(r"Eigen/\w+|\w+")
PRINTS = re.compile(r"std::(cout|cerr|clog)|\b(printf|puts|exit|abort|_exit)\s*\(|fmt::print|\bstderr\b|\bstdout\b")
CUDA = re.compile(r"__global__|cudaMalloc|<<<")
COMMENT = re.compile(r"//.*$")
STRING = re.compile(r'"(\\.|[^"\\])*"')


def folder_of(path: pathlib.PurePath) -> str:
    """The name in ALLOWED of a path relative to the root."""
    if path.parts[:2] == ("apps", "plumbline"):
        return path.parts[2] if len(path.parts) > 3 else path.stem
    return "lab" if path.parts[0] == "lab" else path.parts[1]


def include_finding(folder: str, included: str):
    parts = included.split("/")
    if len(parts) == 1:
        return f'"{included}" is included without its folder'
    if parts[0] not in {folder, "plumbline"} | ALLOWED[folder]:
        return f"{folder} must not include {parts[0]}"
    if len(parts) > 2 and parts[0] != folder and "/".join(parts[:2]) not in OPEN:
        return f"{folder} must not include the inside of {parts[0]}"
    return None


def findings(source: pathlib.Path, folder: str):
    for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
        include, system = INCLUDE.match(line), SYSTEM_INCLUDE.match(line)
        if include and (message := include_finding(folder, include[1])):
            yield number, message
        if system and folder == "plumbline" and not STANDARD.fullmatch(system[1]):
            yield number, f"a public header must not include <{system[1]}>"
        code = COMMENT.sub("", STRING.sub('""', line))
        if folder not in PRINTING and PRINTS.search(code):
            yield number, "only apps/ and lab/ print or exit"
        if folder != "backend" and CUDA.search(code):
            yield number, "CUDA belongs in src/backend"


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    sources = [p for top in ("include", "src", "apps", "lab") for p in sorted((root / top).rglob("*"))
               if p.suffix in {".h", ".cpp", ".cu", ".cuh"}]
    bad = 0
    for source in sources:
        relative = source.relative_to(root)
        folder = folder_of(relative)
        if folder not in ALLOWED:
            print(f"{relative}: the folder '{folder}' has no place in ALLOWED of {pathlib.Path(__file__).name}")
            bad += 1
            continue
        for number, message in findings(source, folder):
            print(f"{relative}:{number}: {message}")
            bad += 1
    print(f"{len(sources)} files, {bad} findings")
    return 1 if bad or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
