#!/usr/bin/env python3
"""What a live page costs the tracker, and how late it is: bench/view.py BUILD SEQUENCE [FRAMES] [REPEATS]

As fast as it goes, runs in turn: without --view; served, but nobody watches; with a reader that takes all and says at
once that it has drawn it, so that no browser competes for the processor. Compared are the medians of a frame's stages
(frames.csv) and the wall time of the loop a frame, which has the hand-over in it.
In real time, in turn: without --view, and with headless Chromium, drawing by software on the same processors: from frame
to page, updates a second (web/test/measure_live.mjs), and what a frame's stages take beside a browser.
"""

import base64
import csv
import json
import os
import pathlib
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import urllib.parse

build, recording = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
frames, repeats = (int(v) for v in (sys.argv[3:] + ["200", "3"][len(sys.argv) - 3:])[:2])
web = pathlib.Path(__file__).resolve().parent.parent / "web"
environment = {**os.environ, "DISPLAY": "", "WAYLAND_DISPLAY": "", "BROWSER": ""}


def exactly(stream, count):
    data = stream.read(count)
    if len(data) < count:
        raise EOFError
    return data


def read_page(url):
    """Takes all messages; JSON in binary ones whose type is "state" is answered with its number."""
    parts = urllib.parse.urlsplit(url)
    with socket.create_connection((parts.hostname, parts.port)) as connection:
        key = base64.b64encode(os.urandom(16)).decode()
        connection.sendall((f"GET /live?{parts.query} HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: http://{parts.netloc}\r\nUpgrade: websocket\r\n"
                            f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n").encode())
        stream = connection.makefile("rb")
        while stream.readline().strip():
            pass
        received = 0
        try:
            while True:
                first, size = exactly(stream, 2)
                size = int.from_bytes(exactly(stream, 2 if size == 126 else 8), "big") if size > 125 else size
                data = exactly(stream, size)
                received += size
                if first & 15 == 8:
                    break
                if first & 15 == 2 and data[4:20] == b'{"type":"state",':
                    number = data.split(b'"number":', 1)[1].split(b",", 1)[0].rstrip(b"}")
                    request = b'{"do":"shown","number":' + number + b"}"
                    connection.sendall(bytes([0x81, 0x80 | len(request), 0, 0, 0, 0]) + request)
        except (EOFError, ConnectionError):
            pass
        return received


def start(folder, *words):
    command = [build / "plumbline", "run", recording, "-o", folder, "--orientation", "none", "--set", "preprocess.calibrate_depth=false",
               "--no-report", "--detail", "off", "--quiet", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)


def url_of(run):
    for line in run.stdout:
        if line.startswith("view       http"):
            return line.split()[1]
    raise RuntimeError("no page was served")


def measure(folder, kind):
    """Milliseconds a frame: median of the stages, and of the loop without the waiting for the reader of files."""
    run = start(folder, "--no-mesh", "--max-frames", str(frames), *([] if kind == "none" else ["--view"]))
    if kind == "read":
        threading.Thread(target=read_page, args=(url_of(run),), daemon=True).start()
    run.communicate()
    rows = list(csv.DictReader((folder / "frames.csv").open()))[20:]  # what comes first fills caches
    summary = json.loads((folder / "summary.json").read_text())
    waits = sum(float(row["wait_ms"]) for row in rows)
    return statistics.median(float(row["total_ms"]) for row in rows), 1e3 * summary["wall_s"] / frames - waits / len(rows)


def main():
    kinds = ["none", "served", "read"]
    results = {kind: [] for kind in kinds}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for _ in range(repeats):
            for kind in kinds:
                results[kind].append(measure(folder, kind))
        base = [min(values) for values in zip(*results["none"])]
        for kind in kinds:
            best = [min(values) for values in zip(*results[kind])]
            print(f"{kind:8} stages {best[0]:6.2f} ms ({best[0] / base[0]:.3f})   loop {best[1]:6.2f} ms ({best[1] / base[1]:.3f})   best of {repeats}")
        in_real_time(folder)


def median_of_stages(folder):
    rows = list(csv.DictReader((folder / "frames.csv").open()))[20:280]  # what comes first fills caches; the same frames in each
    return statistics.median(float(row["total_ms"]) for row in rows)


def in_real_time(folder):
    stages = {"none": [], "page": []}
    for _ in range(2):
        start(folder, "--no-mesh", "--realtime", "--max-frames", "300").communicate()
        stages["none"].append(median_of_stages(folder))
        run = start(folder, "--no-mesh", "--view", "--realtime")
        page = subprocess.run(["node", web / "test" / "measure_live.mjs", url_of(run), "12"], capture_output=True, text=True)
        run.terminate()
        run.communicate()
        stages["page"].append(median_of_stages(folder))
        print(f"Chromium {page.stdout.strip()}{page.stderr.strip()[:300]}")
    none, with_page = min(stages["none"]), min(stages["page"])
    print(f"in real time: stages {none:.2f} ms, beside Chromium {with_page:.2f} ms ({with_page / none:.3f})   best of 2")
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
