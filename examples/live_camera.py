#!/usr/bin/env python3
"""Frames of a camera as they come: live_camera.py RECORDING [SPEED]

A thread stands for the camera's driver and plays a recording; put yours in its place. What comes while a frame is worked on
is replaced by what comes after it, so that the reconstruction never falls behind.
"""

import queue
import sys
import threading
import time

import plumbline


class Camera(threading.Thread):
    """Puts the latest frame into `latest`; None at the end."""

    def __init__(self, path, speed):
        super().__init__(daemon=True)
        self.sequence = plumbline.open_sequence(path)
        self.speed, self.latest, self.captured = speed, queue.Queue(maxsize=1), 0

    def put(self, frame):
        try:
            self.latest.get_nowait()  # nobody took it: it is dropped
        except queue.Empty:
            pass
        self.latest.put(frame)

    def run(self):
        begin = first = None
        for frame in self.sequence:
            if begin is None:
                begin, first = time.monotonic(), frame.time
            time.sleep(max(0, begin + (frame.time - first) / self.speed - time.monotonic()))
            self.captured += 1
            self.put(frame)
        while not self.latest.empty():  # the final frame is to be seen
            time.sleep(0.001)
        self.latest.put(None)


camera = Camera(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 1.0)
parameters = plumbline.Parameters()
parameters.volume.resolution = 256
pipeline = plumbline.Pipeline(parameters, camera.sequence.camera, depth_scale=camera.sequence.depth_scale)
camera.start()

processed = lost = 0
while (frame := camera.latest.get()) is not None:
    report = pipeline.process(frame.depth, frame.time)
    processed += 1
    lost += not report.has_pose
    x, y, z = report.world_from_camera[:3, 3]
    print(f"frame {frame.index:4}: {report.status:12} camera at {x:6.3f} {y:6.3f} {z:6.3f} m")

print(f"{camera.captured} captured, {processed} processed, {lost} lost, {len(pipeline.mesh().triangles)} triangles")
