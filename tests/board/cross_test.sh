#!/bin/bash
# The cross-built programs compute what the native ones do: a recording replayed under QEMU's user-mode emulator in the
# root that they were built in, and by this machine's own build, gives the same poses.
#
#   tests/board/cross_test.sh arm64|armhf [NATIVE]    as root, after ./dev cross; NATIVE: default build/release/bin/ninedot
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
source toolchains/roots.sh

arch=${1:-arm64} native=${2:-build/release/bin/ninedot}
recording=tests/recordings/approach
require_root
[[ -x $native ]] || roots_fail "no program $native: ./dev build"
[[ -x build/package-$arch/bin/ninedot ]] || roots_fail "no program build/package-$arch/bin/ninedot: ./dev cross $arch"
root=$(readlink "build/package-$arch/root") || roots_fail "build/package-$arch does not say its root: ./dev cross $arch"
require_emulation "$arch"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$native" replay "$recording" --out "$work/native.csv" > /dev/null
in_root "$root" "$PWD" "build/package-$arch/bin/ninedot" replay "$recording" --out /tmp/cross.csv > /dev/null
mv "$root/tmp/cross.csv" "$work/$arch.csv"
python3 tests/board/compare_poses.py "$work/native.csv" "$work/$arch.csv"
