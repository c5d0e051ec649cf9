#!/usr/bin/env python3
"""What a frame costs from Python beside the program: bench/python.py BUILD SEQUENCE [FRAMES] [REPEATS]

Runs of program and module alternate over the same frames; the median of each is compared, as wall time and as processor
time, which the load of the machine changes less. The poses must be the same. Both read the PNGs, track and fuse;
neither searches for the depth's distortion, takes a sensor, or makes a mesh.
"""

import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

build, recording = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
frames, repeats = (int(v) for v in (sys.argv[3:] + ["300", "5"][len(sys.argv) - 3:])[:2])

LOOP = """
import json, sys, time
import plumbline
sequence = plumbline.open_sequence(sys.argv[1], color=False)
pipeline = plumbline.Pipeline(None, sequence.camera, depth_scale=sequence.depth_scale)
begin, times, poses = (time.perf_counter(), time.process_time()), [], []
for frame in sequence:
    if len(times) == int(sys.argv[2]):
        break
    report = pipeline.process(frame.depth, time_ns=frame.time_ns)
    times.append(report.milliseconds["total"])
    poses.append((frame.time_ns, report.has_pose, report.world_from_camera))
wall, processor = time.perf_counter() - begin[0], time.process_time() - begin[1]
kept = [p for p in poses if p[1]]
plumbline.Trajectory([t * 1e-9 for t, _, _ in kept], [p for _, _, p in kept]).save(sys.argv[3] + "/python.txt")
print(json.dumps({"wall": wall, "processor": processor, "stages": sorted(times)[len(times) // 2]}))
"""


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_program(folder, count):
    before = processor_seconds()
    subprocess.run([build / "plumbline", "run", recording, "-o", folder, "--max-frames", str(count), "--orientation", "none", "--no-color",
                    "--set", "preprocess.calibrate_depth=false", "--no-mesh", "--no-report", "--quiet"], check=True)
    summary = json.loads((folder / "summary.json").read_text())
    return {"wall": summary["wall_s"], "processor": processor_seconds() - before,
            "stages": summary["median_ms"]["total"]}


def run_python(folder):
    done = subprocess.run(["/usr/bin/python3", "-c", LOOP, recording, str(frames), str(folder)], check=True, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(build / "python")})
    return json.loads(done.stdout)


def poses(path):
    return [float(word) for line in path.read_text().splitlines() if not line.startswith("#") for word in line.split()[1:]]


def same(a, b):
    """To a digit of what the files hold: through Python a rotation goes as a matrix."""
    return len(a) == len(b) > 0 and max(abs(x - y) for x, y in zip(a, b)) < 3e-9


with tempfile.TemporaryDirectory(prefix="plumbline_bench_") as name:
    folder, results = pathlib.Path(name), {"program": [], "python": []}
    start = run_program(folder, 1)["processor"]  # opening, which the loop in Python does not count
    for _ in range(repeats):
        program = run_program(folder, frames)
        program["processor"] -= start
        results["program"].append(program)
        results["python"].append(run_python(folder))
    alike = same(poses(folder / "trajectory.txt"), poses(folder / "python.txt"))
print(f"{frames} frames, {repeats} times each; poses {'the same' if alike else 'DIFFERENT'}")
for figure, scale in (("wall", 1e3 / frames), ("processor", 1e3 / frames), ("stages", 1)):
    medians = [scale * statistics.median(run[figure] for run in results[who]) for who in ("program", "python")]
    print(f"{figure:10} program {medians[0]:7.2f} ms a frame, Python {medians[1]:7.2f} ms, ratio {medians[1] / medians[0]:.3f}")
sys.exit(0 if alike else 1)
