#!/usr/bin/env bash
# On a machine with a GPU: what the CUDA backend does, in one call, and the first thing to run there (docs/cuda.md).
#   bench/gpu.sh BUILD [SEQUENCE]     BUILD: a release build's folder, SEQUENCE: a TUM folder to time whole runs on
# Runs every test of the stages and of the pipeline on the device, checks memory, races and barriers, times the stages by wall
# clock and by CUDA events, and compares and times whole runs on both backends.
set -euo pipefail
build=${1:?usage: bench/gpu.sh BUILD [SEQUENCE]} sequence=${2:-}
nvidia-smi --query-gpu=name,driver_version --format=csv,noheader
"$build/plumbline" backends
"$build/tests/test_backend" --gtest_brief=1 --gtest_filter='*cuda*'
"$build/tests/test_map" --gtest_brief=1 --gtest_filter='*cuda*'
"$build/tests/test_pipeline" --gtest_brief=1 --gtest_filter='*Cuda*'
if command -v compute-sanitizer >/dev/null; then
  for tool in memcheck racecheck synccheck; do
    for test in backend map; do
      compute-sanitizer --tool $tool --error-exitcode 1 "$build/tests/test_$test" --gtest_brief=1 --gtest_filter='*cuda*'
    done
  done
else
  echo "gpu.sh: no compute-sanitizer here; memory and races are not checked" >&2
fi
for preset in kinectfusion plumbline; do
  "$build/plumbline" bench --preset $preset --backend cuda
  "$build/plumbline" bench --preset $preset --backend cuda --set volume.resolution=1024
  "$build/plumbline" bench --preset $preset --backend cuda --width 1280 --height 960
  "$build/plumbline" bench --preset $preset --backend cpu
done
[[ -n $sequence ]] || exit 0
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for preset in kinectfusion plumbline; do
  for backend in cpu cuda; do
    echo "== $preset on $backend"
    "$build/plumbline" run "$sequence" --preset $preset --backend $backend -o "$out/$preset-$backend"
  done
  echo "== $preset: how far the two paths are apart"
  "$build/plumbline" eval ate "$out/$preset-cuda/trajectory.txt" "$out/$preset-cpu/trajectory.txt"
done
