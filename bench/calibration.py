#!/usr/bin/env python3
"""Calibration from simulated recordings through rendered depth and the tracker, as a Markdown table.

    bench/calibration.py [-o DIR] [--cases 20] [--size 320x240] [--rate 20] [--duration 10] [--scene room] [--poor]

Each case has a mounting drawn at random, a latency and a clock of its own and the error model of a BNO055 (±3°, ±10°);
the same frames are then calibrated with an ideal sensor, and both with the true poses in place of the tracked ones.
--poor makes recordings that must be refused: a sweep, a turntable, and a dance that is too short. Depth images are
removed after use. PLUMBLINE names the program.
"""

import argparse
import json
import math
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tomllib

import runs


def multiply(p, q):
    (a, b, c, d), (e, f, g, h) = p, q
    return (d * e + a * h + b * g - c * f, d * f - a * g + b * h + c * e, d * g + a * f - b * e + c * h,
            d * h - a * e - b * f - c * g)


def degrees_between(p, q):
    x, y, z, w = multiply((-p[0], -p[1], -p[2], p[3]), q)
    return math.degrees(2 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w)))


class Case:
    def __init__(self, arguments, seed, trajectory="dance", duration=None):
        draw = random.Random(seed)
        q = [draw.gauss(0, 1) for _ in range(4)]
        self.mounting = [value / math.sqrt(sum(v * v for v in q)) for value in q]
        self.latency, self.clock = draw.uniform(0, 0.06), draw.uniform(-0.4, 0.4)
        self.size = arguments.size
        self.folder = arguments.output / f"{trajectory}-{seed}"
        self.options = ["--scene", arguments.scene, "--trajectory", trajectory, "--duration",
                        str(duration or arguments.duration), "--rate", str(arguments.rate), "--no-color", "--seed", str(seed), "--quiet", "--imu-latency", str(self.latency),
                        "--imu-clock-offset", str(self.clock), "--imu-mounting", " ".join(map(str, self.mounting))]

    def simulate(self):
        runs.call("simulate", "-o", str(self.folder), "--size", self.size, *self.options)
        # The same sensor without its error: only the readings are wanted.
        ideal = self.folder / "ideal"
        runs.call("simulate", "-o", str(ideal), *self.options, "--imu-ideal", "--size", "8x8")
        shutil.copy(ideal / "orientation.txt", self.folder / "orientation-ideal.txt")
        shutil.rmtree(ideal)

    def calibrate(self, readings, *source):
        """Verdict, errors in degrees and milliseconds, standard deviations in the same."""
        file = self.folder / "mounting.toml"
        file.unlink(missing_ok=True)
        done = subprocess.run([runs.PROGRAM, "calibrate", "-o", str(file), "--orientation", str(self.folder / readings),
                               *map(str, source)], check=False, capture_output=True, text=True)
        if done.returncode != 0:
            return {"good": False, "says": done.stderr.strip().splitlines()[0]}
        found = tomllib.loads(file.read_text(encoding="utf-8"))
        tracked = re.search(r"(\d+) of (\d+) frames tracked", done.stdout)
        return {"good": True, "mounting": degrees_between(found["mounting"]["body_from_camera"], self.mounting),
                "offset": 1e3 * (found["time"]["offset"] + self.latency + self.clock),
                "sd": math.sqrt(sum(s * s for s in found["mounting"]["sd_deg"])), "offset_sd": 1e3 * found["time"]["sd"],
                "lost": int(tracked[2]) - int(tracked[1]) if tracked else 0}


def track(case):
    """The tracker runs once a case; both sensors are calibrated against its poses."""
    runs.call("run", str(case.folder), "-o", str(case.folder / "out"), "--no-mesh", "--quiet", "--no-color")
    return case.folder / "out" / "trajectory.txt"


def good_case(case):
    case.simulate()
    tracked, truth = track(case), case.folder / "groundtruth.txt"
    result = {name: case.calibrate(readings, "--trajectory", poses)
              for name, readings, poses in (("chip", "orientation.txt", tracked),
                                            ("ideal", "orientation-ideal.txt", tracked),
                                            ("chip, true poses", "orientation.txt", truth),
                                            ("ideal, true poses", "orientation-ideal.txt", truth))}
    summary = json.loads((case.folder / "out" / "summary.json").read_text(encoding="utf-8"))
    shutil.rmtree(case.folder / "depth")
    return result, summary["lost"]


def row(name, results):
    good = [r for r in results if r["good"]]
    if not good:
        return f"| {name} | 0 of {len(results)} | – | – | – | – |"
    mounting, offset = sorted(r["mounting"] for r in good), sorted(abs(r["offset"]) for r in good)
    return (f"| {name} | {len(good)} of {len(results)} | {mounting[len(mounting) // 2]:.3f} | {mounting[-1]:.3f} | "
            f"{offset[len(offset) // 2]:.2f} | {offset[-1]:.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("calibration"))
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--rate", type=float, default=20)
    parser.add_argument("--duration", type=float, default=10)
    parser.add_argument("--scene", default="room")
    parser.add_argument("--poor", action="store_true")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    if arguments.poor:
        kinds = [("sweep", None), ("turntable", None), ("dance", 1.8)]
        results = []
        for index in range(arguments.cases):
            case = Case(arguments, 100 + index, *kinds[index % len(kinds)])
            case.simulate()
            results.append(case.calibrate("orientation.txt", case.folder))
            print(f"{case.folder.name}: {results[-1].get('says', 'NOT NOTICED')}", flush=True)
            shutil.rmtree(case.folder / "depth")
        sys.exit(any(r["good"] for r in results))
    found = []
    for seed in range(1, arguments.cases + 1):
        found.append(good_case(Case(arguments, seed)))
        print(f"{seed}: {found[-1]}", file=sys.stderr, flush=True)
    print("| sensor and poses | motion found good | mounting, median (°) | worst (°) | offset, median (ms) | worst (ms) |")
    print("|---|---|---|---|---|---|")
    for name in found[0][0]:
        print(row(name, [result[name] for result, _ in found]))
    print(f"\nLost frames: {sum(lost for _, lost in found)}.")


if __name__ == "__main__":
    main()
