"""What the scripts of this folder share: runs of the program that are made once, side by side, and their figures.

A run is finished when its folder holds a summary.json of a run that came to its end; it is not repeated then. If that
summary names another command, the run counts as failed: figures of other options are never taken for these. PLUMBLINE
names the program.
"""

import concurrent.futures
import csv
import dataclasses
import json
import os
import pathlib
import shlex
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = os.environ.get("PLUMBLINE", str(ROOT / "build" / "release" / "plumbline"))
POSE = ("tx", "ty", "tz", "qx", "qy", "qz", "qw")
# The placement of the volume decides as much as the method (docs/method.md §6.5). The published presets have the paper's 6 m
# with the camera inside; in the 8 m that `plumbline` has by default their 3 cm of truncation are two voxels, and they do
# worse on a desk (docs/results.md).
PAPERS_VOLUME = ("--set", "volume.side=6", "--set", "volume.offset=-0.4")


def volume_of(preset):
    """Options of `plumbline run` that place the volume."""
    return () if preset == "plumbline" else PAPERS_VOLUME


def sensor_options(truth, sensor, seed):
    """Options of `plumbline` for an orientation sensor that reads a trajectory; "none" has none."""
    if sensor == "none":
        return []
    return ["--orientation", str(truth), "--orientation-max-gap", "0.5", "--imu-model", sensor, "--imu-seed", str(seed)]


class Failure(Exception):
    """What the program said when it could not do its work."""


def call(*words):
    done = subprocess.run([PROGRAM, *words], check=False, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failure(done.stderr.strip() or f"exit code {done.returncode}")
    return done.stdout


@dataclasses.dataclass(frozen=True)
class Run:
    """One run of the program. A sensor takes its readings from the sequence's ground truth."""

    folder: pathlib.Path
    sequence: pathlib.Path
    preset: str
    sensor: str = "none"  # none, or an --imu-model
    seed: int = 1
    options: tuple = ()
    mesh: bool = False

    @property
    def name(self):
        return self.folder.name

    @property
    def truth(self):
        return self.sequence / "groundtruth.txt"

    def command(self):
        words = ["run", str(self.sequence), "-o", str(self.folder), "--preset", self.preset, "--quiet", "--no-color",
                 *([] if self.mesh else ["--no-mesh"]), *self.options]
        return words + sensor_options(self.truth, self.sensor, self.seed)

    def finished(self):
        file = self.folder / "summary.json"
        if not file.exists():
            return False
        summary = json.loads(file.read_text(encoding="utf-8"))
        if summary["interrupted"] or summary["error"]:
            return False
        there, wanted = ([word for word in words if word != "--no-mesh"]
                         for words in (shlex.split(summary["command"])[1:], self.command()))
        if there != wanted:
            raise Failure("its folder holds a run of another command; remove it, or give another -o")
        return not self.mesh or (self.folder / "mesh.ply").exists()

    def summary(self):
        """Carries the run out if it is not finished."""
        if not self.finished():
            call(*self.command())
        return json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))

    def frames(self):
        with open(self.folder / "frames.csv", newline="", encoding="utf-8") as rows:
            return list(csv.DictReader(rows))

    def rmse(self, error, trajectory="trajectory.txt"):
        """`error`: ate, or rpe (over 1 s). In metres; None if there is too little to compare."""
        try:
            figures = call("eval", error, str(self.truth), str(self.folder / trajectory), "--json")
        except Failure:
            return None
        return json.loads(figures)["estimates"][0]["translation_m"]["rmse"]

    def write_all_frames(self):
        """A trajectory of all frames, a lost one with the previous accepted pose: trajectory.txt leaves lost
        frames out, so that a run that lost most of them has a short path with little to be wrong about."""
        name = "all_frames.txt"
        with open(self.folder / name, "w", encoding="utf-8") as out:
            for row in self.frames():
                print(row["time_s"], *(row[key] for key in POSE), file=out)
        return name

    def median_inliers(self):
        """Matched share of the readings, the median over tracked frames; None if there are none."""
        shares = [float(row["inlier_fraction"]) for row in self.frames() if row["status"] == "tracked"]
        return statistics.median(shares) if shares else None


def each(work, items, jobs):
    """work(item) for each item, so many at a time; results in the items' order as they come. One that fails is named
    on standard error and gives None."""

    def guarded(item):
        try:
            return work(item)
        except (Failure, OSError, ValueError, KeyError) as error:
            print(f"{getattr(item, 'name', item)}: {error or type(error).__name__}", file=sys.stderr, flush=True)
            return None

    with concurrent.futures.ThreadPoolExecutor(max(1, jobs)) as pool:
        yield from pool.map(guarded, items)


def known(values):
    return [value for value in values if value is not None]


def parse(parser, output):
    """The command line; what stands after -- becomes `options`. Adds -o, --jobs and --seeds."""
    parser.add_argument("-o", "--output", type=lambda text: pathlib.Path(text).resolve(), metavar="DIR",
                        default=ROOT / "build" / output, help=f"folder of the runs (default build/{output})")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="so many runs at a time (default 1)")
    parser.add_argument("--seeds", type=int, metavar="N", default=parser.get_default("seeds"),
                        help="seeds of the sensor's error model (default %(default)s)")
    words = sys.argv[1:]
    end = words.index("--") if "--" in words else len(words)
    arguments = parser.parse_args(words[:end])
    arguments.options = tuple(words[end + 1:])
    return arguments


def seeds_of(sensor, seeds):
    return range(1, seeds + 1) if sensor == "bno055" else [1]
