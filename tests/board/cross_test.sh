#!/bin/bash
# The cross-built programs compute what the native ones do: the bundled recordings, replayed under QEMU's user-mode emulator in the
# root that they were built in, and by this machine's own build, give the same poses. And the package asks for the libcamera
# that it was built with, and for no other.
#
#   tests/board/cross_test.sh arm64|armhf [--backports] [NATIVE]    as root, after ./dev cross; NATIVE: default build/release/bin/ninedot
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
source toolchains/roots.sh

arch=${1:-arm64} backports=''
[[ $# -eq 0 ]] || shift
if [[ ${1:-} == --backports ]]; then backports=-backports; shift; fi
native=${1:-build/release/bin/ninedot} built=build/package-$arch$backports
recordings=(approach positions tilt occlusion lowlight distorted)
require_root
[[ -x $native ]] || roots_fail "no program $native: ./dev build"
[[ -x $built/bin/ninedot ]] || roots_fail "no program $built/bin/ninedot: ./dev cross $arch${backports:+ --backports}"
root=$(readlink "$built/root") || roots_fail "$built does not say its root: ./dev cross $arch${backports:+ --backports}"
require_emulation "$arch"

fail() { echo "FAILED: $*" >&2; exit 1; }
deb=$(compgen -G "$built/package/ninedot_*_$arch.deb") || roots_fail "no package in $built/package: ./dev cross $arch${backports:+ --backports}"
version=$(dpkg-deb -f "$deb" Version) asked=$(dpkg-deb -f "$deb" Depends | grep -o 'libcamera[0-9.]*' | sort -u)
# shellcheck disable=SC2016
read -r there libcamera _ < <(in_root "$root" "$PWD" dpkg-query -W -f '${Version} ${Depends}\n' "libcamera-dev:$arch")
[[ $there == *~bpo* ]] && from=-backports || from=''
[[ $from == "$backports" ]] || fail "$root has libcamera $there, not that of $ninedot_suite$backports"
[[ $asked == "$libcamera" ]] || fail "$deb asks for ${asked:-no libcamera}, and was built with $libcamera"
# That for backports has a version of its own, above that for the release and below the next one.
plain=${version%%+*}
[[ $version == "$plain${backports:++$libcamera}" ]] || fail "version $version of a package for $libcamera"
echo "ok: version $version, for $libcamera"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
for recording in "${recordings[@]}"; do
  "$native" replay "tests/recordings/$recording" --out "$work/native.csv" > /dev/null
  in_root "$root" "$PWD" "$built/bin/ninedot" replay "tests/recordings/$recording" --out /tmp/cross.csv > /dev/null
  mv "$root/tmp/cross.csv" "$work/$arch.csv"
  printf '%s: ' "$recording"
  python3 tests/board/compare_poses.py "$work/native.csv" "$work/$arch.csv" || status=1
done
exit "$status"
