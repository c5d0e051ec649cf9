#!/usr/bin/env python3
"""A user's project, outside of the tree, against an installed plumbline: run_consumer.py BUILD CMAKE COMPILER

Installs the library into BUILD/consumer/prefix, copies tests/consumer to a temporary folder, and builds and runs it with
find_package and with pkg-config, shared and static. Looks at what the shared library shows. Exits with 1 and one line a
finding.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

LINE = re.compile(r"plumbline \d+\.\d+\.\d+: 8 frames, \d+ triangles, [\d.]+ mm\n")
# What the shared library may show: the public namespace, and what the compiler emits for public classes.
INSIDE = re.compile(r"plumbline::(kernels|sim|capture|app)::|plumbline::(Volume|Tracker|CpuBackend|LiveFrame|Recovery|FileSource)\b")


def call(words, **options):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False, **options)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, words))}: exit {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def check(program, folder, what, bad, environment=None):
    begin = time.monotonic()
    said = call([program], cwd=folder, env={**os.environ, **(environment or {})})
    if not LINE.fullmatch(said):
        bad.append(f"{what}: says more or less than its one line: {said!r}")
    print(f"{what}: {said.strip()} ({time.monotonic() - begin:.1f} s)")


def with_cmake(kind, prefix, folder, cmake, bad):
    build = folder / f"cmake-{kind}"
    # Flags that sanitizers or another build type brought along would be another library's.
    call([cmake, "-S", folder, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DKIND={kind}", "-DCMAKE_CXX_FLAGS=-O1"])
    call([cmake, "--build", build])
    check(build / "consumer", folder, f"find_package, {kind}", bad)


def with_pkg_config(kind, libraries, folder, compiler, bad):
    environment = {**os.environ, "PKG_CONFIG_PATH": str(libraries / "pkgconfig")}
    module = "plumbline" if kind == "shared" else "plumbline-static"
    flags = call(["pkg-config", "--cflags", "--libs", module], env=environment).split()
    program = folder / f"consumer-{kind}"
    call([compiler, "-std=c++20", "-O1", "main.cpp", "-o", program, *flags, "-pthread"], cwd=folder)
    check(program, folder, f"pkg-config, {kind}", bad, {"LD_LIBRARY_PATH": str(libraries)} if kind == "shared" else None)


def check_symbols(library, bad):
    names = [line.split(maxsplit=2)[2] for line in call(["nm", "-DC", "--defined-only", library]).splitlines()]
    ours = [name for name in names if "plumbline::" in name]
    print(f"{library.name}: shows {len(names)} symbols, {len(ours)} of plumbline, {library.stat().st_size / 1e6:.1f} MB")
    bad += [f"{library.name} shows {name}" for name in ours if INSIDE.search(name)]
    if not any("plumbline::Pipeline::process" in name for name in ours):
        bad.append(f"{library.name} does not show plumbline::Pipeline::process")
    wild = [name for name in names if re.match(r"(fmt|toml|tbb|xsimd|nlohmann|cuda)\b", name)]
    bad += [f"{library.name} shows {name}, of another library" for name in wild[:10]]


def main() -> int:
    build, cmake, compiler = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3]
    prefix, bad = build / "consumer" / "prefix", []
    shutil.rmtree(prefix, ignore_errors=True)
    for component in ("library", "development"):
        call([cmake, "--install", build, "--prefix", prefix, "--component", component])
    libraries = next(prefix.rglob("libplumbline.so")).parent
    check_symbols(next(libraries.glob("libplumbline.so.*.*.*")), bad)
    with tempfile.TemporaryDirectory(prefix="plumbline_consumer_") as temporary:
        folder = pathlib.Path(temporary) / "consumer"
        shutil.copytree(pathlib.Path(__file__).parent / "consumer", folder)
        for kind in ("shared", "static"):
            with_cmake(kind, prefix, folder, cmake, bad)
            with_pkg_config(kind, libraries, folder, compiler, bad)
    print("\n".join(bad + [f"{len(bad)} findings"]))
    return 1 if bad else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RuntimeError as error:
        sys.exit(str(error))
