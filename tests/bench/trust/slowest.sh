#!/bin/bash
# slowest.sh [--frames N] [--seed N] [--count N] [--only TEXT]: the instructions (callgrind) of the pictures that took
# longest in the trust bench, of those of usual pictures, and of more and more dots at random. Exit status 1: the slowest
# takes more than six times the usual one.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../.." && pwd)
bin=$root/build/release/bin
frames=10 seed=1 count=20 only=
while [[ $# -ge 2 ]]; do
  case $1 in
    --frames) frames=$2 ;;
    --seed) seed=$2 ;;
    --count) count=$2 ;;
    --only) only=$2 ;;
    *) break ;;
  esac
  shift 2
done
[[ $# -eq 0 ]] || { echo "slowest.sh: '$1' is none of --frames N, --seed N, --count N, --only TEXT" >&2; exit 2; }
command -v valgrind > /dev/null || { echo "slowest.sh: valgrind is missing: ./dev packages bench" >&2; exit 2; }
[[ -x $bin/trust && -x $bin/ninedot ]] || { echo "slowest.sh: build first: ./dev build" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/one/frames" "$work/slow" "$work/usual" "$work/dots"
printf '[pose]\ntracking = false\n' > "$work/search.toml"
cat > "$work/one/camera.yaml" << 'EOF'
image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [720, 0, 319.5, 0, 720, 239.5, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
EOF

# Millions of instructions of one full search.
millions() {
  cp "$1" "$work/one/frames/000000.png"
  valgrind --tool=callgrind --collect-atstart=no --toggle-collect='ninedot::Localiser::process*' \
    --callgrind-out-file="$work/callgrind" "$bin/ninedot" replay "$work/one" --config "$work/search.toml" > /dev/null 2> "$work/log" ||
    { cat "$work/log" >&2; return 1; }
  awk '/Collected/ { printf "%.2f", $4 / 1e6 }' "$work/log"
}

# A limit that is passed is the bench's to say.
"$bin/trust" --only "$only" --frames "$frames" --seed "$seed" --save "$work/slow" --slowest "$count" --out "$work/page" 2> /dev/null || true
"$bin/trust" --only 'even light' --frames 20 --seed "$seed" --save-all "$work/usual" --out "$work/page" 2> /dev/null || true
for picture in "$work"/usual/*.png; do millions "$picture"; echo; done | sort -n > "$work/usual.txt"
usual=$(sed -n "$(( ($(wc -l < "$work/usual.txt") + 1) / 2 ))p" "$work/usual.txt")
for picture in "$work"/slow/*.png; do echo "$(millions "$picture") $(basename "$picture" .png)"; done | sort -n -r > "$work/slow.txt"
awk -v usual="$usual" 'BEGIN { print "| million instructions | of the usual | picture |\n|---|---|---|"; printf "| %.2f | 1 | usual: a landmark, searched everywhere (median) |\n", usual }
  { printf "| %.2f | %.2f | %s |\n", $1, $1 / usual, $2; if (NR == 1) slowest = $1 / usual } END { exit slowest > 6 }' "$work/slow.txt"
