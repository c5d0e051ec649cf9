#!/usr/bin/env python3
"""`plumbline calibrate` on simulated recordings, through rendered depth and the tracker, as Markdown tables.

    bench/calibration.py [-o DIR] [--seeds 20] [--poor 20] [--scene room] [--size 320x240] [--rate 20] [--jobs N]

Every seed has a mounting drawn at random, a latency, a clock and a depth camera of its own, and the error model of a
BNO055 (±3°, ±10°). The same frames are then calibrated with an ideal sensor, with the depth as it was measured, and
with the true poses. The poor ones must be refused: turned about one axis (a turntable, a sweep), held still, too short.
"""

import argparse
import dataclasses
import math
import pathlib
import random
import shutil
import statistics
import sys
import tomllib

import runs

DANCE = ("--trajectory", "dance", "--duration", "14")
POOR = {"turntable": ("--trajectory", "turntable", "--duration", "10"),
        "sweep": ("--trajectory", "sweep", "--duration", "8"),
        "held still": ("--trajectory", "dance", "--duration", "0.2", "--speed", "0.025"),
        "too short": ("--trajectory", "dance", "--duration", "1.8")}


def degrees_between(p, q):
    x, y, z = (p[3] * q[i] - q[3] * p[i] - (p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3])
               for i in range(3))
    return math.degrees(2 * math.atan2(math.hypot(x, y, z), abs(sum(a * b for a, b in zip(p, q)))))


@dataclasses.dataclass
class Case:
    folder: pathlib.Path
    seed: int
    motion: tuple
    scene: str
    size: str
    rate: str

    def __post_init__(self):
        draw = random.Random(self.seed)
        q = [draw.gauss(0, 1) for _ in range(4)]
        self.mounting = [value / math.hypot(*q) for value in q]
        self.latency, self.clock = draw.uniform(0, 0.06), draw.uniform(-0.4, 0.4)
        self.sequence = self.folder / "sequence"

    @property
    def name(self):
        return self.folder.name

    def simulate(self, folder, size, *more):
        runs.call("simulate", "-o", str(folder), "--scene", self.scene, *self.motion, "--rate", self.rate, "--size", size,
                  "--no-color", "--seed", str(self.seed), "--quiet", "--imu-latency", str(self.latency),
                  "--imu-clock-offset", str(self.clock), "--imu-mounting", " ".join(map(str, self.mounting)), *more)

    def record(self):
        self.simulate(self.sequence, self.size)

    def calibrate(self, readings, *source):
        """Errors of mounting (degrees) and offset (ms); what the program said where it refused."""
        file = self.folder / "mounting.toml"
        file.unlink(missing_ok=True)
        try:
            runs.call("calibrate", "-o", str(file), "--orientation", str(readings), *map(str, source))
        except runs.Failure as failure:
            return next((line for line in str(failure).splitlines() if "error:" in line), str(failure))
        found = tomllib.loads(file.read_text(encoding="utf-8"))
        return (degrees_between(found["mounting"]["body_from_camera"], self.mounting),
                1e3 * abs(found["time"]["offset"] + self.latency + self.clock))

    def track(self, name, *options):
        runs.call("run", str(self.sequence), "-o", str(self.folder / name), "--no-mesh", "--no-report", "--quiet", *options)
        return self.folder / name / "trajectory.txt"


def good(case):
    case.record()
    depth, chip, truth = case.folder / "depth.toml", case.sequence / "orientation.txt", case.sequence / "groundtruth.txt"
    ideal = case.folder / "ideal"
    case.simulate(ideal, "8x8", "--imu-ideal")
    result = {"chip": case.calibrate(chip, case.sequence, "--depth-output", depth)}
    result["ideal sensor"] = case.calibrate(ideal / "orientation.txt", case.sequence)
    bent = case.track("bent", "--set", "preprocess.calibrate_depth=false")
    result["chip, depth as measured"] = case.calibrate(chip, "--trajectory", bent)
    result["chip, true poses"] = case.calibrate(chip, "--trajectory", truth)
    shutil.rmtree(case.sequence / "depth")
    print(f"{case.name}: {result}", file=sys.stderr, flush=True)
    return result


def poor(case):
    case.record()
    said = case.calibrate(case.sequence / "orientation.txt", case.sequence)
    shutil.rmtree(case.sequence / "depth")
    print(f"{case.name}: {said}", file=sys.stderr, flush=True)
    return said


def row(name, results):
    found = [result for result in results if not isinstance(result, str)]
    cells = [f"{len(found)} of {len(results)}"]
    for which, digits in ((0, 3), (1, 2)):
        values = [result[which] for result in found]
        cells += [f"{f(values):.{digits}f}" if values else "–" for f in (statistics.median, max)]
    return f"| {name} | {' | '.join(cells)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(seeds=20)
    parser.add_argument("--poor", type=int, default=20, metavar="N", help="poor recordings (default 20)")
    parser.add_argument("--scene", default="room", help="of `plumbline simulate` (default room)")
    parser.add_argument("--size", default="320x240", help="of the depth images (default 320x240)")
    parser.add_argument("--rate", default="20", help="frames a second (default 20)")
    arguments = runs.parse(parser, "calibration")
    cases = [Case(arguments.output / f"good-{seed}", seed, DANCE, arguments.scene, arguments.size, arguments.rate)
             for seed in range(1, arguments.seeds + 1)]
    results = runs.known(runs.each(good, cases, arguments.jobs))
    if results:
        print("| sensor | found good | mounting, median (°) | worst (°) | offset, median (ms) | worst (ms) |")
        print("|---|---|---|---|---|---|")
        for name in results[0]:
            print(row(name, [result[name] for result in results]))
    kinds = list(POOR)
    cases = [Case(arguments.output / f"poor-{seed}", 100 + seed, POOR[kinds[seed % len(kinds)]], arguments.scene, arguments.size,
                  arguments.rate)
             for seed in range(arguments.poor)]
    said = list(runs.each(poor, cases, arguments.jobs))
    if said:
        print("\n| poor motion | refused |\n|---|---|")
        for index, kind in enumerate(kinds):
            of_kind = said[index::len(kinds)]
            print(f"| {kind} | {sum(isinstance(s, str) for s in of_kind)} of {len(of_kind)} |")


if __name__ == "__main__":
    main()
