#!/usr/bin/env python3
"""Deliberate faults in the CUDA backend, each of which the tests on the simulated device must find (docs/cuda.md).

Each fault is made in a copy of src/backend/cuda, compiled and linked into a library of the simulated device, with which
the tests then run. Usage: check_mutations.py BUILD [NAME…]; BUILD is a release build's folder where test_simulated_device
was built. Exits with 1 if a fault is not found, or if the tests fail without one.
"""

import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

LAUNCH, CUDA = "launch.cuh", "cuda.cu"
# Name, file, what stands there (once), what stands there instead.
FAULTS = [
    ("sums read before all warps wrote them", LAUNCH,
     "  __syncthreads();\n\n  if (thread < N) {", "  if (thread < N) {"),
    ("the next chunk's sums written too early", LAUNCH,
     "  __syncthreads();  // the next chunk writes warp_sums\n", ""),
    ("storage of a warp's sum used again without a barrier", LAUNCH,
     "    if (thread % kWarp == 0) warp_sums[slot][warp] = sum;\n    __syncwarp();\n",
     "    if (thread % kWarp == 0) warp_sums[slot][warp] = sum;\n"),
    ("chunks folded before all blocks are through", LAUNCH,
     "    grid.sync();\n    if (blockIdx.x == 0) {", "    if (blockIdx.x == 0) {"),
    ("the next pass begun before it is known", LAUNCH,
     "advance_registration(registration, block.sums, bin, state);\n    }\n    grid.sync();\n",
     "advance_registration(registration, block.sums, bin, state);\n    }\n"),
    ("median read before it is found", LAUNCH, "  __syncthreads();\n  return found;", "  return found;"),
    ("blocks count without atomics", LAUNCH,
     "atomicAdd(histogram + bin, counts[bin]);", "histogram[bin] += counts[bin];"),
    ("spans widened without atomics", LAUNCH,
     "atomicMin(reinterpret_cast<int*>(spans.nearest + tile), kernels::bits_from_float(near));",
     "if (near < spans.nearest[tile]) spans.nearest[tile] = near;"),
    ("sums that begin with one", LAUNCH, "for (float& slot : sums.slots) slot = 0;", "for (float& slot : sums.slots) slot = 1;"),
    ("counts that stay for the next pass", LAUNCH, "      clear_bins(histogram, bins);\n", ""),
    ("a grid without its last blocks", CUDA,
     "dim3(static_cast<unsigned>(divide_up(width, kTileColumns))", "dim3(static_cast<unsigned>(width / kTileColumns)"),
    ("one pixel beyond the image", LAUNCH, "if (x < width && y < height) kernel", "if (x < width && y <= height) kernel"),
    ("shared memory for two bins less", CUDA,
     "static_cast<std::size_t>(registration.rules.bins + 2)", "static_cast<std::size_t>(registration.rules.bins)"),
    ("a copy used before it arrived", CUDA, "    work.wait_for(slot.arrived);\n", ""),
    ("pinned memory written while it is copied", CUDA,
     '    if (slot.pinned) check(cudaEventSynchronize(slot.taken), "waiting for an upload");\n', ""),
    ("a download that nobody waits for", CUDA,
     'cudaMemcpyDeviceToHost, stream_), "download");\n    stream_.wait();', 'cudaMemcpyDeviceToHost, stream_), "download");'),
    ("sums read before the device wrote them", CUDA,
     "sums_.get(), counts_.get());\n  stream_.wait();", "sums_.get(), counts_.get());"),
    ("a histogram that nobody cleared", CUDA, "if (!histogram_is_clear_) check", "if (histogram_is_clear_) check"),
    ("sums of chunks in the host's memory", CUDA,
     "register_frame, registration, state, partial, histogram);",
     "register_frame, registration, state, new double[std::size_t{1} << 20], histogram);"),
    ("an error that is told twice", CUDA,
     "  cudaGetLastError();  // the error is told here and must not stick\n  if (status == cudaErrorMemoryAllocation)",
     "  if (status == cudaErrorMemoryAllocation)"),
    ("a launch without a block", CUDA, "  if (shape.blocks.x == 0 || shape.blocks.y == 0) return;\n", ""),
]
TESTS = "*Simulated*:-*SimulatedMistake*:SimulatedDevice.*"


def compile_command(build: pathlib.Path):
    for entry in json.loads((build / "compile_commands.json").read_text()):
        if entry["file"].endswith("simulated_device/cuda_backend.cpp"):
            return entry["directory"], shlex.split(entry["command"])
    sys.exit(f"{build} has no command for simulated_device/cuda_backend.cpp")


def folder_of_objects(build: pathlib.Path) -> pathlib.Path:
    return build / "tests/CMakeFiles/plumbline_simulated_device.dir/simulated_device"


def library(build: pathlib.Path, sources: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """The simulated device with the backend of `sources`."""
    directory, command = compile_command(build)
    compiled, linked = folder / "cuda_backend.o", folder / "libplumbline_simulated_device.so"
    command[command.index("-o") + 1] = str(compiled)
    command.append("-Wno-error")  # a fault may leave a variable that nobody uses
    first = next(i for i, word in enumerate(command) if word.startswith("-I"))
    command.insert(first, f"-I{sources}")
    subprocess.run(command, cwd=directory, check=True)
    objects = [str(o) for o in sorted(folder_of_objects(build).glob("*.o"))
               if o.name != "cuda_backend.cpp.o" and o.name != "faulty_kernels.cpp.o"]
    compiler = next(word for word in command if word.endswith("++"))
    subprocess.run([compiler, "-shared", f"-Wl,-soname,{linked.name}", "-Wl,-Bsymbolic-functions", "-o", linked, *objects,
                    str(folder_of_objects(build) / "faulty_kernels.cpp.o"), compiled, "-lboost_context", "-ldl"], check=True)
    return linked


def first_failure(build: pathlib.Path, linked: pathlib.Path):
    """What the tests say first, or None if they pass."""
    run = subprocess.run([build / "tests/test_simulated_device", f"--gtest_filter={TESTS}", "--gtest_fail_fast", "--gtest_brief=1"],
                         env={**os.environ, "LD_PRELOAD": str(linked)}, capture_output=True, text=True, errors="replace", timeout=600)
    if run.returncode == 0:
        return None
    lines = [line.strip() for line in (run.stdout + run.stderr).splitlines()]
    # What the device says comes as "Failed" and a sentence; it tells more than what the fault led to.
    told = [lines[i + 1] for i, line in enumerate(lines[:-1]) if line == "Failed"]
    failed = [lines[i + 1] for i, line in enumerate(lines[:-1]) if line.endswith("Failure")]
    return (told or failed or [line for line in lines if line] or [f"exit {run.returncode}"])[0][:160]


def main() -> int:
    build, wanted = pathlib.Path(sys.argv[1]).absolute(), sys.argv[2:]
    root = pathlib.Path(__file__).parent.parent.parent
    missed = 0
    for name, file, before, after in [("none", LAUNCH, "", ""), *FAULTS]:
        if wanted and name not in wanted:
            continue
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as temporary:
            sources = pathlib.Path(temporary) / "src"
            shutil.copytree(root / "src/backend/cuda", sources / "backend/cuda")
            changed = sources / "backend/cuda" / file
            text = changed.read_text(encoding="utf-8")
            if before and text.count(before) != 1:
                sys.exit(f"{name}: {file} has {text.count(before)} places like it")
            changed.write_text(text.replace(before, after) if before else text, encoding="utf-8")
            said = first_failure(build, library(build, sources, pathlib.Path(temporary)))
        is_right = (said is None) == (name == "none")
        missed += not is_right
        print(f"{'ok    ' if is_right else 'WRONG '} {name} ({time.monotonic() - began:.0f} s): {said or 'nothing found'}", flush=True)
    print(f"{missed} of {len(FAULTS)} faults are not found" if missed else f"all of {len(wanted) or len(FAULTS)} faults are found")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
