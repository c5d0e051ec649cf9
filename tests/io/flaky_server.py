"""A server of files over HTTP that misbehaves as it is told.

Usage: flaky_server.py FOLDER PORT_FILE. It ends when its standard input does. Under /NAME/FILE it serves FOLDER/FILE:

    good        as it should, ranges included
    broken      no more than 100000 bytes a connection, then it hangs up; ranges work
    noranges    the same for the first two requests, and ranges are ignored
    short       says that there are 1000 bytes more than there are
    deaf        breaks off after 100000 bytes once, then never sends another byte of the body
    busy        answers 503 twice, then as it should
    changing    another ETag and other bytes with each request, 100000 bytes of them, the third time all
    moved       a redirection to good
"""

import http.server
import pathlib
import sys
import threading

FOLDER, PORT_FILE = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
PART = 100000
requests = {}


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def refuse(self, status, location=None):
        self.send_response(status)
        if location:
            self.send_header("Location", location)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def do_GET(self):
        mode, _, name = self.path.lstrip("/").partition("/")
        count = requests[self.path] = requests.get(self.path, 0) + 1
        file = FOLDER / name
        if mode == "moved":
            return self.refuse(302, f"/good/{name}")
        if not file.is_file():
            return self.refuse(404)
        if mode == "busy" and count <= 2:
            return self.refuse(503)
        data = file.read_bytes()
        if mode == "changing":
            data = bytes(b ^ count for b in data[:1000]) + data[1000:] if count < 3 else data
        etag = f'"{count}"' if mode == "changing" else '"1"'
        self.answer(mode, count, data, etag)

    def answer(self, mode, count, data, etag):
        wanted = self.headers.get("Range")
        same = self.headers.get("If-Range") in (None, etag)
        begin = int(wanted[len("bytes="):].rstrip("-")) if wanted and same and mode != "noranges" else 0
        if begin and begin >= len(data) and mode != "short":
            self.send_response(416)
            self.send_header("Content-Range", f"bytes */{len(data)}")
            self.send_header("Content-Length", "0")
            return self.end_headers()
        claimed = len(data) + (1000 if mode == "short" else 0)
        self.send_response(206 if begin else 200)
        self.send_header("ETag", etag)
        self.send_header("Content-Length", str(claimed - begin))
        if begin:
            self.send_header("Content-Range", f"bytes {begin}-{claimed - 1}/{claimed}")
        self.end_headers()
        part = data[begin:]
        if mode == "broken" or (mode in ("noranges", "changing") and count <= 2) or (mode == "deaf" and count == 1):
            part = part[:PART]
        if mode == "deaf" and count > 1:
            part = b""
        self.wfile.write(part)
        if len(part) < claimed - begin:
            self.close_connection = True


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
temporary = PORT_FILE.with_suffix(".new")
temporary.write_text(str(server.server_address[1]))
temporary.rename(PORT_FILE)
threading.Thread(target=server.serve_forever, daemon=True).start()
sys.stdin.read()
