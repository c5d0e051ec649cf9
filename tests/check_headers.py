#!/usr/bin/env python3
"""The public headers hold values only: each compiles alone, and none reaches the kernels, the backends or the vector library.

Prints how many headers of the project each brings in and how deep they nest.
Usage: check_headers.py COMPILER EIGEN_INCLUDE [ROOT]; exits with 1 and one line a finding.
"""

import pathlib
import re
import subprocess
import sys

SEALED = re.compile(r"/(kernels|backend|map|tracking)/|/xsimd/|/tbb/|\.cuh?$")


def main() -> int:
    compiler, eigen = sys.argv[1:3]
    root = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else pathlib.Path(__file__).resolve().parent.parent
    headers = sorted((root / "include" / "plumbline").glob("*.h"))
    bad = 0
    for header in headers:
        # -H names every header that is opened, with one dot a level.
        answer = subprocess.run([compiler, "-std=c++20", "-M", "-MF", "/dev/null", "-H", "-x", "c++", f"-I{root}/include", f"-I{root}/src", "-isystem", eigen,
                                 header], capture_output=True, text=True)
        opened = [(len(line.split()[0]), line.split(maxsplit=1)[1]) for line in answer.stderr.splitlines() if re.match(r"\.+ ", line)]
        own = [depth for depth, path in opened if str(root) in path]
        print(f"{header.name:24} {len(own):2} headers of the project, depth {max(own, default=0)}, {len(opened)} in all")
        for _, path in opened:
            if SEALED.search(path):
                print(f"{header.name}: reaches {path}")
                bad += 1
        if answer.returncode:
            print(f"{header.name}: does not compile alone:\n" + "\n".join(l for l in answer.stderr.splitlines() if "error" in l))
            bad += 1
    print(f"{len(headers)} public headers, {bad} findings")
    return 1 if bad or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
