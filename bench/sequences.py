#!/usr/bin/env python3
"""Real hand motion through simulated scenes: presets with and without an orientation sensor, as Markdown tables.

    bench/sequences.py [--scenes desk,room] [--speeds 1,2] [--frames 300] [--paths NAME,...] [--rows PRESET:SENSOR,...]
                       [--seeds 5] [--surface] [--sequences DIR] [-o DIR] [--jobs N] [-- RUN OPTIONS...]

The paths are those of shared/data beside the checkout, or PLUMBLINE_DATA. What is there already, sequences and runs, is
not made again. The orientation is the sequence's ground truth: as it is ("ideal"), and with the error model of a BNO055
under several seeds. A run has one thread.

ATE here is over all frames: a lost one counts with the previous accepted pose. Over the tracked frames alone, as
summary.json has it, a run that loses most of its frames looks good.
"""

import argparse
import dataclasses
import json
import os
import pathlib
import statistics
import sys

import runs

DATA = pathlib.Path(os.environ.get("PLUMBLINE_DATA", runs.ROOT.parent / "shared" / "data"))
PATHS = DATA / "trajectories" / "groundtruth"
BASELINE = "kinectfusion:none"
ROWS = [BASELINE, "plumbline:none", "plumbline:ideal", "plumbline:bno055", "paper:ideal", "paper:bno055"]


@dataclasses.dataclass(frozen=True)
class Sequence:
    scene: str
    path: str
    speed: str
    frames: int
    folder: pathlib.Path

    @property
    def name(self):
        return f"{self.scene}-{self.path}-{self.speed}"

    def simulate(self):
        if not (self.folder / "depth.txt").exists():  # which is written last
            runs.call("simulate", "--scene", self.scene, "--trajectory", str(PATHS / f"{self.path}.txt"),
                      "--speed", self.speed, "--frames", str(self.frames), "--no-color", "--quiet", "--threads", "1",
                      "-o", str(self.folder))
        return self


def sequences_of(arguments):
    paths = [name.removesuffix(".txt") for name in arguments.paths] or sorted(file.stem for file in PATHS.glob("*.txt"))
    if not paths:
        sys.exit(f"sequences: no trajectories in {PATHS}; PLUMBLINE_DATA names their data folder")
    for scene in arguments.scenes:
        for speed in arguments.speeds:
            for path in paths:
                folder = arguments.output / f"sequence-{scene}-{path}-{speed}-{arguments.frames}"
                given = arguments.sequences and arguments.sequences / f"{scene}-{path}-{speed}"
                yield Sequence(scene, path, speed, arguments.frames,
                               given if given and (given / "depth.txt").exists() else folder)


def runs_of(sequence, row, arguments):
    preset, sensor = row.split(":")
    options = ("--threads", "1", "--max-frames", str(arguments.frames), *runs.volume_of(preset), *arguments.options)
    name = f"{sequence.name}-{arguments.frames}-{preset}-{sensor}"
    return [runs.Run(arguments.output / f"{name}-{seed}", sequence.folder, preset, sensor, seed, options,
                     arguments.surface) for seed in runs.seeds_of(sensor, arguments.seeds)]


def surface(run):
    """Distances from the mesh to the true surface in metres, the run's trajectory brought onto the true one."""
    file, mesh = run.folder / "surface.json", run.folder / "mesh.ply"
    if not file.exists() or file.stat().st_mtime < mesh.stat().st_mtime:
        file.write_text(runs.call("eval", "surface", str(mesh), str(run.sequence / "scene.ply"), "--trajectory",
                                  str(run.folder / "trajectory.txt"), "--samples", "50000", "--json"), encoding="utf-8")
    return json.loads(file.read_text(encoding="utf-8"))["accuracy_m"]


def measure(run):
    result = run.summary()
    result["ate_all"] = run.rmse("ate", run.write_all_frames())
    if result["ate_all"] is None:
        raise runs.Failure("no ATE over all frames")
    result["inliers"] = run.median_inliers()
    result["surface"] = None
    if run.mesh:
        try:
            result["surface"] = surface(run)
        except (runs.Failure, OSError, ValueError) as error:
            print(f"{run.name}: no surface: {error}", file=sys.stderr, flush=True)
    return result


@dataclasses.dataclass
class Cell:
    """Of one sequence and one row: a result for each seed, None for a run that failed."""

    results: list

    def figures(self, figure):
        return runs.known(figure(result) for result in runs.known(self.results))

    @property
    def complete(self):
        return bool(self.results) and None not in self.results

    @property
    def ate(self):
        return statistics.mean(self.figures(lambda r: r["ate_all"]))

    @property
    def lost(self):
        return statistics.mean(self.figures(lambda r: r["lost"]))

    def ate_text(self):
        ates = self.figures(lambda r: r["ate_all"])
        failed = f", {len(self.results) - len(ates)} failed" if ates and not self.complete else ""
        if not ates:
            return "failed"
        if len(ates) == 1:
            return f"{ates[0]:.4f} ({self.lost:.0f}{failed})"
        return f"{self.ate:.4f} ± {statistics.stdev(ates):.4f}, worst {max(ates):.4f} ({self.lost:.1f}{failed})"

    def surface_text(self):
        found = self.figures(lambda r: r["surface"])
        inliers = self.figures(lambda r: r["inliers"])
        if not found:
            return "–"
        mean, median = (1e3 * statistics.mean(f[key] for f in found) for key in ("mean", "median"))
        return f"{mean:.1f} / {median:.1f}" + (f" ({100 * statistics.mean(inliers):.0f})" if inliers else "")


def line(*cells):
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def head(*cells):
    line(*cells)
    print("|---" * len(cells) + "|", flush=True)


def label(sequence):
    return sequence.scene, sequence.path.replace("freiburg", "fr"), sequence.speed


def aggregate(name, table, rows):
    """Each row against the baseline, over the sequences where all runs of both came to their end."""
    for row in rows:
        both = [cells for cells in table.values() if cells[row].complete and cells[BASELINE].complete]
        if not both:
            line(name, row, f"0 of {len(table)}", *"–" * 6)
            continue
        ates = [(cells[row].ate, cells[BASELINE].ate) for cells in both]
        mine, theirs = (statistics.mean(column) for column in zip(*ates))
        against = [f"{mine / theirs:.3f}", f"{statistics.mean(a / b for a, b in ates):.3f}",
                   f"{sum(a < b for a, b in ates)} / {sum(a > b for a, b in ates)}"] if row != BASELINE else ["–"] * 3
        frames = sum(cells[row].results[0]["frames"] for cells in both)
        line(name, row, f"{len(both)} of {len(table)}", f"{mine:.4f}", f"{theirs:.4f}", *against,
             f"{sum(cells[row].lost for cells in both):.1f} of {frames}")


def print_aggregates(table, rows):
    print(f"\nAgainst `{BASELINE}`, over the sequences where all runs of both came to their end. Ratio of means: sum "
          "of ATE by sum of ATE.\n")
    head("scene, speed", "preset:sensor", "sequences", "mean ATE (m)", "baseline's (m)", "ratio of means",
         "mean of ratios", "better / worse", "lost")
    groups = list(dict.fromkeys((sequence.scene, sequence.speed) for sequence in table))
    for group in groups:
        aggregate(", ".join(group), {s: cells for s, cells in table.items() if (s.scene, s.speed) == group}, rows)
    if len(groups) > 1:
        aggregate("all", table, rows)


def names(text):
    return [name for name in text.split(",") if name]


def row_names(text):
    for name in names(text):
        if name not in ROWS:
            raise argparse.ArgumentTypeError(f"'{name}' is none of {', '.join(ROWS)}")
    return names(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(seeds=5)
    parser.add_argument("--scenes", type=names, default="desk,room")
    parser.add_argument("--speeds", type=names, default="1,2")
    parser.add_argument("--frames", type=int, default=300,
                        help="the first so many of each sequence, 0 for all (default 300)")
    parser.add_argument("--paths", type=names, default="", help="names of trajectories (default: all)")
    parser.add_argument("--rows", type=row_names, default=",".join(ROWS[:-1]),
                        help=f"of {','.join(ROWS)} (default: not the last)")
    parser.add_argument("--surface", action="store_true", help="also extract the mesh and compare it with the scene")
    parser.add_argument("--sequences", type=lambda text: pathlib.Path(text).resolve(), metavar="DIR",
                        help="folder that has sequences already, as SCENE-PATH-SPEED")
    arguments = runs.parse(parser, "sequences")
    rows = arguments.rows

    wanted = list(sequences_of(arguments))
    sequences = runs.known(runs.each(Sequence.simulate, wanted, arguments.jobs))
    jobs = [(sequence, row, runs_of(sequence, row, arguments)) for sequence in sequences for row in rows]
    results = runs.each(measure, [run for _, _, some in jobs for run in some], arguments.jobs)
    options = f", `{' '.join(arguments.options)}`" if arguments.options else ""
    print("ATE RMSE in m over all frames, a lost one with the previous accepted pose; lost frames in brackets. "
          f"bno055: mean ± standard deviation over seeds 1 to {arguments.seeds}, the worst, and the mean of the lost. "
          f"`plumbline` in its own volume, the others with `{' '.join(runs.PAPERS_VOLUME)}`{options}.\n")
    head("scene", "path", "speed", "frames", *rows)
    table = {}
    for sequence in sequences:
        cells = {}
        for row in rows:
            cells[row] = Cell([next(results) for _ in runs.seeds_of(row.split(":")[1], arguments.seeds)])
        table[sequence] = cells
        frames = next((f for cell in cells.values() for f in cell.figures(lambda r: r["frames"])), "?")
        line(*label(sequence), frames, *(cell.ate_text() for cell in cells.values()))
    if arguments.surface:
        print("\nDistance from the mesh to the true surface, mean / median in mm; matched share of the readings in "
              "brackets (%, median of the tracked frames).\n")
        head("scene", "path", "speed", *rows)
        for sequence, cells in table.items():
            line(*label(sequence), *(cell.surface_text() for cell in cells.values()))
    if BASELINE in rows and len(rows) > 1:
        print_aggregates(table, rows)

    failed = [sequence.name for sequence in wanted if sequence not in table]
    failed += [run.name for sequence, row, some in jobs for run, result in zip(some, table[sequence][row].results)
               if result is None]
    if failed:
        print(f"\nFailed: {', '.join(failed)}.")
        sys.exit(1)


if __name__ == "__main__":
    main()
