#!/bin/bash
# The instructions of a frame on arm64, counted one by one under QEMU's user-mode emulator: those of a replay with more frames less those
# of one with fewer, so that what the program does at its start drops out. As root, after ./dev cross arm64; a quarter of an hour.
#
#   tests/bench/instructions_arm64.sh [--backports]
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
source toolchains/roots.sh

built=build/package-arm64${1:+-backports} recording=tests/recordings/positions
[[ $# -eq 0 || $* == --backports ]] || roots_fail "usage: tests/bench/instructions_arm64.sh [--backports]"
require_root
root=$(readlink "$built/root") || roots_fail "no $built: ./dev cross arm64 $*"
require_emulation arm64
work=$(mktemp -d build/instructions-XXXXXX)
trap 'rm -rf "$work" "$root/tmp/instructions"' EXIT

# Each picture so many times after itself, as one file: no picture format is unpacked.
video() {
  PYTHONPATH=tests/hil python3 -c '
import pathlib, sys
from png_grey import read_png_grey
pictures = [read_png_grey(path) for path in sorted(pathlib.Path(sys.argv[1]).iterdir())]
with open(sys.argv[3], "wb") as file:
    file.write(b"YUV4MPEG2 W%d H%d F35:1 Ip A1:1 Cmono\n" % pictures[0][:2])
    for _, _, luma in pictures:
        file.write((b"FRAME\n" + luma) * int(sys.argv[2]))
print(len(pictures))' "$recording/frames" "$1" "$work/$1.y4m"
}

# replayed TIMES: the log has a line for each instruction.
replayed() {
  mkfifo "$root/tmp/instructions"
  grep -c ^ "$root/tmp/instructions" > "$work/count" &
  in_root "$root" "$PWD" env QEMU_LOG=exec,nochain QEMU_SINGLESTEP=1 QEMU_ONE_INSN_PER_TB=1 QEMU_LOG_FILENAME=/tmp/instructions \
    "$built/bin/ninedot" replay "$work/$1.y4m" --camera "$recording/camera.yaml" --config "$work/config.toml" --out /dev/null 2> /dev/null
  wait
  rm "$root/tmp/instructions"
  cat "$work/count"
}

# per_frame WHAT TRACKING FEW: of FEW times each picture and twice as many
per_frame() {
  local few many pictures
  printf '[pose]\ntracking = %s\n' "$2" > "$work/config.toml"
  pictures=$(video "$3")
  video $((2 * $3)) > /dev/null
  few=$(replayed "$3") many=$(replayed $((2 * $3)))
  awk -v what="$1" -v more="$((many - few))" -v frames="$((pictures * $3))" 'BEGIN { printf "%s: %.2f million instructions\n", what, more / frames / 1e6 }'
}

per_frame "full search" false 1
# A picture is searched where it is new, and once more where the track has but one before it.
per_frame "followed frame" true 2
