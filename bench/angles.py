#!/usr/bin/env python3
"""The paper's angular test (Giancola et al. 2018) on simulated scenes, as a Markdown table: failures in % of the pairs.

    bench/angles.py [--scenes desk,room,kitchen] [--angles 5,10,15,20,25,30,40,50,60] [--seeds 5] [--pairs 20]
                    [--simulate "SIMULATE OPTIONS..."] [-o DIR] [-- ANGLES OPTIONS...]

Each scene and angle has a sequence of its own (`plumbline simulate --turn`): two frames at each place, the camera turned
between them about a random axis across its line of sight. The orientation is the ground truth's, as it is ("ideal")
and with the error model of a BNO055; failures over all seeds are counted together. What is in DIR already, sequences
and results, is not made again: give another DIR for other options or another program. PLUMBLINE names the program.
"""

import argparse
import json
import pathlib
import shlex
import sys

import runs

ROWS = [("kinectfusion", "none"), ("paper", "ideal"), ("paper", "bno055"), ("plumbline", "none"), ("plumbline", "ideal"),
        ("plumbline", "bno055")]
PAPER_ANGLES = [5, 10, 15, 20, 25, 30, 40, 50, 60]
PAPER = {"original": [0, 10, 25, 55, 75, 90, 100, 100, 100], "with IMU": [0, 0, 10, 0, 10, 0, 5, 10, 100]}


def simulate(arguments, scene, angle):
    """The folder of the sequence."""
    folder = pathlib.Path(arguments.output) / f"{scene}-{angle:g}-{arguments.pairs}"
    # depth.txt is written last of all: what was broken off is made again. As fast as it takes for the 8 s of the path to be
    # through in these frames at 30 a second: the places lie all along it.
    if not (folder / "depth.txt").exists():
        runs.call("simulate", "-o", str(folder), "--scene", scene, "--trajectory", "handheld",
                  "--speed", f"{120 / arguments.pairs:g}", "--turn", f"{angle:g}", "--frames", str(2 * arguments.pairs),
                  "--no-color", "--quiet", *shlex.split(arguments.simulate))
    return folder


def test(arguments, scene, angle, preset, sensor, seed):
    """(failures, pairs) of one sequence."""
    folder = simulate(arguments, scene, angle)
    result = folder / f"{preset}-{sensor}-{seed}.json"
    if not result.exists():
        runs.call("angles", str(folder), "--angles", f"{angle:g}", "--pairs", str(arguments.pairs), "--preset", preset,
                  *runs.volume_of(preset), *runs.sensor_options(folder / "groundtruth.txt", sensor, seed),
                  *arguments.options, "--json", str(result), "--csv", str(result.with_suffix(".csv")))
    found = json.loads(result.read_text(encoding="utf-8"))["angles"][0]
    return found["failures"], found["pairs"]


def total(counts):
    """(failures, pairs) of several."""
    failures, pairs = zip(*counts)
    return sum(failures), sum(pairs)


def count(arguments, scene, angle, preset, sensor):
    """(failures, pairs) over the seeds."""
    return total(test(arguments, scene, angle, preset, sensor, seed) for seed in runs.seeds_of(sensor, arguments.seeds))


def print_row(scene, row, counts):
    cells = [f"{100 * failures / pairs:.0f}" if pairs else "–" for failures, pairs in counts]
    print(f"| {scene} | {row[0]} | {row[1]} | " + " | ".join(cells) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="desk,room,kitchen")
    parser.add_argument("--angles", default=",".join(str(angle) for angle in PAPER_ANGLES))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--simulate", default="", help='more options of `plumbline simulate`, such as "--distortion 0"')
    parser.add_argument("-o", "--output", default=str(runs.ROOT / "build" / "angles"))
    parser.add_argument("options", nargs="*")
    arguments = parser.parse_args()
    angles = [float(text) for text in arguments.angles.split(",")]
    scenes = arguments.scenes.split(",")
    print("| scene | preset | orientation | " + " | ".join(f"{angle:g}°" for angle in angles) + " |")
    print("|---" * (3 + len(angles)) + "|")
    counted = {}
    for scene in scenes:
        for row in ROWS:
            try:
                counted[scene, row] = [count(arguments, scene, angle, *row) for angle in angles]
            except runs.Failure as failure:
                sys.exit(f"angles: {scene}, {row[0]} {row[1]}: {failure}")
            print_row(scene, row, counted[scene, row])
    for row in ROWS if len(scenes) > 1 else []:
        print_row("all", row, [total(counted[scene, row][i] for scene in scenes) for i in range(len(angles))])
    for name, failures in PAPER.items():
        known = dict(zip(PAPER_ANGLES, failures))
        print(f"| paper | {name} | | " + " | ".join(str(known.get(angle, "–")) for angle in angles) + " |")


if __name__ == "__main__":
    main()
