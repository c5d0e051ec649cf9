#!/usr/bin/env bash
# The table of simulated sequences in docs/results.md: real hand motion through simulated scenes, one row a run.
#
#   bench/simulated_sequences.sh [-p PRESET] [-f MAX_FRAMES] [-k] [-o DIR] [-- RUN OPTIONS…] > table.md
#
# SCENES, SPEEDS and SEQUENCES (environment) narrow it down. Needs the trajectories of ../shared/data, or PLUMBLINE_DATA.
# Images are deleted after each run unless -k is given.
set -euo pipefail
root=$(dirname "$(dirname "$(readlink -f "$0")")")
program=${PLUMBLINE:-$root/build/release/plumbline}
data=${PLUMBLINE_DATA:-$root/../shared/data}/trajectories/groundtruth
preset=kinectfusion frames=0 keep=0 work=$root/build/simulated
while getopts p:f:ko: option; do
  case $option in
    p) preset=$OPTARG ;;
    f) frames=$OPTARG ;;
    k) keep=1 ;;
    o) work=$OPTARG ;;
    *) exit 2 ;;
  esac
done
shift $((OPTIND - 1))
[[ -x $program ]] || { echo "$0: no program at $program; ./dev build makes it, PLUMBLINE names another" >&2; exit 1; }
[[ -d $data ]] || { echo "$0: no trajectories at $data; PLUMBLINE_DATA names their data folder" >&2; exit 1; }
read -ra scenes <<< "${SCENES:-desk room}"
read -ra speeds <<< "${SPEEDS:-1 2}"
read -ra sequences <<< "${SEQUENCES:-$(cd "$data" && printf '%s ' *.txt)}"

# One figure out of a JSON file, by its keys.
figure() { python3 -c '
import json, sys
value = json.load(open(sys.argv[1]))
for key in sys.argv[2].split("."):
    value = value[int(key)] if isinstance(value, list) else value.get(key) if value else None
print("–" if value is None else f"{value * float(sys.argv[3]):{sys.argv[4]}}")' "$@"; }

median_inliers() { python3 -c '
import csv, statistics, sys
rows = [float(r["inlier_fraction"]) for r in csv.DictReader(open(sys.argv[1])) if r["status"] == "tracked"]
print(f"{100 * statistics.median(rows):.0f}" if rows else "–")' "$1"; }

echo "Preset \`$preset\`${*:+, \`$*\`}; ATE RMSE in m, surface error (mesh to truth) in mm, inliers in % of the readings."
echo
echo "| scene | path | speed | frames | lost | ATE | surface mean | median | inliers (median) |"
echo "|---|---|---|---|---|---|---|---|---|"
for scene in "${scenes[@]}"; do
  for speed in "${speeds[@]}"; do
    for name in "${sequences[@]}"; do
      name=${name%.txt}
      folder=$work/$scene-$name-$speed
      "$program" simulate --scene "$scene" --trajectory "$data/$name.txt" --speed "$speed" --frames "$frames" \
        --no-color --quiet -o "$folder/sequence"
      row="| $scene | ${name/freiburg/fr} | $speed |"
      # Volume and placement as in the paper's table: 6 m, the camera inside.
      if "$program" run "$folder/sequence" -o "$folder/run" --preset "$preset" --quiet \
        --set volume.side=6 --set volume.offset=-0.4 "$@" 2> "$folder/error.txt"; then
        "$program" eval surface "$folder/run/mesh.ply" "$folder/sequence/scene.ply" \
          --trajectory "$folder/run/trajectory.txt" --samples 50000 --json > "$folder/surface.json"
        summary=$folder/run/summary.json
        echo "$row $(figure "$summary" frames 1 .0f) | $(figure "$summary" lost 1 .0f) |" \
          "$(figure "$summary" ate.rmse_m 1 .4f) | $(figure "$folder/surface.json" accuracy_m.mean 1e3 .1f) |" \
          "$(figure "$folder/surface.json" accuracy_m.median 1e3 .1f) | $(median_inliers "$folder/run/frames.csv") |"
      else
        echo "$row – | all | – | – | – | – |"
      fi
      ((keep)) || rm -rf "$folder/sequence/depth"
    done
  done
done
