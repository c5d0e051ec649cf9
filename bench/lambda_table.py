#!/usr/bin/env python3
"""The damping's schedule and factor (preset `paper`, orientation.schedule and orientation.lambda), as a Markdown table.

    bench/lambda_table.py SEQUENCE... [--frames N] [--seeds 1] [-o DIR] [--jobs N] [-- RUN OPTIONS...]

The orientation is the sequence's ground truth: as it is ("ideal"), and with the error model of a BNO055. Means over all
sequences (and seeds), in the volume of bench/sequences.py; the best of each sensor is bold. ATE and RPE (1 s) are over
all frames: a lost one counts with the last pose that was believed.
"""

import argparse
import pathlib
import statistics
import sys

import runs

SCHEDULES = ["constant", "inverse_sqrt", "inverse", "inverse_square", "negative_log"]
FACTORS = ["0.05", "0.2", "1", "2", "5"]
SENSORS = ["ideal", "bno055"]


def measure(run):
    summary = run.summary()
    trajectory = run.write_all_frames()
    result = {"ate": run.rmse("ate", trajectory), "rpe": run.rmse("rpe", trajectory), "lost": summary["lost"],
              "frames": summary["frames"]}
    if result["ate"] is None:
        raise runs.Failure("no ATE over all frames")
    return result


def runs_of(sensor, schedule, factor, arguments):
    options = ("--threads", "1", "--max-frames", str(arguments.frames), *runs.PAPERS_VOLUME, "--set",
               f"orientation.schedule={schedule}", "--set", f"orientation.lambda={factor}", *arguments.options)
    name = f"{arguments.frames}-{schedule}-{factor}-{sensor}"
    return [runs.Run(arguments.output / f"{sequence.name}-{name}-{seed}", sequence, "paper", sensor, seed, options)
            for sequence in arguments.sequences for seed in runs.seeds_of(sensor, arguments.seeds)]


def mean(results, key):
    """None if a run failed, so that what is hard is never left out of a mean. RPE needs more than a second."""
    if None in results:
        return None
    values = runs.known(result[key] for result in results)
    return statistics.mean(values) if len(values) == len(results) else None


def print_table(sensor, rows, seeds):
    figures = [{key: mean(results, key) for key in ("ate", "rpe")} for _, _, results in rows]
    best = {key: min(runs.known(f[key] for f in figures), default=None) for key in ("ate", "rpe")}
    for (schedule, factor, results), means in zip(rows, figures):
        cells = []
        for key, value in means.items():
            text = "–" if value is None else f"{value:.4f}"
            cells.append(f"**{text}**" if value is not None and value == best[key] else text)
        ran = runs.known(results)
        lost = f"{sum(r['lost'] for r in ran) / seeds:g} of {sum(r['frames'] for r in ran) / seeds:g}"
        failed = f", {len(results) - len(ran)} runs failed" if len(ran) < len(results) else ""
        print(f"| {sensor} | {schedule} | {factor} | {' | '.join(cells)} | {lost}{failed} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(seeds=1)
    parser.add_argument("sequences", nargs="+", type=lambda text: pathlib.Path(text).resolve(), metavar="SEQUENCE")
    parser.add_argument("--frames", type=int, default=0, help="the first so many of each sequence, 0 for all (default)")
    arguments = runs.parse(parser, "lambda")
    if len({sequence.name for sequence in arguments.sequences}) < len(arguments.sequences):
        sys.exit("lambda_table: two sequences have the same name")

    settings = [(sensor, schedule, factor) for sensor in SENSORS for schedule in SCHEDULES for factor in FACTORS]
    jobs = {setting: runs_of(*setting, arguments) for setting in settings}
    results = runs.each(measure, [run for some in jobs.values() for run in some], arguments.jobs)
    print(f"Means over {', '.join(sequence.name for sequence in arguments.sequences)}; all frames, a lost one with the "
          f"last pose that was believed; bno055: seeds 1 to {arguments.seeds}.\n")
    print("| sensor | schedule | c | ATE RMSE (m) | RPE 1 s (m) | lost |")
    print("|---|---|---|---|---|---|", flush=True)
    failed = []
    for sensor in SENSORS:
        rows = []
        for setting in settings:
            if setting[0] == sensor:
                found = [next(results) for _ in jobs[setting]]
                failed += [run.name for run, result in zip(jobs[setting], found) if result is None]
                rows.append((*setting[1:], found))
        print_table(sensor, rows, len(runs.seeds_of(sensor, arguments.seeds)))
    if failed:
        print(f"\nFailed: {', '.join(failed)}.")
        sys.exit(1)


if __name__ == "__main__":
    main()
