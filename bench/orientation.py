#!/usr/bin/env python3
"""Presets side by side on recorded sequences, with and without an orientation sensor, as a Markdown table.

    bench/orientation.py SEQUENCE [-n FRAMES] [--stride 1,2,3,5] [--seeds 5] [-o DIR] [-- RUN OPTIONS...]

The orientation is the sequence's ground truth: as it is ("ideal"), and with the error model of a BNO055 under several
seeds (mean, and the worst in brackets). A run whose summary.json is there already is not repeated. PLUMBLINE names the
program.
"""

import argparse
import csv
import json
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = os.environ.get("PLUMBLINE", str(ROOT / "build" / "release" / "plumbline"))
# The placement of the volume decides as much as the method (METHOD.md §6.5): the same for all.
PLACEMENT = ["--set", "volume.side=6", "--set", "volume.offset=-0.4"]
ROWS = [("kinectfusion", "none"), ("paper", "ideal"), ("paper", "bno055"), ("plumbline", "none"), ("plumbline", "ideal"),
        ("plumbline", "bno055")]


def run(arguments, preset, sensor, seed, stride):
    """The run's summary with its RPE, or None if nothing could be tracked."""
    name = f"{pathlib.Path(arguments.sequence).name}-{preset}-{sensor}-{seed}-{stride}"
    folder = pathlib.Path(arguments.output) / name
    summary = folder / "summary.json"
    truth = os.path.join(arguments.sequence, "groundtruth.txt")
    if not summary.exists():
        command = [PROGRAM, "run", arguments.sequence, "-o", str(folder), "--preset", preset, "--quiet", "--no-color", "--no-mesh",
                   "--stride", str(stride), "--max-frames", str(arguments.frames), *PLACEMENT, *arguments.options]
        if sensor != "none":
            command += ["--orientation", truth, "--orientation-max-gap", "0.5", "--imu-model", sensor, "--imu-seed", str(seed)]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode != 0:
            print(f"{name}: {done.stderr.strip()}", file=sys.stderr)
            return None
    result = json.loads(summary.read_text(encoding="utf-8"))
    rpe = subprocess.run([PROGRAM, "eval", "rpe", truth, str(folder / "trajectory.txt"), "--json"], check=False,
                         capture_output=True, text=True)
    result["rpe"] = json.loads(rpe.stdout)["translation_m"]["rmse"] if rpe.returncode == 0 else None
    with open(folder / "frames.csv", encoding="utf-8") as rows:
        result["ms"] = statistics.median(float(row["total_ms"]) for row in csv.DictReader(rows))
    return result


def cell(values, form):
    known = [v for v in values if v is not None]
    if not known:
        return "–"
    return form.format(known[0]) if len(known) == 1 else f"{form.format(statistics.mean(known))} ({form.format(max(known))})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence")
    parser.add_argument("-n", "--frames", type=int, default=0)
    parser.add_argument("--stride", default="1")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("-o", "--output", default=str(ROOT / "build" / "orientation"))
    parser.add_argument("options", nargs="*")
    arguments = parser.parse_args()
    print("| stride | preset | orientation | lost | ATE RMSE (m) | RPE 1 s (m) | iterations | ms a frame |")
    print("|---|---|---|---|---|---|---|---|")
    for stride in [int(text) for text in arguments.stride.split(",")]:
        for preset, sensor in ROWS:
            seeds = range(1, arguments.seeds + 1) if sensor == "bno055" else [1]
            runs = [run(arguments, preset, sensor, seed, stride) for seed in seeds]
            ran = [r for r in runs if r]
            frames = ran[0]["frames"] if ran else "?"
            lost = cell([r["lost"] for r in ran], "{:.0f}")
            print(f"| {stride} | {preset} | {sensor} | {lost} of {frames} | "
                  f"{cell([(r['ate'] or {}).get('rmse_m') for r in ran], '{:.4f}')} | {cell([r['rpe'] for r in ran], '{:.4f}')} | "
                  f"{cell([r['mean_iterations'] for r in ran], '{:.1f}')} | {cell([r['ms'] for r in ran], '{:.1f}')} |", flush=True)


if __name__ == "__main__":
    main()
