#!/bin/bash
# An update says for which kind of board it is, as its image does: RAUC refuses it on another (update_test.sh tries that on a board in QEMU).
# On small images made here, in seconds.
#
#   tests/board/bundle_test.sh     needs rauc, squashfs-tools, fdisk, openssl
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
openssl req -x509 -newkey rsa:2048 -nodes -days 1 -subj "/CN=bundle test" -keyout "$work/key.pem" -out "$work/cert.pem" 2> /dev/null

# image NAME: partitions as toolchains/image.sh lays them, the second with a root that has this compatible.
image() {
  mkdir -p "$work/root/etc/rauc" "$work/root/usr/lib"
  echo "IMAGE_VERSION=1" > "$work/root/usr/lib/os-release"
  head -c 100000 /dev/urandom > "$work/root/content"  # RAUC takes nothing that is next to nothing
  sed "s/^compatible=.*/${1:+compatible=$1}/" systemd/image/root/etc/rauc/system.conf > "$work/root/etc/rauc/system.conf"
  mksquashfs "$work/root" "$work/root.squashfs" -noappend -no-progress -quiet > /dev/null
  rm -f "$work/board.img"
  truncate -s 16M "$work/board.img"
  printf '%s\n' 'label: dos' 'start=1MiB, size=1MiB, type=c' 'start=2MiB, size=4MiB' 'start=6MiB, size=1MiB' 'start=7MiB, size=9MiB, type=5' \
    'start=8MiB, size=2MiB' 'start=11MiB, size=1MiB' 'start=13MiB, size=1MiB' | sfdisk -q "$work/board.img"
  dd if="$work/root.squashfs" of="$work/board.img" bs=1M seek=2 conv=notrunc status=none
}

for name in ninedot-arm64 ninedot-arm64-pi5; do
  image "$name"
  toolchains/bundle.sh "$work/key.pem" "$work/cert.pem" "$work/board.img" "$work/board.raucb" > /dev/null
  says=$(rauc info --keyring="$work/cert.pem" --output-format=shell "$work/board.raucb" 2> /dev/null | sed -n "s/^RAUC_MF_COMPATIBLE='\(.*\)'/\1/p")
  [[ $says == "$name" ]] || fail "the bundle of an image for $name is for '$says'"
  echo "ok: a bundle of an image for $name is for it alone"
done
head -c 100000 /dev/urandom > "$work/board.img"
if said=$(toolchains/bundle.sh "$work/key.pem" "$work/cert.pem" "$work/board.img" "$work/other.raucb" 2>&1); then fail "a bundle of what is no image"; fi
[[ $said == *"is no image of a board"* && $(wc -l <<< "$said") -eq 1 && ! -e $work/other.raucb ]] || fail "$said"
echo "ok: what is no image gives no bundle, and one line that says so"
image ''
if said=$(toolchains/bundle.sh "$work/key.pem" "$work/cert.pem" "$work/board.img" "$work/board.raucb" 2>&1); then fail "a bundle of an image that does not say for which boards it is"; fi
[[ $said == *"does not say for which boards"* && $(wc -l <<< "$said") -eq 1 ]] || fail "$said"
echo "ok: an image that does not say for which boards it is gives no bundle, and one line that says so"
