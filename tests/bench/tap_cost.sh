#!/bin/bash
# What the tap costs per frame: time in a paired run, instructions by callgrind. Exit status 1 above 2 % of a frame's.
#   tests/bench/tap_cost.sh [BIN] [RECORDING]      default: build/release/bin tests/recordings/approach
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
bin=${1:-build/release/bin}
recording=${2:-tests/recordings/approach}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A third of a megabyte moved by one `rep movsb` counts as so many instructions with callgrind: vector moves are told apart.
export GLIBC_TUNABLES=glibc.cpu.x86_rep_movsb_threshold=1000000000

# instructions FUNCTION MODE: of all frames of one round
instructions() {
  valgrind --tool=callgrind --callgrind-out-file="$work/out" --toggle-collect="$1" "$bin/bench_tap" "$recording" "$2" 1 > "$work/row" 2> "$work/log" ||
    { cat "$work/log" >&2; return 1; }
  awk '/^(summary|totals):/ { total = $2 } END { print total }' "$work/out"
}

frame=$(instructions ninedot_measured_frame nothing)
count=$(cut -d ' ' -f 2 "$work/row")
echo "| per frame | time | of its 28.6 ms | of its processing | instructions | of its processing's |"
echo "|---|---|---|---|---|---|"
over=0
for mode in nothing some every; do
  read -r _ _ frame_us tap_us < <(env -u GLIBC_TUNABLES "$bin/bench_tap" "$recording" "$mode" 20)
  tap=$(instructions ninedot_measured_tap "$mode")
  awk -v mode="$mode" -v us="$tap_us" -v frame_us="$frame_us" -v tap="$tap" -v frame="$frame" -v n="$count" 'BEGIN {
    name["nothing"] = "nobody reads"; name["some"] = "somebody looks: the page"; name["every"] = "somebody records"
    printf "| %s | %.2f us | %.3f %% | %.2f %% | %.0f | %.2f %% |\n", name[mode], us, us / 285.71, 100 * us / frame_us, tap / n, 100 * tap / frame }'
  awk -v us="$tap_us" -v tap="$tap" -v frame="$frame" 'BEGIN { exit !(tap > 0.02 * frame || us > 0.02 * 28571) }' && over=1
done
awk -v us="$frame_us" -v frame="$frame" -v n="$count" 'BEGIN { printf "| the processing itself | %.1f us | %.1f %% | | %.0f | |\n", us, us / 285.71, frame / n }'
[[ $over -eq 0 ]] || { echo "tap_cost: more than 2 % of a frame's" >&2; exit 1; }
