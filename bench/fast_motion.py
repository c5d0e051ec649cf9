#!/usr/bin/env python3
"""Fast motion, where one run says little: every n-th frame of a sequence from each of its n first frames, on each
instruction set, with and without a sensor.

    bench/fast_motion.py [--stride 5] [--sets cpu:sse4.2,cpu:avx2+fma] [--sensors none,ideal,bno055,gyroscope]
                         [--seeds 3] [--offset 0] [-o DIR] [--jobs N] SEQUENCE [-- RUN OPTIONS...]

SEQUENCE is a TUM folder with groundtruth.txt. Sensors are made from it: `ideal` and `bno055` are orientations, the
latter with the chip's error under several seeds; `gyroscope` is the truth's rate of turn over 40 ms with 0.005 rad/s of
noise and a bias of 0.01 rad/s, and its specific force over 100 ms with 0.05 m/s², stamped `--offset` seconds late. One run has one thread. ATE over all
frames, a lost one with the previous accepted pose. What is there already is not run again.
"""

import argparse
import math
import pathlib
import random
import statistics
import sys

import runs
from kidnap import conjugate, product, rotate, unit

GRAVITY = 9.81  # m/s²


def rows_of(file):
    lines = file.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line.strip() and not line.startswith("#")]


def thinned(sequence, stride, first, output):
    """A folder with every `stride`-th depth image from `first` on; its name keeps the sequence's, which may tell the camera."""
    folder = output / f"{sequence.name}-{stride}-{first}"
    folder.mkdir(parents=True, exist_ok=True)
    for entry in sequence.iterdir():
        link = folder / entry.name
        if entry.name not in ("depth.txt", "rgb", "rgb.txt", "accelerometer.txt") and not link.exists():
            link.symlink_to(entry.resolve())
    (folder / "depth.txt").write_text("\n".join(rows_of(sequence / "depth.txt")[first::stride]) + "\n", encoding="utf-8")
    return folder


def turn_between(a, b):
    """Rotation vector in the body's frame from orientation a to b."""
    q = product(conjugate(a), b)
    if q[3] < 0:
        q = tuple(-c for c in q)
    sine = math.sqrt(sum(c * c for c in q[:3]))
    scale = 2 * math.atan2(sine, q[3]) / sine if sine > 1e-12 else 2
    return [scale * c for c in q[:3]]


def write_gyroscope(truth, offset, file):
    poses = [[float(word) for word in row.split()] for row in rows_of(truth)]
    noise = random.Random(1)
    lines = ["timestamp,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z"]
    for i in range(5, len(poses) - 5):
        before, here, after = poses[i - 2], poses[i], poses[i + 2]
        seconds, half = after[0] - before[0], (poses[i + 5][0] - poses[i - 5][0]) / 2
        if not (0 < seconds < 0.2 and half < 0.2):
            continue
        turn = turn_between(unit(before[4:8]), unit(after[4:8]))
        rate = [turn[axis] / seconds + 0.01 + noise.gauss(0, 0.005) for axis in range(3)]
        force = [(poses[i - 5][k] - 2 * here[k] + poses[i + 5][k]) / half**2 + (GRAVITY if k == 3 else 0) for k in (1, 2, 3)]
        felt = [value + noise.gauss(0, 0.05) for value in rotate(conjugate(unit(here[4:8])), force)]
        lines.append(f"{here[0] + offset:.6f}," + ",".join(f"{value:.6f}" for value in rate + felt))
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def variants_of(sensor, arguments):
    """Of one sensor: a name, its error model and seed, and further options."""
    if sensor == "gyroscope":
        file = arguments.output / f"gyroscope-{arguments.offset:g}.csv"
        write_gyroscope(arguments.sequence / "groundtruth.txt", arguments.offset, file)
        return [(f"{sensor}-{arguments.offset:g}", "none", 1, ("--orientation", str(file)))]
    options = ("--orientation", "none") if sensor == "none" else ()
    return [(f"{sensor}-{seed}", sensor, seed, options) for seed in runs.seeds_of(sensor, arguments.seeds)]


def runs_of(sensor, backend, arguments):
    for first in range(arguments.stride):
        folder = thinned(arguments.sequence, arguments.stride, first, arguments.output)
        for name, model, seed, options in variants_of(sensor, arguments):
            output = arguments.output / f"run-{arguments.stride}-{first}-{backend.replace(':', '-')}-{name}"
            yield runs.Run(output, folder, "plumbline", model, seed,
                           ("--threads", "1", "--backend", backend, "--detail", "off", "--no-report", *options,
                            *arguments.options))


def measured(run):
    lost = run.summary()["lost"]
    return run.rmse("ate", run.write_all_frames()), lost


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", type=pathlib.Path)
    parser.add_argument("--stride", type=int, default=5)
    parser.add_argument("--sets", default="cpu:sse4.2,cpu:avx2+fma")
    parser.add_argument("--sensors", default="none,ideal,bno055,gyroscope")
    parser.add_argument("--offset", type=float, default=0.0, help="seconds by which the gyroscope's stamps are late")
    parser.set_defaults(seeds=3)
    arguments = runs.parse(parser, "fast_motion")
    arguments.sequence = arguments.sequence.resolve()
    arguments.output.mkdir(parents=True, exist_ok=True)

    print("| sensor | instruction set | runs | best | median | worst ATE, m | lost frames, worst |\n|---|---|---|---|---|---|---|")
    for sensor in arguments.sensors.split(","):
        for backend in arguments.sets.split(","):
            found = runs.known(runs.each(measured, list(runs_of(sensor, backend, arguments)), arguments.jobs))
            errors = [error for error, _ in found if error is not None]
            if not errors:
                sys.exit(f"fast_motion: no run with {sensor} on {backend} came to its end")
            print(f"| {sensor} | {backend} | {len(errors)} | {min(errors):.4f} | {statistics.median(errors):.4f} "
                  f"| {max(errors):.4f} | {max(lost for _, lost in found)} |", flush=True)


if __name__ == "__main__":
    main()
