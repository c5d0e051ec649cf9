"""The Python module: the same results as the program to the bit, and exceptions where something is wrong.

PLUMBLINE is the program. Run by ctest; by hand: PYTHONPATH=build/release/python PLUMBLINE=build/release/plumbline
/usr/bin/python3 -m unittest discover tests/python
"""

import copy
import gc
import os
import pathlib
import pickle
import resource
import subprocess
import tempfile
import threading
import unittest

import numpy as np

import plumbline

PROGRAM = os.environ["PLUMBLINE"]
CAMERA = plumbline.Camera(131.25, 131.25, 79.5, 59.5, 160, 120)


def small(parameters=None):
    """A volume that is quick to make."""
    p = parameters or plumbline.Parameters()
    p.volume.resolution = 128
    p.volume.side = 4
    return p


def wall(metres=1.5, camera=CAMERA):
    """A wall with a step in it: what a camera can be tracked by along its axis."""
    depth = np.full((camera.height, camera.width), metres, np.float32)
    depth[30:80, 40:100] -= 0.3
    return depth


class Recording(unittest.TestCase):
    """A simulated recording that several tests read."""

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory(prefix="plumbline_python_")
        cls.folder = pathlib.Path(cls._folder.name)
        cls.recording = str(cls.folder / "recording")
        cls.truth = plumbline.simulate(cls.recording, frames=24, camera=CAMERA)

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    def program(self, *words):
        out = self.folder / f"program_{len(list(self.folder.iterdir()))}"
        subprocess.run([PROGRAM, "run", self.recording, "-o", out, "--no-report", "--quiet", "--set", "volume.resolution=128",
                        "--set", "volume.side=4", *words], check=True, capture_output=True)
        return out


class SameAsTheProgram(Recording):
    def test_a_run_is_the_same_to_the_bit(self):
        expected = self.program()
        self.assertEqual(plumbline.open_sequence(self.recording).format, "TUM RGB-D")
        run = plumbline.run(self.recording, self.folder / "python", parameters=small())
        for name in ("trajectory.txt", "mesh.ply", "config.toml"):
            self.assertEqual((expected / name).read_bytes(), (self.folder / "python" / name).read_bytes(), name)
        self.assertEqual(run.tracked, 24)
        self.assertEqual(run.lost, 0)
        self.assertIn("recording's own sensor", run.orientation)

    def test_a_loop_over_arrays_is_the_same_to_the_bit(self):
        expected = self.program("--orientation", "none", "--no-color").joinpath("trajectory.txt").read_text().splitlines()
        sequence = plumbline.open_sequence(self.recording)
        by_array = plumbline.Pipeline(small(), sequence.camera, depth_scale=sequence.depth_scale)
        by_frame = plumbline.Pipeline(small(), sequence.camera)
        lines = []
        for frame in sequence:
            report = by_array.process(frame.depth, time_ns=frame.time_ns)
            np.testing.assert_array_equal(report.world_from_camera, by_frame.process(frame).world_from_camera)
            self.assertTrue(report.has_pose)
            lines.append((report.time, report.world_from_camera))
        self.assertEqual(len(lines), len(sequence))
        trajectory = plumbline.Trajectory([t for t, _ in lines], [p for _, p in lines])
        trajectory.save(self.folder / "loop.txt")
        numbers = lambda rows: np.array([[float(v) for v in row.split()] for row in rows if not row.startswith("#")])
        np.testing.assert_allclose(numbers((self.folder / "loop.txt").read_text().splitlines()), numbers(expected), atol=2e-9)

    def test_orientation_and_inertial_readings_reach_the_tracker(self):
        pipeline = plumbline.Pipeline(small(), CAMERA)
        used = []
        for i in range(4):
            used.append(pipeline.process(wall(), 0.03 * i, orientation=np.eye(3)).orientation)
        self.assertEqual(used[0], "first")
        self.assertIn("used", used[1:])
        quaternion = plumbline.Pipeline(small(), CAMERA)
        self.assertEqual(quaternion.process(wall(), 0, orientation=(0, 0, 0, 1)).orientation, "first")
        inertial = plumbline.Pipeline(small(), CAMERA)
        for i in range(6):
            times = 0.03 * i + np.linspace(-0.2, 0.2, 80)
            imu = np.column_stack([times, np.zeros((80, 3)), np.tile([0, -9.8, 0], (80, 1))])
            report = inertial.process(wall(), 0.03 * i, imu=imu)
        self.assertTrue(report.has_pose)

    def test_color_is_fused(self):
        pipeline = plumbline.Pipeline(small(), CAMERA, color=True)
        red = np.zeros((120, 160, 3), np.uint8)
        red[..., 0] = 200
        for i in range(4):
            pipeline.process(wall(), 0.03 * i, color=red)
        colors = pipeline.mesh().colors
        self.assertGreater(len(colors), 0)
        self.assertGreater(colors[:, 0].mean(), 150)
        self.assertLess(colors[:, 1].mean(), 10)

    def test_millimetres_and_metres_are_the_same_depth(self):
        readings = plumbline.Pipeline(small(), CAMERA)
        metres = plumbline.Pipeline(small(), CAMERA)
        depth = wall()
        readings.process(np.round(1000 * depth).astype(np.uint16), 0)
        metres.process(depth, 0)
        np.testing.assert_array_equal(readings.mesh().vertices, metres.mesh().vertices)
        strided = np.asfortranarray(depth)
        other = plumbline.Pipeline(small(), CAMERA)
        other.process(strided, 0)
        np.testing.assert_array_equal(other.mesh().vertices, metres.mesh().vertices)

    def test_the_map_holds_the_surface(self):
        pipeline = plumbline.Pipeline(small(), CAMERA)
        for i in range(4):
            pipeline.process(wall(), 0.03 * i)
        voxels = pipeline.map()
        self.assertEqual(voxels.distances.shape, (len(voxels.bricks), 8, 8, 8))
        self.assertEqual(voxels.weights.max(), 4)
        self.assertAlmostEqual(voxels.voxel_size, 4 / 128)
        brick, z, y, x = np.unravel_index(np.argmin(np.where(voxels.weights > 0, abs(voxels.distances), 9)), voxels.distances.shape)
        point = (voxels.bricks[brick] + np.array([x, y, z]) + 0.5) * voxels.voxel_size
        world = voxels.world_from_map @ np.append(point, 1)
        self.assertLess(min(abs(world[2] - 1.5), abs(world[2] - 1.2)), 2 * voxels.voxel_size)

    def test_evaluation_finds_the_error_that_was_made(self):
        truth = self.truth.trajectory
        self.assertLess(plumbline.evaluate(truth, truth).ate.max, 1e-9)
        poses = truth.poses
        poses[::2, 0, 3] += 0.02
        error = plumbline.evaluate(truth, plumbline.Trajectory(truth.times, poses), delta=0.1)
        self.assertAlmostEqual(error.ate.rmse, 0.01, delta=0.001)
        self.assertGreater(error.rpe_translation.rmse, 0.005)
        self.assertEqual(len(error.errors), len(truth))
        surface = plumbline.compare_meshes(self.truth.scene, self.truth.scene, samples=2000)
        self.assertLess(surface.accuracy.max, 1e-4)
        self.assertEqual(surface.scores[0].f_score, 1)

    def test_callbacks_are_told_and_can_end_a_run(self):
        seen, lines = [], []
        plumbline.run(self.recording, parameters=small(), mesh=False, frames=[0, 2, 4], on_frame=lambda r: seen.append(r.index),
                      log=lambda level, line: lines.append((level, line)))
        self.assertEqual(seen, [0, 2, 4])
        self.assertTrue(any("sensor" in line for _, line in lines), lines)

        def end(report):
            raise KeyError("enough")

        with self.assertRaisesRegex(KeyError, "enough"):
            plumbline.run(self.recording, parameters=small(), on_frame=end)


class ParametersAreTheList(unittest.TestCase):
    def test_every_key_is_an_attribute_with_a_help(self):
        p = plumbline.Parameters()
        for key in plumbline.Parameters.keys():
            group, name = key.split(".")
            getattr(getattr(p, group), name)
            self.assertTrue(getattr(type(getattr(p, group)), name).__doc__, key)
        self.assertIn("deg; from 0.1 to 180", plumbline.TrackingParameters.normal_gate.__doc__)

    def test_values_go_in_and_out(self):
        p = plumbline.Parameters()
        p.tracking.normal_gate = 25
        p.tracking.iterations = [1, 2]
        p.tracking.iterations = np.array([3, 4])
        p.volume.placement = "fit"
        p.volume.color = False
        p.volume.side = np.float32(2.5)
        p.orientation.lambda_ = 3
        self.assertEqual((p.tracking.normal_gate, p.tracking.iterations, p.volume.placement, p.volume.side), (25, [3, 4], "fit", 2.5))
        self.assertIn("normal_gate = 25", p.to_toml())
        self.assertIn("lambda = 3", p.to_toml())
        for other in (p.copy(), copy.deepcopy(p), pickle.loads(pickle.dumps(p))):
            self.assertEqual(other, p)
        self.assertNotEqual(plumbline.Parameters("kinectfusion"), p)
        self.assertNotEqual(plumbline.Parameters(quality="fast"), plumbline.Parameters(quality="best"))

    def test_errors_have_the_programs_text(self):
        p = plumbline.Parameters()
        text = subprocess.run([PROGRAM, "run", "--print-config", "--set", "tracking.normal_gate=999"], capture_output=True, text=True).stderr
        with self.assertRaises(plumbline.Error) as raised:
            p.tracking.normal_gate = 999
        self.assertEqual(f"plumbline: error: {raised.exception}", text.strip())
        for group, name, value in (("tracking", "normal_gate", float("nan")), ("volume", "placement", "nowhere"), ("volume", "resolution", "many"),
                                   ("tracking", "iterations", 3), ("volume", "color", 7), ("volume", "side", None)):
            with self.assertRaises(plumbline.Error, msg=f"{group}.{name} = {value}"):
                setattr(getattr(p, group), name, value)
        self.assertEqual(p, plumbline.Parameters())
        with self.assertRaises(AttributeError):
            p.tracking.normal_gates = 3
        p.preprocess.min_depth = 9
        with self.assertRaisesRegex(plumbline.Error, "no depth lies between"):
            plumbline.Pipeline(p, CAMERA)


class WrongInputRaises(Recording):
    def setUp(self):
        self.pipeline = plumbline.Pipeline(small(), CAMERA)

    def test_of_a_frame(self):
        process, depth = self.pipeline.process, wall()
        for wrong in (depth.astype(np.float64), depth.astype(np.int32), depth > 1, "depth", None, 3, [[1.0]]):
            with self.assertRaises(TypeError, msg=repr(wrong)[:40]):
                process(wrong, 0)
        for wrong in (depth[:-1], depth.T, depth[..., None], depth[None], np.zeros((0, 0), np.float32), np.float32(3)):
            with self.assertRaises((ValueError, TypeError), msg=str(np.shape(wrong))):
                process(wrong, 0)
        for time in (None, float("nan"), float("inf"), 1e300, "soon", depth):
            with self.assertRaises((ValueError, TypeError, RuntimeError), msg=repr(time)[:40]):
                process(depth, time)
        with self.assertRaises(ValueError):
            process(depth, 0, time_ns=0)
        for color in (np.zeros((120, 160, 3)), "red", 3):
            with self.assertRaises(TypeError):
                process(depth, 0, color=color)
        for color in (np.zeros((120, 160), np.uint8), np.zeros((120, 160, 4), np.uint8), np.zeros((60, 160, 3), np.uint8)):
            with self.assertRaises(ValueError):
                process(depth, 0, color=color)
        self.assertEqual(process(depth, 0).status, "initialised")

    def test_of_a_pose_or_a_rotation(self):
        nan = np.eye(4)
        nan[1, 3] = np.nan
        for pose in (nan, np.eye(3), np.ones((4, 4)), 2 * np.eye(4), "here", np.diag([1, 1, -1, 1])):
            with self.assertRaises(ValueError, msg=str(pose)):
                plumbline.Pipeline(small(), CAMERA, initial_pose=pose)
        for turn in (np.full((3, 3), np.nan), np.ones((3, 3)), (0, 0, 0, 0), (1, 2, 3), "north", np.diag([1, 1, -1])):
            with self.assertRaises(ValueError, msg=str(turn)):
                self.pipeline.process(wall(), 0, orientation=turn)
        for imu in (np.zeros(7), np.zeros((3, 6)), np.full((2, 7), np.nan), np.zeros((2, 7))):
            with self.assertRaises(ValueError, msg=str(imu)):
                self.pipeline.process(wall(), 0, imu=imu)
        with self.assertRaises(plumbline.Error):
            plumbline.Pipeline(small(), CAMERA, orientation_covariance=-np.eye(3))

    def test_of_constructors_and_names(self):
        for arguments in ({"depth_scale": 0}, {"depth_scale": float("nan")}, {"threads": -1}):
            with self.assertRaises(ValueError, msg=str(arguments)):
                plumbline.Pipeline(small(), CAMERA, **arguments)
        with self.assertRaisesRegex(plumbline.Error, "no such backend"):
            plumbline.Pipeline(small(), CAMERA, backend="abacus")
        with self.assertRaises(ValueError):
            plumbline.Camera(float("nan"), 1, 0, 0, 10, 10)
        with self.assertRaises(TypeError):
            plumbline.Pipeline(small(), None)
        with self.assertRaises(plumbline.Error):
            plumbline.open_sequence(self.folder / "nowhere")
        with self.assertRaises(plumbline.Error):
            plumbline.run(self.recording, parameters=small(), frames=[5, 3])
        with self.assertRaises(plumbline.Error):
            plumbline.simulate(self.folder / "x", scene="moon")
        with self.assertRaises(plumbline.Error):
            plumbline.Parameters("nothing")
        with self.assertRaises(plumbline.Error):
            plumbline.evaluate("missing.txt", "missing.txt")
        with self.assertRaises(IndexError):
            plumbline.open_sequence(self.recording)[24]
        with self.assertRaises(TypeError):
            plumbline.FrameReport()

    def test_a_frame_of_another_size_raises(self):
        other = plumbline.Pipeline(small(), plumbline.Camera(100, 100, 40, 30, 80, 60))
        with self.assertRaises(plumbline.Error):
            other.process(plumbline.open_sequence(self.recording)[0])

    def test_losing_track_is_a_status(self):
        self.pipeline.process(wall(), 0)
        report = self.pipeline.process(np.zeros((120, 160), np.uint16), 0.03)
        self.assertEqual((report.status, report.has_pose), ("lost", False))
        self.assertTrue(report.reason)

    def test_a_damaged_frame_is_skipped_with_a_warning(self):
        damaged = self.folder / "damaged"
        plumbline.simulate(damaged, frames=4, camera=CAMERA, color=False)
        sorted(damaged.glob("depth/*.png"))[2].write_bytes(b"not a picture")
        with self.assertWarns(RuntimeWarning):
            indices = [frame.index for frame in plumbline.open_sequence(damaged)]
        self.assertEqual(indices, [0, 1, 3])


class ObjectsLiveAsLongAsTheirViews(Recording):
    def test_views_keep_their_owners(self):
        pipeline = plumbline.Pipeline(small(), CAMERA)
        pipeline.process(wall(), 0)
        mesh = pipeline.mesh()
        vertices, triangles = mesh.vertices, mesh.triangles
        self.assertFalse(vertices.flags.owndata)  # no copy
        self.assertIs(vertices.base, mesh)
        expected = vertices.copy()
        frame = plumbline.open_sequence(self.recording)[3]
        depth, expected_depth = frame.depth, frame.depth.copy()
        run = plumbline.run(self.recording, parameters=small(), frames=[0, 1])
        run_vertices = run.mesh.vertices
        expected_run = run_vertices.copy()
        group = plumbline.Parameters().tracking
        iterator = iter(plumbline.open_sequence(self.recording))
        del pipeline, mesh, frame, run
        gc.collect()
        rubbish = [np.random.default_rng(i).random(vertices.shape) for i in range(50)]  # what freed memory would be filled with
        np.testing.assert_array_equal(vertices, expected)
        np.testing.assert_array_equal(depth, expected_depth)
        np.testing.assert_array_equal(run_vertices, expected_run)
        self.assertLess(triangles.max(), len(vertices))
        self.assertEqual(group.normal_gate, 30)
        self.assertEqual(next(iterator).index, 0)
        del iterator, rubbish

    def test_threads_may_share_a_pipeline(self):
        pipeline, errors = plumbline.Pipeline(small(), CAMERA), []

        def work(first):
            try:
                for i in range(6):
                    pipeline.process(wall(), 0.01 * (first + 2 * i))
                    pipeline.mesh()
            except Exception as error:  # whatever it is, it is a finding
                errors.append(error)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(errors, [])

    def test_the_gil_is_released(self):
        pipeline, ticks, done = plumbline.Pipeline(small(), CAMERA), [0], threading.Event()

        def tick():
            while not done.is_set():
                ticks[0] += 1
                done.wait(1e-4)

        thread = threading.Thread(target=tick)
        thread.start()
        before = ticks[0]
        for i in range(20):
            pipeline.process(wall(), 0.03 * i)
        done.set()
        thread.join()
        self.assertGreater(ticks[0], before)


class MemoryDoesNotGrow(unittest.TestCase):
    def test_over_two_thousand_frames(self):
        p = small()
        p.volume.resolution = 64
        p.volume.truncation = 0.2
        pipeline, depth, resident = plumbline.Pipeline(p, CAMERA, threads=1), wall(), []
        color = np.zeros((120, 160, 3), np.uint8)
        for i in range(2000):
            report = pipeline.process(depth, 0.03 * i, color=color)
            self.assertTrue(report.has_pose)
            if i % 100 == 0:
                len(pipeline.mesh().vertices), pipeline.map().weights.sum()
            if i in (400, 1999):
                gc.collect()
                pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
                resident.append(pages * resource.getpagesize() / 2**20)
        self.assertLess(resident[1] - resident[0], 8, f"MiB: {resident}")


class StubsAndDocstrings(unittest.TestCase):
    def test_everything_public_is_documented_and_in_the_stubs(self):
        stubs = (pathlib.Path(plumbline.__file__).parent / "_plumbline.pyi").read_text()
        compile(stubs, "_plumbline.pyi", "exec")
        for name in dir(plumbline._plumbline):
            if name.startswith("_"):
                continue
            thing = getattr(plumbline, name)
            self.assertTrue(thing.__doc__, name)
            self.assertRegex(stubs, rf"(?m)^(class|def) {name}\b", name)
        self.assertIn("def world_from_camera(self) -> numpy.ndarray:", stubs)


if __name__ == "__main__":
    unittest.main()
