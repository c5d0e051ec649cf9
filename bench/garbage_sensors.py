#!/usr/bin/env python3
"""What a broken sensor costs: a recording without a sensor, with a good one, and with twelve kinds of garbage.

    bench/garbage_sensors.py [--stride 1] [--sensors gyroscope,orientation] [-o DIR] [--jobs N] SEQUENCE ... [-- RUN OPTIONS...]

SEQUENCE is a TUM folder with groundtruth.txt. Gyroscope and accelerometer are those of its imu.csv, where it has one
(simulated recordings), else made from the truth as bench/fast_motion.py does; orientations are the truth's. ATE over
all frames, a lost one with the previous accepted pose. A row fails if it is more than 2 % and 0.2 mm worse than without a sensor, or
loses more frames; the good sensor's if it is used in less than 98 % of the frames. A sensor that the program refuses to
read is told by its message. What is there already is not run again.
"""

import argparse
import math
import pathlib
import random
import sys

import fast_motion
import runs
from kidnap import conjugate, product, unit

ALLOWED, FLOOR, USED = 1.02, 0.0002, 0.98
HEAD = "timestamp,gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],acc_x [m/s^2],acc_y [m/s^2],acc_z [m/s^2]"
QUARTER = (0, 0, math.sqrt(0.5), math.sqrt(0.5))  # a turn about z


def readings_of(file):
    """Lines of numbers, the first seven."""
    rows = []
    for line in file.read_text(encoding="utf-8").splitlines():
        try:
            rows.append([float(word) for word in line.replace(",", " ").split()[:7]])
        except ValueError:
            pass
    return rows


def turned(row):
    """Axes x, y, z for y, z, x."""
    return [row[0], row[2], row[3], row[1], row[5], row[6], row[4]]


def every(change):
    return lambda rows: [change(row) for row in rows]


def half(rows):
    chance = random.Random(1)
    return [row for row in rows if chance.random() < 0.5]


def noise(rows):
    chance = random.Random(1)
    return [[row[0]] + [chance.gauss(0, 1) for _ in range(3)] + [chance.gauss(0, 6) for _ in range(3)] for row in rows]


def dead_in_the_middle(rows):
    return rows[:len(rows) // 2 + 1] + [[row[0]] + [math.nan] * (len(row) - 1) for row in rows[len(rows) // 2 + 1:]]


def another(rows):
    """What the sensor would have read had the recording run backwards: a hand's motion, but not this one."""
    return [[row[0]] + other[1:] for row, other in zip(rows, reversed(rows))]


GYROSCOPE = {
    "good": every(list),
    "wrong axes": every(turned),
    "degrees for radians": every(lambda r: [r[0]] + [math.degrees(v) for v in r[1:4]] + r[4:]),
    "constant": lambda rows: [[row[0]] + rows[0][1:] for row in rows],
    "NaN from the middle on": dead_in_the_middle,
    "zeros": every(lambda r: [r[0]] + [0] * 6),
    "another clock": every(lambda r: [r[0] + 3] + r[1:]),
    "half of the readings": half,
    "noise": noise,
    "sign": every(lambda r: [r[0]] + [-v for v in r[1:4]] + r[4:]),
    "x and y exchanged": every(lambda r: [r[0], r[2], r[1], r[3], r[5], r[4], r[6]]),
    "saturated": every(lambda r: [r[0]] + [max(-0.4, min(0.4, v)) for v in r[1:4]] + r[4:]),
    "another recording's": another,
}


def random_orientations(rows):
    chance = random.Random(1)
    return [[row[0]] + list(unit(tuple(chance.gauss(0, 1) for _ in range(4)))) for row in rows]


ORIENTATION = {
    "good": every(list),
    "wrong axes": every(lambda r: [r[0], *product(tuple(r[1:]), QUARTER)]),
    "world to body": every(lambda r: [r[0], *conjugate(tuple(r[1:]))]),
    "constant": lambda rows: [[row[0]] + rows[0][1:] for row in rows],
    "another clock": every(lambda r: [r[0] + 3] + r[1:]),
    "half of the readings": half,
    "noise": random_orientations,
    "another recording's": another,
}


def sources(sensor, sequence, output):
    """A name and a file for each kind of reading."""
    truth = sequence / "groundtruth.txt"
    if sensor == "gyroscope":
        kinds, head, own = GYROSCOPE, HEAD, sequence / "imu.csv"
        rows = readings_of(own if own.exists() else
                           fast_motion.write_gyroscope(truth, 0, output / f"{sequence.name}-made.csv"))
    else:
        kinds, head = ORIENTATION, "timestamp,qx,qy,qz,qw"
        rows = [[float(w) for w in (row.split()[0], *row.split()[4:8])] for row in fast_motion.rows_of(truth)]
    for name, change in kinds.items():
        file = output / f"{sequence.name}-{sensor}-{name.replace(' ', '-').replace(chr(39), '')}.csv"
        lines = [f"{row[0]:.6f}," + ",".join(f"{value:.7g}" for value in row[1:]) for row in change(rows)]
        file.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
        yield name, file


def measured(run):
    try:
        summary = run.summary()
    except runs.Failure as failure:
        return str(failure).splitlines()[0]
    sensor = summary["orientation"] or {"used": 0}
    return run.rmse("ate", run.write_all_frames()), summary["lost"], sensor["used"] / (summary["frames"] - 1), sensor


def run_with(name, file, sequence, arguments):
    options = ("--threads", "1", "--detail", "off", "--no-report", "--stride", str(arguments.stride), "--orientation",
               str(file), *arguments.options)
    return runs.Run(arguments.output / f"{sequence.name}-{arguments.stride}-{name.replace(' ', '-').replace(chr(39), '')}",
                    sequence, "plumbline", options=options)


def verdict(name, found, without):
    error, lost, used, _ = found
    bad = error > ALLOWED * without[0] + FLOOR or lost > without[1] or (name == "good" and used < USED)
    return "FAILS" if bad else ""


def table(sensor, sequence, arguments):
    """How many rows fail."""
    kinds = list(sources(sensor, sequence, arguments.output))
    jobs = [run_with("none", "none", sequence, arguments)]
    jobs += [run_with(f"{sensor}-{name}", file, sequence, arguments) for name, file in kinds]
    without, *found = runs.each(measured, jobs, arguments.jobs)
    print(f"\n{sequence.name}, every {arguments.stride}. frame, {sensor}: without {without[0]:.4f} m, {without[1]} lost\n\n"
          "| sensor | ATE, m | with / without | lost | used | why not | |\n|---|---|---|---|---|---|---|")
    failed = 0
    for (name, _), one in zip(kinds, found):
        if isinstance(one, str):
            print(f"| {name} | refused: {one} | | | | | |")
            continue
        reasons = ", ".join(f"{key} {one[3][key]}" for key in ("missing", "distrusted", "dropped") if one[3].get(key))
        word = verdict(name, one, without)
        failed += bool(word)
        print(f"| {name} | {one[0]:.4f} | {one[0] / without[0]:.2f} | {one[1]} | {100 * one[2]:.0f} % | {reasons} | {word} |",
              flush=True)
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", type=lambda text: pathlib.Path(text).resolve(), nargs="+", metavar="SEQUENCE")
    parser.add_argument("--stride", type=int, default=1)
    parser.add_argument("--sensors", default="gyroscope,orientation")
    parser.set_defaults(seeds=1)
    arguments = runs.parse(parser, "garbage_sensors")
    arguments.output.mkdir(parents=True, exist_ok=True)
    failed = sum(table(sensor, sequence, arguments)
                 for sequence in arguments.sequences for sensor in arguments.sensors.split(","))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
