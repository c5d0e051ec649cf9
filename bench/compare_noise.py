#!/usr/bin/python3
"""Simulated against real depth: noise, holes and registration of two or more sequences side by side, as Markdown.

    bench/compare_noise.py [--frames N] [--step K] NAME=SEQUENCE[,RUN] ...

SEQUENCE is a TUM folder (depth.txt, 5000 readings a metre), RUN a folder that `plumbline run` wrote for it (frames.csv).
Depth: residual of the best plane through windows whose pixels all have a reading. A plane is linear in 1/z over the
image; the residual's standard deviation is given in millimetres at the window's depth. The median over all windows of a
depth holds edges and curved things back, but not wholly: compare columns of like scenes. The lower quartile is nearest to the
sensor alone. Windows of 15 pixels show the noise, those of 61 also what bends slowly over the image.
"""
import argparse
import csv
import os
import sys

import numpy as np
from PIL import Image

READINGS_PER_METRE = 5000.0
DEPTH_BINS = [(0.6, 0.8), (0.8, 1.0), (1.0, 1.25), (1.25, 1.5), (1.5, 2.0), (2.0, 2.5), (2.5, 3.0)]
WINDOWS = [15, 61]
LAGS = [1, 2, 4, 6, 8]
FEWEST_WINDOWS = 20


def depth_files(folder):
    with open(os.path.join(folder, "depth.txt"), encoding="utf-8") as lines:
        rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    return [os.path.join(folder, row[1]) for row in rows]


def read_depth(path):
    return np.asarray(Image.open(path), dtype=np.float64) / READINGS_PER_METRE


def windows_of(z, size):
    """All full windows on a grid half a window apart, as rows of size² pixels."""
    step = max(size // 2, 1)
    view = np.lib.stride_tricks.sliding_window_view(z, (size, size))[::step, ::step]
    flat = view.reshape(-1, size * size)
    return flat[np.all(flat > 0, axis=1)]


def plane_residuals(flat, size):
    """Metres along the line of sight, and each window's mean depth."""
    y, x = np.mgrid[0:size, 0:size] - (size - 1) / 2
    basis = np.stack([np.ones(size * size), x.ravel(), y.ravel()], axis=1)
    basis, _ = np.linalg.qr(basis)
    inverse = 1 / flat
    residual = inverse - (inverse @ basis) @ basis.T
    depth = 1 / inverse.mean(axis=1)
    return residual * depth[:, None] ** 2, depth


def correlation(residuals, size):
    """Of residuals `lag` pixels apart along the rows, pooled over windows."""
    field = residuals.reshape(-1, size, size)
    variance = np.mean(field**2)
    return [np.mean(field[:, :, lag:] * field[:, :, :-lag]) / variance for lag in LAGS]


def hole_rates(z):
    """Share without a reading; and of those the share in regions larger than a few pixels (the middle of a 9×9 window
    that holds no reading at all): out of range, shadow and glass, where the rest is edges and grain."""
    empty = z <= 0
    sums = np.cumsum(np.cumsum(np.pad(empty.astype(np.int32), ((1, 0), (1, 0))), axis=0), axis=1)
    n = 9
    count = sums[n:, n:] - sums[:-n, n:] - sums[n:, :-n] + sums[:-n, :-n]
    return empty.mean(), (count == n * n).mean()


def measure(folder, frames, step):
    files = depth_files(folder)[:frames:step]
    if not files:
        sys.exit(f"compare_noise: {folder}: depth.txt names no images")
    sigma = {size: ([], []) for size in WINDOWS}
    smooth, holes = [], []
    for path in files:
        z = read_depth(path)
        holes.append(hole_rates(z))
        for size in WINDOWS:
            flat = windows_of(z, size)
            if not len(flat):
                continue
            residuals, depth = plane_residuals(flat, size)
            deviation = residuals.std(axis=1)
            sigma[size][0].append(depth)
            sigma[size][1].append(deviation)
            if size == WINDOWS[0]:
                smooth.append((residuals, depth, deviation))
    result = {"holes": np.mean(holes, axis=0)}
    for size in WINDOWS:
        depth, deviation = (np.concatenate(list_) if list_ else np.zeros(0) for list_ in sigma[size])
        for low, high in DEPTH_BINS:
            inside = deviation[(depth >= low) & (depth < high)]
            quantiles = np.quantile(inside, [0.25, 0.5]) * 1e3 if len(inside) >= FEWEST_WINDOWS else [np.nan] * 2
            result[size, low] = (*quantiles, len(inside))
    # Correlation of the windows that are planes: the half with the smaller residual, around 1 to 2 m.
    chosen = []
    for residuals, depth, deviation in smooth:
        near = (depth > 0.8) & (depth < 2)
        if near.any():
            chosen.append(residuals[near & (deviation <= np.median(deviation[near]))])
    result["correlation"] = correlation(np.concatenate(chosen), WINDOWS[0]) if chosen else [np.nan] * len(LAGS)
    return result


def registration(run, frames):
    with open(os.path.join(run, "frames.csv"), newline="", encoding="utf-8") as rows:
        rows = [row for row in csv.DictReader(rows)][:frames]
    tracked = [row for row in rows if row["status"] == "tracked"]
    median = {key: np.median([float(row[key]) for row in tracked]) for key in ("inlier_fraction", "rms_m", "median_distance_m")}
    return len(rows) - sum(row["status"] != "lost" for row in rows), median


def parse(argument):
    name, _, paths = argument.partition("=")
    sequence, _, run = paths.partition(",")
    if not sequence:
        sys.exit(f"compare_noise: '{argument}': give NAME=SEQUENCE[,RUN]")
    return name, sequence, run


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=150, help="look at so many of the first frames (default 150)")
    parser.add_argument("--step", type=int, default=5, help="every K-th of them (default 5)")
    parser.add_argument("sequences", nargs="+", metavar="NAME=SEQUENCE[,RUN]")
    arguments = parser.parse_args()
    inputs = [parse(text) for text in arguments.sequences]
    results = [measure(sequence, arguments.frames, arguments.step) for _, sequence, _ in inputs]
    runs = [registration(run, arguments.frames) if run else None for _, _, run in inputs]

    def row(label, cells):
        print(f"| {label} | " + " | ".join(cells) + " |")

    row("", [name for name, _, _ in inputs])
    print("|---" * (len(inputs) + 1) + "|")
    for size in WINDOWS:
        for low, high in DEPTH_BINS:
            cells = [r[size, low] for r in results]
            row(f"plane residual, {size}×{size} px, {low:g}–{high:g} m: quartile / median, mm",
                ["–" if np.isnan(c[0]) else f"{c[0]:.2f} / {c[1]:.2f} ({c[2]})" for c in cells])
    row("its correlation at " + ", ".join(map(str, LAGS)) + " px", [" ".join(f"{c:.2f}" for c in r["correlation"]) for r in results])
    row("pixels without a reading, %", [f"{100 * r['holes'][0]:.1f}" for r in results])
    row("… in the middle of 9×9 px without any, %", [f"{100 * r['holes'][1]:.1f}" for r in results])
    if any(runs):
        row("lost frames", ["–" if r is None else str(r[0]) for r in runs])
        row("ICP inliers, % of the readings (median)", ["–" if r is None else f"{100 * r[1]['inlier_fraction']:.1f}" for r in runs])
        row("ICP point-to-plane rms, mm (median)", ["–" if r is None else f"{1e3 * r[1]['rms_m']:.2f}" for r in runs])
        row("ICP closest-point distance, mm (median of medians)", ["–" if r is None else f"{1e3 * r[1]['median_distance_m']:.2f}" for r in runs])


if __name__ == "__main__":
    main()
