#!/usr/bin/env python3
"""What the correction of a path's drift changes, and whether any loop that it accepts is false.

    bench/loops.py [-o DIR] [--on] SEQUENCE ... [-- RUN OPTIONS...]

SEQUENCE is a folder with a ground truth, or SEQUENCE@OPTIONS with more options for `plumbline run`, in one word
with commas ("floor@--set,volume.side=20"). Each is run without and with the automatic correction, and with
--on where loops were accepted and nothing was corrected, to see what that would have been. A loop is false
if its motion is more than 5 cm or 2.5° from the true one; of a motion capture whose clock is off by up to 60 ms the poses
are taken where it turned as the tracked camera did. `same` says that an automatic run that corrected nothing has the
trajectory of the run without to the byte.
What is there already is not run again.
"""

import argparse
import bisect
import json
import math
import pathlib
import re
import statistics
import sys

import runs

FALSE_METRES, FALSE_DEGREES = 0.05, 2.5


def product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def rotate(q, v):
    return product(product(q, (*v, 0)), (-q[0], -q[1], -q[2], q[3]))[:3]


def relative(a, b):
    """a_from_b of two poses (t, q) in one world."""
    back = (-a[1][0], -a[1][1], -a[1][2], a[1][3])
    return rotate(back, [y - x for x, y in zip(a[0], b[0])]), product(back, b[1])


def apart(a, b):
    """Metres and degrees between two motions (t, q)."""
    turn = product((-a[1][0], -a[1][1], -a[1][2], a[1][3]), b[1])
    return math.dist(a[0], b[0]), 2 * math.degrees(math.atan2(math.hypot(*turn[:3]), abs(turn[3])))


def read_poses(path):
    rows = (line.split() for line in path.read_text(encoding="utf-8").splitlines() if line and line[0] != "#")
    return [(float(r[0]), tuple(map(float, r[1:4])), tuple(map(float, r[4:8]))) for r in rows]


class Truth:
    def __init__(self, poses, offset):
        self.poses, self.offset = poses, offset
        self.times = [p[0] for p in poses]

    def at(self, time):
        time += self.offset
        i = bisect.bisect_left(self.times, time)
        if i > 0 and (i == len(self.times) or time - self.times[i - 1] < self.times[i] - time):
            i -= 1
        return self.poses[i][1:] if abs(self.times[i] - time) < 0.05 else None


def frame_times(folder):
    """Index of a frame in the sequence to its time."""
    lines = (folder / "frames.csv").read_text(encoding="utf-8").splitlines()
    header = lines[0].split(",")
    index, time = header.index("index"), header.index("time_s")
    return {int(r[index]): float(r[time]) for r in (line.split(",") for line in lines[1:])}


def best_offset(truth_poses, tracked):
    """Seconds by which the truth's clock is ahead: where it turns over half a second as the tracked camera did."""
    every = max(1, len(tracked) // 200)
    pairs = [(a, b) for a, b in zip(tracked[::every], tracked[10::every]) if b[0] - a[0] < 2]

    def difference(offset):
        truth = Truth(truth_poses, offset)
        found = [(truth.at(a[0]), truth.at(b[0]), a, b) for a, b in pairs]
        turns = [apart(relative(a[1:], b[1:]), relative(ta, tb))[1] for ta, tb, a, b in found if ta and tb]
        return statistics.median(turns) if turns else math.inf

    return min((step / 200 for step in range(-12, 13)), key=lambda offset: (difference(offset), abs(offset)))


def false_loops(folder, summary):
    path = summary["ate"] and pathlib.Path(summary["ate"]["groundtruth"])
    if not path or not path.is_file() or not summary["loops"]:
        return None
    try:
        poses = read_poses(path)
    except (ValueError, IndexError):
        return None  # another format
    offset = best_offset(poses, read_poses(folder / "trajectory.txt"))
    truth, times, false = Truth(poses, offset), frame_times(folder), 0
    for loop in summary["loops"]["accepted"]:
        a, b = (truth.at(times[i]) for i in loop["frames"])
        motion = loop["first_from_second"]
        metres, degrees = apart((motion[:3], motion[3:]), relative(a, b)) if a and b else (0, 0)
        false += metres > FALSE_METRES or degrees > FALSE_DEGREES
    return false


def run(sequence, options, mode, output):
    folder = output / re.sub(r"[^\w.=-]+", "_", " ".join([pathlib.Path(sequence).name, *options])) / mode
    if not (folder / "summary.json").is_file():
        runs.call("run", str(sequence), "-o", str(folder), "--no-mesh", "--no-report", "--quiet", "--global", mode,
                  *options)
    return folder, json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def ate(summary):
    return f"{summary['ate']['rmse_m']:.4f}" if summary["ate"] and "rmse_m" in summary["ate"] else "–"


def row(sequence, options, with_on, output):
    off_folder, off = run(sequence, options, "off", output)
    folder, auto = run(sequence, options, "auto", output)
    loops = auto["loops"]
    is_open = loops["accepted"] and not loops["applied"]
    on = run(sequence, options, "on", output)[1] if with_on and is_open else (auto if loops["applied"] else off)
    same = (off_folder / "trajectory.txt").read_bytes() == (folder / "trajectory.txt").read_bytes()
    false = false_loops(folder, auto)
    return [" ".join([pathlib.Path(sequence).name, *options]), str(off["tracked"]), str(off["lost"]), ate(off),
            ate(auto), ate(on) if with_on or not is_open else "–", str(loops["tried"]), str(len(loops["accepted"])), "–" if false is None else str(false),
            f"{loops['disagreement_before']:.2f}",
            "corrected" if loops["applied"] else ("same; " if same else "NOT THE SAME; ") + loops["note"],
            f"{1000 * loops['wall_s'] / max(1, off['frames']):.1f}"]


def main():
    words = sys.argv[1:]
    common = words[words.index("--") + 1:] if "--" in words else []
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("loops"))
    parser.add_argument("--on", action="store_true")
    parser.add_argument("sequences", nargs="+")
    arguments = parser.parse_args(words[:words.index("--")] if "--" in words else words)
    print("| sequence | tracked | lost | ATE off | auto | on | tried | accepted | false | D | | ms a frame |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    failed = False
    for word in arguments.sequences:
        sequence, _, own = word.partition("@")
        options = common + [w for w in own.split(",") if w]
        try:
            cells = row(sequence, options, arguments.on, arguments.output)
        except runs.Failure as failure:
            cells, failed = [sequence, "failed: " + " ".join(str(failure).split())], True
        print("| " + " | ".join(cells) + " |", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
