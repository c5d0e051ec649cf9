"""Dense 3D reconstruction from depth images, with or without an orientation sensor.

    import plumbline
    run = plumbline.run("recording")          # all that the program does
    run.trajectory.poses, run.mesh.vertices   # NumPy arrays

    pipeline = plumbline.Pipeline(None, plumbline.Camera(fx, fy, cx, cy, width, height))
    for depth, time in frames:                # (H, W) uint16 in millimetres or float32 in metres
        report = pipeline.process(depth, time)

Frames in names: world_from_camera maps points of the camera's frame (x right, y down, z forward) into the world, which is
the first camera's frame. Metres, seconds, radians. Errors are plumbline.Error; losing track is a status of a frame.
"""

from ._plumbline import *  # noqa: F401,F403
from ._plumbline import __version__  # noqa: F401
