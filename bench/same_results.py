#!/usr/bin/env python3
"""Whether two builds of the program give the same results to the bit.

    bench/same_results.py OLD_PROGRAM NEW_PROGRAM [--data DIR] [--frames N] [--only WORD]

Runs three presets on the head of fr1/rpy, 200 frames of fr1/xyz, ICL-NUIM kt3 and one simulated sequence with the chip's
orientation, with both programs, and compares trajectory.txt, mesh.ply and the columns of frames.csv that are no times.
Prints a table; exits with 1 where anything differs or a run fails, with 77 where the data is missing.
"""

import argparse
import csv
import filecmp
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

PRESETS = ("kinectfusion", "paper", "plumbline")
SEQUENCES = {"fr1/rpy": ("tum/*freiburg1_rpy*", 240), "fr1/xyz": ("tum/*freiburg1_xyz*", 200), "kt3": ("icl_nuim/*kt3*", 200)}


def find(data: pathlib.Path, pattern: str):
    return next((path for path in sorted(data.glob(pattern)) if path.is_dir()), None)


def start(program: str, *words) -> str:
    """Runs the program; the end of its error message if it fails."""
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else f"exit {done.returncode}: " + (done.stderr.strip().splitlines() or ["no message"])[-1]


def figures(path: pathlib.Path):
    """The columns of frames.csv without those of times, which no run repeats."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return [{name: value for name, value in row.items() if not name.endswith("_ms")} for row in rows]


def compare(old: pathlib.Path, new: pathlib.Path):
    """One word for each of the three files."""
    def same(name):
        if not (old / name).exists() or not (new / name).exists():
            return "missing"
        return "same" if filecmp.cmp(old / name, new / name, shallow=False) else "DIFFERS"
    trajectory, mesh, log = same("trajectory.txt"), same("mesh.ply"), same("frames.csv")
    if log == "DIFFERS":
        a, b = figures(old / "frames.csv"), figures(new / "frames.csv")
        columns = sorted({name for x, y in zip(a, b) for name in x.keys() | y.keys() if x.get(name) != y.get(name)})
        log = "same" if a == b else f"DIFFERS ({len(a)} and {len(b)} rows; {', '.join(columns[:6])})"
    return trajectory, mesh, log


def cases(programs, data, frames, work):
    """(name, [words of the run by the old program, by the new])."""
    for name, (pattern, count) in SEQUENCES.items():
        if folder := find(data, pattern):
            yield name, [[folder, "--max-frames", min(count, frames)]] * 2
        else:
            print(f"skipped: {name} is not in {data}", file=sys.stderr)
    for kind, program in programs.items():
        if error := start(program, "simulate", "-o", work / f"simulated_{kind}", "--frames", min(90, frames)):
            sys.exit(f"{program} simulate: {error}")
    yield "simulated with chip", [[work / f"simulated_{kind}", "--orientation", work / f"simulated_{kind}" / "orientation.txt",
                                   "--imu-model", "bno055"] for kind in programs]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--data", type=pathlib.Path, help="default: $PLUMBLINE_DATA, or ../shared/data beside the checkout")
    parser.add_argument("--frames", type=int, default=10**9, help="take no more frames of each sequence")
    parser.add_argument("--only", default="", help="only the cases whose line holds this word")
    arguments = parser.parse_args()
    beside = pathlib.Path(__file__).resolve().parent.parent.parent / "shared" / "data"
    data = arguments.data or pathlib.Path(os.environ.get("PLUMBLINE_DATA", beside))
    programs = {"old": arguments.old, "new": arguments.new}
    bad = compared = 0
    with tempfile.TemporaryDirectory(prefix="plumbline_same_") as folder:
        work = pathlib.Path(folder)
        print(f"{'sequence':20} {'preset':13} {'trajectory':10} {'mesh':10} frames.csv")
        for name, words in cases(programs, data, arguments.frames, work):
            for preset in PRESETS:
                if arguments.only not in f"{name} {preset}":
                    continue
                errors = [f"{kind}: {error}" for (kind, program), own in zip(programs.items(), words)
                          if (error := start(program, "run", *own, "--preset", preset, "--no-report", "-o", work / kind))]
                words_out = compare(work / "old", work / "new") if not errors else ("", "", "; ".join(errors))
                print(f"{name:20} {preset:13} {words_out[0]:10} {words_out[1]:10} {words_out[2]}", flush=True)
                bad += set(words_out) != {"same"}
                compared += 1
                for kind in programs:
                    shutil.rmtree(work / kind, ignore_errors=True)
    print(f"{compared} runs compared, {bad} differ")
    return 77 if not compared else int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
