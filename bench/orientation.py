#!/usr/bin/env python3
"""Presets side by side on recorded sequences, with and without an orientation sensor, as a Markdown table.

    bench/orientation.py SEQUENCE [-n FRAMES] [--stride 1,2,3,5] [--seeds 5] [-o DIR] [--jobs N] [-- RUN OPTIONS...]

The orientation is the sequence's ground truth: as it is ("ideal"), and with the error model of a BNO055 under several
seeds (mean, and the worst in brackets). A run whose summary.json is there already is not repeated. PLUMBLINE names the
program. Milliseconds are of no use with several jobs.
"""

import argparse
import pathlib
import statistics
import sys

import runs

ROWS = [("kinectfusion", "none"), ("paper", "ideal"), ("paper", "bno055"), ("plumbline", "none"),
        ("plumbline", "ideal"), ("plumbline", "bno055")]


def measure(run):
    result = run.summary()
    result["rpe"] = run.rmse("rpe")
    result["ms"] = statistics.median(float(row["total_ms"]) for row in run.frames())
    return result


def cell(values, form):
    values = runs.known(values)
    if not values:
        return "–"
    if len(values) == 1:
        return form.format(values[0])
    return f"{form.format(statistics.mean(values))} ({form.format(max(values))})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(seeds=5)
    parser.add_argument("sequence", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("-n", "--frames", type=int, default=0)
    parser.add_argument("--stride", default="1")
    arguments = runs.parse(parser, "orientation")
    rows = [(stride, preset, sensor) for stride in arguments.stride.split(",") for preset, sensor in ROWS]
    sequence, frames = arguments.sequence, str(arguments.frames)
    jobs = [runs.Run(arguments.output / f"{sequence.name}-{preset}-{sensor}-{seed}-{stride}-{frames}", sequence, preset,
                     sensor, seed, ("--stride", stride, "--max-frames", frames, *runs.volume_of(preset), *arguments.options))
            for stride, preset, sensor in rows for seed in runs.seeds_of(sensor, arguments.seeds)]
    results = runs.each(measure, jobs, arguments.jobs)
    failed = 0
    print("| stride | preset | orientation | lost | ATE RMSE (m) | RPE 1 s (m) | iterations | ms a frame |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for stride, preset, sensor in rows:
        found = [next(results) for _ in runs.seeds_of(sensor, arguments.seeds)]
        ran = runs.known(found)
        failed += len(found) - len(ran)
        frames = ran[0]["frames"] if ran else "?"
        cells = [f"{cell([r['lost'] for r in ran], '{:.0f}')} of {frames}",
                 cell([(r["ate"] or {}).get("rmse_m") for r in ran], "{:.4f}"), cell([r["rpe"] for r in ran], "{:.4f}"),
                 cell([r["mean_iterations"] for r in ran], "{:.1f}"), cell([r["ms"] for r in ran], "{:.1f}")]
        print(f"| {stride} | {preset} | {sensor} | {' | '.join(cells)} |", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
