#!/usr/bin/env python3
"""NumPy frames in a loop, and the camera's path as a plot: loop.py RECORDING [PLOT.png]"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import plumbline

sequence = plumbline.open_sequence(sys.argv[1])
parameters = plumbline.Parameters()
parameters.volume.resolution = 256
pipeline = plumbline.Pipeline(parameters, sequence.camera)

positions, milliseconds = [], []
for frame in sequence:
    depth = frame.depth / np.float32(frame.depth_scale)  # metres; any (H, W) array of float32 will do
    report = pipeline.process(depth, time_ns=frame.time_ns)
    if report.has_pose:
        positions.append(report.world_from_camera[:3, 3])
        milliseconds.append(report.milliseconds["total"])

positions = np.array(positions)
mesh = pipeline.mesh()
print(f"{len(positions)} of {len(sequence)} frames tracked, {np.median(milliseconds):.1f} ms a frame, "
      f"{len(mesh.triangles)} triangles")

seen = mesh.vertices[:: max(1, len(mesh.vertices) // 20000)]
plt.figure(figsize=(6, 6))
plt.scatter(seen[:, 0], seen[:, 2], s=0.5, c="0.8")
plt.plot(positions[:, 0], positions[:, 2], "C3")
plt.xlabel("x (m), to the first camera's right")
plt.ylabel("z (m), forward")
plt.axis("equal")
plt.savefig(sys.argv[2] if len(sys.argv) > 2 else "path.png", dpi=100)
