#!/usr/bin/env python3
"""Whether the verdict of a run, made without the truth, follows the true error.

    bench/verdict.py [--seeds 2] [--duration 6] [--size 320x240] [-o DIR] [--jobs N] [-- RUN OPTIONS...]

Simulated scenes, slow and fast, are run as they are and with what goes wrong for people: another camera's intrinsics, a
scale that is off, missing frames, interruptions, noise, a bare wall. The error is that of all frames (a lost one has the
previous accepted pose). Prints a row a run, Spearman's rank correlation between `verdict.doubt` of summary.json and the
error, the same for each piece of evidence, and how far off the runs of each level are. What is there already is not run
again.
"""

import argparse
import json
import pathlib
import shutil
import statistics
import sys

import runs

SCENES = (("desk", "orbit"), ("desk", "handheld"), ("room", "sweep"), ("room", "dance"), ("kitchen", "handheld"),
          ("corridor", "sweep"), ("teddy", "orbit"))
SPEEDS = (1, 3)
FOCAL_320 = 262.5  # of a Kinect at 320x240, pixels
HARM = {
    "as_is": (),
    "wide_lens": ("--intrinsics", "{f85},{f85},{cx},{cy}"),
    "long_lens": ("--intrinsics", "{f130},{f130},{cx},{cy}"),
    "centre_off": ("--intrinsics", "{f},{f},{cx_off},{cy}"),
    "scale_off": ("--depth-scale", "3500"),
    "every_4th": ("--stride", "4"),
    "interrupted": ("--leave-out", "1:1.6", "--leave-out", "2:2.3"),
    "no_recovery": ("--leave-out", "1:1.6", "--set", "tracking.relocalise_after=0"),
}
TRUTH = "truth.txt"  # not a name that the program looks for
GOOD_ERROR, POOR_ERROR = 0.05, 0.20  # metres, as docs/method.md has them


def write_wall(path):
    """Nothing but a wall, 6 m wide, 3 m high, with one shelf at its far end."""
    boxes = [((-3, 2.0, 0), (3, 2.1, 3)), ((2.2, 1.8, 1.0), (2.8, 2.0, 1.3))]
    corners, faces = [], []
    for low, high in boxes:
        base = len(corners)
        corners += [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            faces += [(base + a, base + b, base + c), (base + a, base + c, base + d)]
    with open(path, "w", encoding="utf-8") as out:
        for corner in corners:
            print("v", *corner, file=out)
        for face in faces:
            print("f", *(i + 1 for i in face), file=out)


def simulated(arguments, scene, path, speed, seed):
    folder = arguments.output / f"{pathlib.Path(scene).stem}-{path}-{speed}-{seed}"
    if not (folder / TRUTH).exists():
        shutil.rmtree(folder, ignore_errors=True)
        runs.call("simulate", "--scene", scene, "--trajectory", path, "--speed", str(speed), "--duration",
                  str(arguments.duration), "--seed", str(seed), "--size", arguments.size, "--quiet", "--no-color", "-o",
                  str(folder))
        (folder / "groundtruth.txt").rename(folder / TRUTH)
    return folder


class BlindRun(runs.Run):
    """A run that is not told the truth."""

    @property
    def truth(self):
        return self.sequence / TRUTH


class Case:
    def __init__(self, folder, harm, options, arguments):
        self.name = f"{folder.name}-{harm}"
        self.harm = harm
        self.run = BlindRun(arguments.output / "runs" / self.name, folder, "plumbline",
                            options=("--orientation", "none", "--no-report", *options, *arguments.options))


def cases_of(arguments):
    width, height = map(int, arguments.size.split("x"))
    f, cx, cy = FOCAL_320 * width / 320, (width - 1) / 2, (height - 1) / 2
    numbers = {"f": f, "f85": 0.85 * f, "f130": 1.3 * f, "cx": cx, "cy": cy, "cx_off": 1.25 * cx}
    wall = str(arguments.output / "wall.obj")
    write_wall(wall)
    for seed in range(1, arguments.seeds + 1):
        for scene, path in (*SCENES, (wall, "sweep")):
            for speed in SPEEDS:
                folder = simulated(arguments, scene, path, speed, seed)
                for harm, options in HARM.items():
                    yield Case(folder, harm, tuple(word.format(**numbers) for word in options), arguments)


def measure(case):
    try:
        summary = case.run.summary()
    except runs.Failure as failure:
        return {"name": case.name, "refused": str(failure).splitlines()[0]}
    error = case.run.rmse("ate", case.run.write_all_frames())
    if error is None:
        return {"name": case.name, "refused": "too few poses"}
    verdict = summary["verdict"]
    return {"name": case.name, "error": error, "level": verdict["level"], "doubt": verdict["doubt"],
            "evidence": verdict["evidence"]}


def ranks(values):
    """Mean ranks of equal values."""
    order = sorted(range(len(values)), key=values.__getitem__)
    result, i = [0.0] * len(values), 0
    while i < len(order):
        j = i
        while j + 1 < len(order) and values[order[j + 1]] == values[order[i]]:
            j += 1
        for k in range(i, j + 1):
            result[order[k]] = (i + j) / 2
        i = j + 1
    return result


def spearman(a, b):
    a, b = ranks(a), ranks(b)
    if len(set(a)) < 2 or len(set(b)) < 2:
        return 0.0
    return statistics.correlation(a, b)


def report(rows):
    errors = [row["error"] for row in rows]
    print(f"\n{len(rows)} runs; rank correlation of doubt and error: {spearman([r['doubt'] for r in rows], errors):.3f}")
    for name in rows[0]["evidence"]:
        print(f"  {name:20s} {spearman([row['evidence'][name] for row in rows], errors):6.3f}")
    for level in ("good", "fair", "poor"):
        found = sorted(row["error"] for row in rows if row["level"] == level)
        if found:
            print(f"{level:5s} {len(found):4d} runs: error median {statistics.median(found):.3f}, 90 % {found[int(0.9 * (len(found) - 1))]:.3f}, "
                  f"worst {found[-1]:.3f} m; over {GOOD_ERROR} m: {sum(e > GOOD_ERROR for e in found)}, over {POOR_ERROR} m: {sum(e > POOR_ERROR for e in found)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(seeds=1)
    parser.add_argument("--duration", type=float, default=6, help="seconds of a path that is not played faster (default 6)")
    parser.add_argument("--size", default="320x240", help="of the images (default 320x240)")
    parser.add_argument("--json", action="store_true", help="the rows as JSON, for a closer look")
    arguments = runs.parse(parser, "verdict")
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for row in runs.each(measure, list(cases_of(arguments)), arguments.jobs):
        if row is None:
            continue
        if "refused" in row:
            print(f"{row['name']:44s} refused: {row['refused'][:90]}", flush=True)
            continue
        rows.append(row)
        print(f"{row['name']:44s} {row['error']:7.4f} m  {row['level']:5s} {row['doubt']:.2f}", flush=True)
    if not rows:
        sys.exit("no run came to its end")
    if arguments.json:
        (arguments.output / "verdict.json").write_text(json.dumps(rows, indent=1), encoding="utf-8")
    report(rows)


if __name__ == "__main__":
    main()
