#!/bin/bash
# Builds the programs and the Debian package for a board, with Debian 13's cross compiler in a root of its own.
#
#   toolchains/cross.sh arm64|armhf                as root; result: build/package-ARCH/package/ninedot_*_ARCH.deb
#   toolchains/cross.sh arm64|armhf --backports    for the libcamera of Debian 13's backports, which Raspberry Pi OS and the Raspberry Pi 5 have; result:
#                                                  build/package-ARCH-backports/package/ninedot_*+libcamera*_ARCH.deb
#
# The root is made once and again when the package list changes. NINEDOT_CACHE: where; NINEDOT_MIRROR: which archive;
# NINEDOT_JOBS: how many compilers at once. build/package-ARCH/root leads to the root: tests/board/cross_test.sh runs the programs there.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."
source toolchains/roots.sh

arch=${1:-}
case $arch in
  arm64) triplet=aarch64-linux-gnu ;;
  armhf) triplet=arm-linux-gnueabihf ;;
  *) roots_fail "say for which architecture: toolchains/cross.sh arm64|armhf [--backports]" ;;
esac
case ${2:-} in
  '') backports='' ;;
  --backports) backports=-backports ;;
  *) roots_fail "unknown '$2': toolchains/cross.sh $arch [--backports]" ;;
esac
require_root
command -v mmdebstrap > /dev/null || roots_fail "needs mmdebstrap: ./dev packages cross"
native=$(dpkg --print-architecture)
[[ $native != "$arch" ]] || roots_fail "this machine is $arch itself: ./dev package"

# The build's packages: libraries are the board's, tools are this machine's, the compiler is the cross compiler.
names=$(awk '($1 == "build" || $1 == "package") && $2 != "g++" { print $2 }' toolchains/packages.txt | sort -u)
libraries=$(grep '^lib' <<< "$names") tools=$(grep -v '^lib' <<< "$names")
key=$(sha256sum <<< "$ninedot_suite${backports:+ $backports_pin} $native $arch $names" | cut -c 1-12)
root=$ninedot_cache/cross-$arch$backports-$key

# Packages for all architectures take no suffix; only the root's own apt knows which they are.
# shellcheck disable=SC2016
install_libraries='
for name in $libraries; do
  if apt-cache show --no-all-versions "$name" | grep -q "^Architecture: all"; then echo "$name"; else echo "$name:$arch"; fi
done | xargs apt-get -q -y --no-install-recommends install'

if [[ ! -d $root ]]; then
  echo "== making the cross root for $arch: $root"
  started=$SECONDS
  mkdir -p "$ninedot_cache"
  rm -rf --one-file-system "$root.part"
  log=$ninedot_cache/cross-$arch$backports.log more=() sources=("$(debian_mirror)")
  if [[ -n $backports ]]; then more=("$backports_hook") sources+=("$(backports_source)"); fi
  # shellcheck disable=SC2016,SC2097,SC2098
  arch=$arch libraries=${libraries//$'\n'/ } script=$install_libraries backports_pin=$backports_pin new_root --variant=minbase \
    --architectures="$native,$arch" --include="crossbuild-essential-$arch,${tools//$'\n'/,}" \
    --customize-hook='chroot "$1" env arch="$arch" libraries="$libraries" DEBIAN_FRONTEND=noninteractive sh -ec "$script"' \
    "${more[@]}" "$ninedot_suite" "$root.part" "${sources[@]}" > "$log" 2>&1 < /dev/null || root_failed "the cross root" "$log" "$ninedot_suite$backports"
  mv "$root.part" "$root"
  echo "== made in $((SECONDS - started)) s, $(du -sh "$root" | cut -f 1)"
fi

preset=package-$arch$backports
# Headers of another root may be older than what was built with those of the last one: nothing of that is kept.
[[ $(readlink "build/$preset/root") == "$root" ]] || rm -rf "build/$preset"
mkdir -p "build/$preset"
ln -sfn "$root" "build/$preset/root"
SOURCE_DATE_EPOCH=$(source_date_epoch)
export SOURCE_DATE_EPOCH
started=$SECONDS
# shellcheck disable=SC2016
in_root "$root" "$PWD" bash -ec '
  preset=$1 jobs=$2 backports=$4
  export DEB_HOST_ARCH=$3
  # Above the package for the release of the same version, below that of the next one.
  revision=1${backports:++$(dpkg-query -W -f "\${Depends}" "libcamera-dev:$3" | cut -d " " -f 1)}
  cmake --preset "$preset" -DCMAKE_CXX_FLAGS="-ffile-prefix-map=/ninedot=." ${backports:+-DNINEDOT_PACKAGE_REVISION="$revision"} > /dev/null
  cmake --build --preset "$preset" -j "$jobs" --target ninedot ninedotd ninedot-web
  rm -f "build/$preset"/package/*.deb
  cmake --build --preset "$preset" --target package
' cross "$preset" "${NINEDOT_JOBS:-$(nproc)}" "$arch" "$backports" > "build/cross-$arch$backports.log" 2>&1 ||
  { tail -n 40 "build/cross-$arch$backports.log" >&2; roots_fail "the cross build failed; its whole output: build/cross-$arch$backports.log"; }

# shellcheck disable=SC2012
made=$(ls "build/$preset"/package/ninedot_*_"$arch".deb)
file -b "build/$preset/bin/ninedotd" | grep -q 'ARM' || roots_fail "build/$preset/bin/ninedotd is not a program for ARM ($triplet)"
echo "== $made ($(du -h "$made" | cut -f 1)), built in $((SECONDS - started)) s"
