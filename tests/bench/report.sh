#!/bin/bash
# Prints the measured accuracy and speed, and the table of what they have to reach.
#   tests/bench/report.sh BIN_FOLDER RECORDINGS      (called by ./dev bench)
set -euo pipefail
bin=$1 recordings=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# instructions full|tracking|apriltag: mean instructions per frame of detection and pose, in millions.
instructions() {
  local frames
  frames=$(valgrind --tool=callgrind --callgrind-out-file="$work/callgrind.$1" --toggle-collect=ninedot_measured \
    "$bin/bench_rivals" "$recordings" --once "$1" 2> "$work/callgrind.log" | cut -d ' ' -f 1) || { cat "$work/callgrind.log" >&2; return 1; }
  awk -v frames="$frames" '/^(summary|totals):/ { total = $2 } END { printf "%.2f", total / frames / 1e6 }' "$work/callgrind.$1"
}

echo "## Accuracy: $recordings"
echo
"$bin/bench_cases" "$recordings" --rows "$work/rows"
echo
echo "## Speed: $(awk -F ': ' '/^model name/ { print $2; exit }' /proc/cpuinfo)"
echo
"$bin/bench_rivals" "$recordings" --rows "$work/rows"
if command -v valgrind > /dev/null; then
  full=$(instructions full) tracking=$(instructions tracking) apriltag=$(instructions apriltag)
  kept=$(awk -v full="$full" -v tracking="$tracking" 'BEGIN { print full <= 5 && tracking <= 1.2 ? "yes" : "**no**" }')
  echo "| speed | full search <= 5 million instructions, followed frame <= 1.2 million (callgrind) | $full, $tracking (AprilTag 3: $apriltag) | $kept |" >> "$work/rows"
  followed=$("$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/landmark_cost.sh" | awk -F '|' 'END { printf "%d", $3 }')
  kept=$(awk -v followed="$followed" 'BEGIN { print followed <= 300000 ? "yes" : "**no**" }')
  echo "| speed | a further landmark that is followed in a room <= 300,000 instructions (\`landmark_cost.sh\`) | $followed | $kept |" >> "$work/rows"
else
  echo "| speed | instructions per frame (callgrind) | valgrind is not installed | - |" >> "$work/rows"
fi
echo
echo "## What must be reached"
echo
echo "| set | to reach | measured | ok? |"
echo "|---|---|---|---|"
cat "$work/rows"
