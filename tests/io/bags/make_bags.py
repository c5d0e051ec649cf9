#!/usr/bin/python3
"""Makes the bags beside it with ROS's own writer (Debian: python3-rosbag, python3-sensor-msgs, python3-pil).

Three depth images of 32x24, 0.1 s apart from 100.5 s on; frame k has the reading 1000 + 10 x + y + 100 k (mm) at (x, y)
but none at (0, 0); colour (x, y, 50 k) 5 ms later; twenty readings of an IMU 10 ms apart. Chunks of 2000 bytes, so that there
are many.
"""
import io
import pathlib
import struct

import genpy
import rosbag
import sensor_msgs.msg as msg
from PIL import Image

HERE = pathlib.Path(__file__).parent
WIDTH, HEIGHT = 32, 24


def header(message, time):
    message.header.stamp = genpy.Time(*divmod(round(1e6 * time) * 1000, 10**9))
    message.header.frame_id = "camera"
    return message


def reading(x, y, k):
    return 0 if x == y == 0 else 1000 + 10 * x + y + 100 * k


def pixels():
    return [(x, y) for y in range(HEIGHT) for x in range(WIDTH)]


def raw(encoding, step, data, time):
    return header(msg.Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=step, data=data), time)


def png(mode, data):
    out = io.BytesIO()
    Image.frombytes(mode, (WIDTH, HEIGHT), data).save(out, "PNG")
    return out.getvalue()


def depth_16(k, time):
    return raw("16UC1", 2 * WIDTH, struct.pack("<768H", *[reading(x, y, k) for x, y in pixels()]), time)


def depth_float(k, time):
    values = [reading(x, y, k) / 1000 or float("nan") for x, y in pixels()]
    return raw("32FC1", 4 * WIDTH, struct.pack("<768f", *values), time)


def depth_packed(k, time):
    data = struct.pack("<768H", *[reading(x, y, k) for x, y in pixels()])
    return header(msg.CompressedImage(format="16UC1; compressedDepth png", data=bytes(12) + png("I;16", data)), time)


def color_raw(k, time):
    return raw("rgb8", 3 * WIDTH, bytes(c for x, y in pixels() for c in (x, y, 50 * k)), time)


def color_packed(k, time):
    data = bytes(c for x, y in pixels() for c in (x, y, 50 * k))
    return header(msg.CompressedImage(format="rgb8; png compressed", data=png("RGB", data)), time)


def camera_info(time):
    info = header(msg.CameraInfo(height=HEIGHT, width=WIDTH, distortion_model="plumb_bob"), time)
    info.D = [0.1, -0.2, 0.001, 0.002, 0.05]
    info.K = [30, 0, 15.5, 0, 31, 11.5, 0, 0, 1]
    info.P = [29, 0, 15, 0, 0, 29, 11, 0, 0, 0, 1, 0]
    return info


def imu(i, time, gyroscope):
    reading = header(msg.Imu(), time)
    reading.angular_velocity.x = 0.01 * i
    reading.linear_acceleration.z = 9.81
    if not gyroscope:
        reading.angular_velocity_covariance[0] = -1
    return reading


def write(name, compression, depth, color, gyroscope, info=True):
    with rosbag.Bag(HERE / name, "w", compression=compression, chunk_threshold=2000) as bag:
        def put(topic, message, delay=0.02):
            bag.write(topic, message, message.header.stamp + genpy.Duration.from_sec(delay))
        for k in range(3):
            time = 100.5 + 0.1 * k
            put(color[0], color[1](k, time + 0.005))
            put(depth[0], depth[1](k, time))
            if info:
                put("/camera/depth/camera_info", camera_info(time))
        for i in range(20):
            put("/imu", imu(i, 100.5 + 0.01 * i, gyroscope))


write("plain.bag", rosbag.Compression.NONE, ("/camera/depth/image_raw", depth_16), ("/camera/rgb/image_color", color_raw), True)
write("tum.bag", rosbag.Compression.BZ2, ("/camera/depth/image_rect", depth_float), ("/camera/rgb/image_color", color_raw), False)
write("packed.bag", rosbag.Compression.LZ4, ("/camera/depth/image_raw/compressedDepth", depth_packed),
      ("/camera/rgb/image_color/compressed", color_packed), True, info=False)
