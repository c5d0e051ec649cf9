#!/usr/bin/env python3
"""Checks `plumbline eval` against a second implementation of the TUM benchmark's definitions, in NumPy.

    reference_errors.py PLUMBLINE DATA

DATA holds trajectories/groundtruth and trajectories/rgbdslam. Everything is done the long way here: all pairs of
stamps sorted, matrices of 4x4, no search trees. Exit code 77 without the data.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
from decimal import Decimal

import numpy as np

METRES, DEGREES = 1e-6, 1e-5
SKIPPED = 77
FEW = 90  # poses: all pairs of so many are not thinned


def read(path):
    """Stamps in ns (exact: floating-point stamps decide ties at random) and poses of 4x4, of doubled stamps the first."""
    poses = {}
    for line in path.read_text().splitlines():
        fields = line.replace(",", " ").split()
        if not fields or line.startswith("#"):
            continue
        x, y, z, w = np.array(fields[4:8], float) / np.linalg.norm(np.array(fields[4:8], float))
        pose = np.eye(4)
        pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
        pose[:3, 3] = np.array(fields[1:4], float)
        poses.setdefault(int(round(Decimal(fields[0]) * 10**9)), pose)
    stamps = sorted(poses)
    return np.array(stamps, np.int64), np.array([poses[t] for t in stamps])


def associate(a, b, limit=20_000_000):
    near = np.abs(a[:, None] - b[None, :])
    candidates = sorted((int(near[i, j]), i, j) for i, j in zip(*np.nonzero(near < limit)))
    used_a, used_b, pairs = set(), set(), []
    for _, i, j in candidates:
        if i not in used_a and j not in used_b:
            used_a.add(i)
            used_b.add(j)
            pairs.append((i, j))
    return np.array(sorted(pairs))


def statistics(values):
    return {"rmse": np.sqrt(np.mean(values**2)), "mean": values.mean(), "median": np.median(values),
            "std": values.std(), "min": values.min(), "max": values.max()}


def ate(truth, estimate):
    pairs = associate(truth[0], estimate[0])
    target, source = truth[1][pairs[:, 0], :3, 3], estimate[1][pairs[:, 1], :3, 3]
    # Horn 1987 by the singular values of the correlation.
    u, _, vt = np.linalg.svd((target - target.mean(0)).T @ (source - source.mean(0)))
    rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    aligned = (source - source.mean(0)) @ rotation.T + target.mean(0)
    return len(pairs), statistics(np.linalg.norm(aligned - target, axis=1)), None


def angles(rotations):
    skew = rotations - rotations.transpose(0, 2, 1)
    sine = np.sqrt(skew[:, 2, 1]**2 + skew[:, 0, 2]**2 + skew[:, 1, 0]**2) / 2
    return np.degrees(np.arctan2(sine, (np.trace(rotations, axis1=1, axis2=2) - 1) / 2))


def rpe(truth, estimate, delta, unit):
    stamps, poses = estimate
    count = len(stamps)
    if delta is None:
        first, second = (k.ravel() for k in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    else:
        steps = {"s": np.diff(stamps) * 1e-9, "frames": np.ones(count - 1),
                 "m": np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1),
                 "rad": np.radians(angles(poses[:-1, :3, :3].transpose(0, 2, 1) @ poses[1:, :3, :3]))}[unit]
        along = np.concatenate([[0], np.cumsum(steps)])
        first = np.arange(count)
        second = np.abs(along[None, :] - (along[:, None] + delta)).argmin(1)
        first, second = first[second != count - 1], second[second != count - 1]
    gaps = np.abs(truth[0][:, None] - stamps[None, :])
    nearest, limit = gaps.argmin(0), 2 * np.median(np.diff(truth[0]))
    good = gaps.min(0) <= limit
    keep = good[first] & good[second]
    first, second = first[keep], second[keep]
    inverse = np.linalg.inv
    estimated = inverse(poses[second]) @ poses[first]
    true = inverse(truth[1][nearest[second]]) @ truth[1][nearest[first]]
    error = inverse(estimated) @ true
    return len(first), statistics(np.linalg.norm(error[:, :3, 3], axis=1)), statistics(angles(error[:, :3, :3]))


def compare(name, ours, figures):
    """Lines of what differs."""
    count, translation, rotation = figures
    problems = [] if ours["pairs"] == count else [f"{name}: {ours['pairs']} pairs, expected {count}"]
    for key, expected, tolerance in (("translation_m", translation, METRES), ("rotation_deg", rotation, DEGREES)):
        for figure, value in (expected or {}).items():
            if not abs(ours[key][figure] - value) <= tolerance:
                problems.append(f"{name}: {key} {figure} is {ours[key][figure]!r}, expected {value!r}")
    return problems


def main():
    program, data = sys.argv[1], pathlib.Path(sys.argv[2]) / "trajectories"
    if not data.is_dir():
        print(f"no trajectories in {data}")
        return SKIPPED

    def plumbline(*arguments):
        out = subprocess.run([program, "eval", *map(str, arguments), "--json"], check=True, capture_output=True).stdout
        return json.loads(out)["estimates"][0]

    problems, checks = [], 0
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted((data / "rgbdslam").glob("*.txt")):
            truth_path = data / "groundtruth" / path.name
            few_path = pathlib.Path(folder) / path.name
            rows = [line for line in path.read_text().splitlines(True) if not line.startswith("#")]
            few_path.write_text("".join(rows[:FEW]))
            truth, estimate, few = read(truth_path), read(path), read(few_path)
            cases = [(("ate", truth_path, path), ate(truth, estimate)),
                     (("rpe", truth_path, few_path, "--all-pairs"), rpe(truth, few, None, None))]
            for delta, unit in ((1, "s"), (0.25, "s"), (0.3, "m"), (0.5, "rad"), (10, "frames")):
                cases.append((("rpe", truth_path, path, "--delta", delta, "--unit", unit),
                              rpe(truth, estimate, delta, unit)))
            for arguments, figures in cases:
                name = " ".join([path.stem, arguments[0], *map(str, arguments[3:])])
                found = compare(name, plumbline(*arguments), figures)
                print("differs" if found else "agrees ", name, f"rmse {figures[1]['rmse']:.6f} m, {figures[0]} pairs")
                problems += found
                checks += 1
    print(*problems, sep="\n")
    print(f"{checks} evaluations, {len(problems)} differences")
    return 1 if problems or checks == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
