#!/usr/bin/env python3
"""How often the program finds itself after an interruption, and whether it ever claims a wrong place.

    bench/kidnap.py [--cuts 10] [--seed 1] [--min 1 --max 5] [--foreign DIR ...] [-o DIR] [--jobs N] SEQUENCE ... [-- RUN OPTIONS...]

SEQUENCE is a TUM folder with groundtruth.txt, or SEQUENCE@ORIENTATION with a file of a sensor's readings. Each is run
once whole and several times without another span of 1 to 5 s, drawn from a fixed seed. What is tracked after the cut is
compared with the truth, aligned (in space, and in time by 40 ms at most) over all that was tracked before it: a frame
more than 5 cm or 3° off is wrong, if it is as far off the pose that the run without the cut has: a drift that both share
is none of the cut's.
A cut whose view after it was never seen before cannot be recovered: a cut is possible if a true pose of a frame in the
two seconds after it is within 0.5 m and 30° of one before it.

--foreign appends to every sequence the frames of another place after a pause: none of them may be tracked.
What is there already is not run again.
"""

import argparse
import bisect
import csv
import dataclasses
import json
import math
import pathlib
import random
import sys

import runs

WRONG_METRES, WRONG_DEGREES = 0.05, 3
SEEN_METRES, SEEN_DEGREES, SEEN_SECONDS = 0.5, 30, 2


def rotate(q, v):
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def conjugate(q):
    return (-q[0], -q[1], -q[2], q[3])


def unit(q):
    norm = math.sqrt(sum(c * c for c in q))
    return tuple(c / norm for c in q)


def difference(a, b):
    """Metres and degrees between two poses (t, q)."""
    angle = 2 * math.degrees(math.acos(min(1, abs(product(conjugate(a[1]), b[1])[3]))))
    return math.dist(a[0], b[0]), angle


def is_off(metres, degrees):
    return metres > WRONG_METRES or degrees > WRONG_DEGREES


class Truth:
    def __init__(self, folder):
        rows = [line.split() for line in (folder / "groundtruth.txt").read_text(encoding="utf-8").splitlines()
                if line.strip() and not line.startswith("#")]
        self.poses = [(tuple(map(float, row[1:4])), unit(tuple(map(float, row[4:8])))) for row in rows]
        self.times = [float(row[0]) for row in rows]

    def at(self, time):
        """Between two poses that are at most 0.1 s apart."""
        after = bisect.bisect_left(self.times, time)
        if after == 0 or after == len(self.times) or self.times[after] - self.times[after - 1] > 0.1:
            return self.poses[after] if after < len(self.times) and self.times[after] == time else None
        share = (time - self.times[after - 1]) / (self.times[after] - self.times[after - 1])
        (t0, q0), (t1, q1) = self.poses[after - 1], self.poses[after]
        sign = 1 if sum(a * b for a, b in zip(q0, q1)) >= 0 else -1
        return (tuple(a + share * (b - a) for a, b in zip(t0, t1)),
                unit(tuple(a + share * (sign * b - a) for a, b in zip(q0, q1))))


def truth_from_world(pairs):
    """The motion that brings tracked poses onto true ones, averaged."""
    turns = [product(true[1], conjugate(tracked[1])) for tracked, true in pairs]
    turns = [turn if sum(a * b for a, b in zip(turn, turns[0])) >= 0 else tuple(-c for c in turn) for turn in turns]
    q = unit(tuple(sum(turn[i] for turn in turns) for i in range(4)))
    moved = [rotate(q, tracked[0]) for tracked, _ in pairs]
    t = tuple(sum(true[0][i] - m[i] for m, (_, true) in zip(moved, pairs)) / len(pairs) for i in range(3))
    return t, q


def best_alignment(tracked, truth):
    """The truth's stamps may be late by some hundredths of a second, which a fast turn makes degrees of: the offset and
    the motion that fit the poses before the cut best."""
    best = (math.inf, 0, None)
    for offset in (0.005 * i for i in range(-8, 9)):
        pairs = [(pose, true) for time, pose in tracked if (true := truth.at(time + offset))]
        if len(pairs) < 10:
            continue
        world = truth_from_world(pairs)
        squares = sum(m * m + math.radians(d) ** 2
                      for m, d in (difference(compose(world, pose), true) for pose, true in pairs)) / len(pairs)
        best = min(best, (squares, offset, world))
    return best[1], best[2]


def compose(a, b):
    moved = rotate(a[1], b[0])
    return tuple(x + y for x, y in zip(a[0], moved)), product(a[1], b[1])


@dataclasses.dataclass(frozen=True)
class Cut:
    sequence: pathlib.Path
    orientation: str
    begin: float  # seconds after the first frame
    end: float
    folder: pathlib.Path
    options: tuple

    @property
    def name(self):
        return self.folder.name

    def whole(self):
        """The same recording without a cut: the same poses to the bit until the cut, so the same world."""
        return dataclasses.replace(self, begin=0, end=0, folder=self.folder.parent / (self.folder.name.rsplit("-", 2)[0] + "-whole"))

    def run(self):
        if not (self.folder / "summary.json").exists():
            span = ("--leave-out", f"{self.begin}:{self.end}") if self.end > self.begin else ()
            runs.call("run", str(self.sequence), *span, "--no-mesh", "--no-report",
                      "--quiet", "-o", str(self.folder), *(("--orientation", self.orientation) if self.orientation else ()),
                      *self.options)
        with open(self.folder / "frames.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


def believed(rows):
    """The frames that stand in trajectory.txt: a provisional one if a tracked one confirms it later."""
    kept, pending = [], []
    for row in rows:
        if row["status"] == "recovered":
            pending = [row]
        elif row["status"] == "provisional":
            pending = pending + [row]
        elif row["status"] == "lost":
            if row["reason"] in ("unknown place", "unconfirmed"):
                pending = []
        else:
            kept += pending + [row]
            pending = []
    return kept


def pose_of(row):
    return tuple(float(row[c]) for c in runs.POSE[:3]), tuple(float(row[c]) for c in runs.POSE[3:])


def measure(cut):
    """What became of one cut; None where the truth does not reach."""
    truth, rows = Truth(cut.sequence), cut.run()
    stamps = [float(line.split()[0]) for line in (cut.sequence / "depth.txt").read_text(encoding="utf-8").splitlines()
              if line.strip() and not line.startswith("#")]
    begin, end = stamps[0] + cut.begin, stamps[0] + cut.end
    kept = [(float(row["time_s"]), pose_of(row)) for row in believed(rows)]
    offset, world = best_alignment([(time, pose) for time, pose in kept if time < begin], truth)
    if world is None:
        return None
    paired = [(time, pose, truth.at(time + offset)) for time, pose in kept]
    before = [entry for entry in paired if entry[0] < begin and entry[2]]
    after = [entry for entry in paired if entry[0] >= end and entry[2]]
    uncut = {float(row["time_s"]): pose_of(row) for row in believed(cut.whole().run())}
    errors = [difference(compose(world, pose), true) for _, pose, true in after]
    off = [(time, pose) for (time, pose, _), error in zip(after, errors) if is_off(*error)]
    wrong = [time for time, pose in off if time not in uncut or is_off(*difference(pose, uncut[time]))]
    later = [float(row["time_s"]) for row in rows if float(row["time_s"]) >= end]
    seen = [time for time in later
            if (true := truth.at(time + offset)) and any(
                (d := difference(old, true))[0] < SEEN_METRES and d[1] < SEEN_DEGREES for _, _, old in before)]
    possible = bool(seen) and seen[0] < end + SEEN_SECONDS
    return {"cut": f"{cut.begin:.2f}:{cut.end:.2f}", "sequence": cut.folder.name, "possible": possible,
            "recovered": bool(after), "wrong": len(wrong), "off": len(off),
            "tracked": len(after), "frames": len(later), "worst_m": max((m for m, _ in errors), default=0),
            "worst_deg": max((d for _, d in errors), default=0),
            "frames_until": sum(seen[0] <= time < after[0][0] for time in later) if possible and after else None}


def duration(sequence):
    stamps = [float(line.split()[0]) for line in (sequence / "depth.txt").read_text(encoding="utf-8").splitlines()
              if line.strip() and not line.startswith("#")]
    return stamps[-1] - stamps[0]


def cuts_of(arguments):
    for text in arguments.sequences:
        name, _, orientation = text.partition("@")
        sequence = pathlib.Path(name).resolve()
        draw = random.Random(f"{arguments.seed} {sequence.name}")
        seconds = duration(sequence)
        longest = min(arguments.longest, 0.5 * seconds)
        for _ in range(arguments.cuts):
            length = draw.uniform(min(arguments.shortest, longest), longest)
            begin = draw.uniform(0.2 * seconds, max(0.2 * seconds, 0.95 * seconds - length))
            begin, end = round(begin, 2), round(begin + length, 2)
            sensor = "-sensor" if orientation else ""
            yield Cut(sequence, orientation, begin, end,
                      arguments.output / f"{sequence.name}{sensor}-{begin}-{end}", tuple(arguments.options))


def append_foreign(sequence, other, folder):
    """`sequence`, and after a pause of 2 s the frames of `other`."""
    (folder / "depth").mkdir(parents=True, exist_ok=True)
    def lines(path):
        return [line.split()[:2] for line in (path / "depth.txt").read_text(encoding="utf-8").splitlines()
                if line.strip() and not line.startswith("#")]
    first, second = lines(sequence), lines(other)
    start = float(first[-1][0]) + 2 - float(second[0][0])
    listed = [(float(stamp), sequence / name) for stamp, name in first]
    listed += [(float(stamp) + start, other / name) for stamp, name in second]
    for stamp, image in listed:
        link = folder / "depth" / f"{stamp:.6f}.png"
        if not link.is_symlink():
            link.symlink_to(image.resolve())
    for name in ("camera-intrinsics.txt", "camera.json", "camera.txt"):
        if (sequence / name).exists() and not (folder / name).exists():
            (folder / name).symlink_to((sequence / name).resolve())
    (folder / "depth.txt").write_text("".join(f"{stamp:.6f} depth/{stamp:.6f}.png\n" for stamp, _ in listed),
                                      encoding="utf-8")
    return float(first[-1][0]) + 1


def foreign(job):
    sequence, other, folder, options = job
    end = append_foreign(sequence, other, folder / "sequence")
    if not (folder / "summary.json").exists():
        runs.call("run", str(folder / "sequence"), "--no-mesh", "--no-report", "--quiet", "--orientation", "none", "-o",
                  str(folder), *options)
    with open(folder / "frames.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["time_s"]) > end]
    kept = believed(rows)
    provisional = sum(row["status"] == "recovered" for row in rows)
    return {"sequence": f"{sequence.name} + {other.name}", "frames": len(rows), "tracked": len(kept),
            "provisional": provisional}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="+")
    parser.add_argument("--cuts", type=int, default=10, help="of each sequence (default 10)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--min", dest="shortest", type=float, default=1, help="seconds (default 1)")
    parser.add_argument("--max", dest="longest", type=float, default=5, help="seconds (default 5)")
    parser.add_argument("--foreign", nargs="*", type=pathlib.Path, default=[], help="sequences of other places")
    arguments = runs.parse(parser, "kidnap")
    cuts = list(cuts_of(arguments))
    for whole in {cut.whole().folder: cut.whole() for cut in cuts}.values():
        whole.run()
    results = []
    for result in runs.each(measure, cuts, arguments.jobs):
        if result:
            results.append(result)
            print(json.dumps(result), flush=True)
    possible = [r for r in results if r["possible"]]
    until = sorted(r["frames_until"] for r in possible if r["frames_until"] is not None)
    jobs = [(pathlib.Path(name.partition("@")[0]).resolve(), other.resolve(),
             arguments.output / f"{pathlib.Path(name.partition('@')[0]).name}+{other.name}", tuple(arguments.options))
            for name in arguments.sequences for other in arguments.foreign
            if other.resolve() != pathlib.Path(name.partition('@')[0]).resolve()]
    places = runs.known(runs.each(foreign, jobs, arguments.jobs))
    for place in places:
        print(json.dumps(place), flush=True)
    wrong = sum(r["wrong"] > 0 for r in results)
    if results:
        print(f"{len(results)} cuts, {len(possible)} possible, {sum(r['recovered'] for r in possible)} of these recovered, "
              f"median {until[len(until) // 2] if until else '-'} frames after the view is known; {wrong} wrong")
    if places:
        print(f"{len(places)} foreign places, {sum(p['tracked'] > 0 for p in places)} accepted")
    return 1 if wrong or any(p["tracked"] for p in places) else 0


if __name__ == "__main__":
    sys.exit(main())
