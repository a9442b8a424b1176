#!/bin/bash
# landmark_cost.sh [RECORDING CONFIG]: the instructions (callgrind) that each landmark takes which is followed in a room,
# colours and the pose in the world not counted. Default: three landmarks, 2.5 m before a simulated camera that drives past
# them at 0.3 m/s; exit status 1 above 550,000 there. A recording of one's own says what one's own room takes.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
bin=build/release/bin
[[ $# -eq 0 || $# -eq 2 ]] || { echo "usage: landmark_cost.sh [RECORDING CONFIG]" >&2; exit 2; }
command -v valgrind > /dev/null || { echo "landmark_cost.sh: valgrind is missing: ./dev packages bench" >&2; exit 2; }
[[ -x $bin/ninedot ]] || { echo "landmark_cost.sh: build first: ./dev build" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
recording=${1:-$work/room} config=${2:-$work/map.toml} most=
if [[ $# -eq 0 ]]; then
  most=550000
  for place in "1 -700.0 1300.0" "2 0.0 1100.0" "3 700.0 1300.0"; do
    read -r id x z <<< "$place"
    printf '[[landmarks]]\nid = %s\nposition_mm = [%s, 0.0, %s]\n' "$id" "$x" "$z"
  done > "$config"
  {
    printf '[camera]\nsource = "simulated"\nwidth_px = 640\nheight_px = 480\nrate_hz = 30.0\n'
    cat "$config"
    printf '[simulation]\nduration_s = 2.0\n'
    for moment in "0.0 -300.0" "2.0 300.0"; do
      read -r t x <<< "$moment"
      printf '[[simulation.robot]]\nt_s = %s\nx_mm = %s\ny_mm = 2500.0\nz_mm = 1100.0\nheading_deg = -90.0\n' "$t" "$x"
    done
  } > "$work/camera.toml"
  "$bin/ninedot" record --config "$work/camera.toml" --out "$recording" --frames 40 > /dev/null
fi
valgrind --tool=callgrind --callgrind-out-file="$work/out" \
  "$bin/ninedot" replay "$recording" --config "$config" --out /dev/null > /dev/null 2> "$work/log" || { grep "^ninedot: " "$work/log" >&2; exit 1; }
# The line above the function's own says who called it, how often, and what that took.
callgrind_annotate --tree=caller --inclusive=yes "$work/out" | grep -B 1 '\*  .*LandmarkSeeker::follow_outlines' > "$work/rows" ||
  { echo "landmark_cost.sh: no landmark is followed: is it a room of several, with a map?" >&2; exit 1; }
awk -v most="$most" '/ < / { instructions = $1; gsub(",", "", instructions); match($0, /\([0-9,]+x\)/); times = substr($0, RSTART + 1, RLENGTH - 3); gsub(",", "", times)
    each = instructions / times
    print "| followed | instructions of each |\n|---|---|"; printf "| %d | %.0f |\n", times, each }
  END { exit !times || (most != "" && each > most) }' "$work/rows"
