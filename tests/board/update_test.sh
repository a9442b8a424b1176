#!/bin/bash
# Updates of the board image in QEMU, started by Debian's U-Boot as a board is: good ones, refused ones, one that never works, power cuts in between.
#
#   tests/board/update_test.sh [POWER-CUTS]     after ./dev image; default 2 power cuts in each phase; takes 20 to 40 minutes
#
# NINEDOT_IMAGE: the folder with the image (default build/image; the Raspberry Pi 5's: build/image-pi5). NINEDOT_TRIAL_S: how long a good system may take to prove itself, where the emulation is
# slow (default 240; the one that never works has the two minutes that boards have). Keys are made anew each time. What was said is kept in
# build/image/update_test/.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."

cuts=${1:-2} folder=${NINEDOT_IMAGE:-build/image} work=build/image/update_test
fail() { echo "update_test.sh: $*" >&2; exit 2; }
[[ $cuts =~ ^[0-9]+$ ]] || fail "how many power cuts? tests/board/update_test.sh [POWER-CUTS]"
[[ $EUID -eq 0 ]] || fail "needs root to keep the owners of a root's files"
for tool in qemu-system-aarch64 mcopy mkfs.vfat fdtput unsquashfs mksquashfs python3 openssl rauc; do command -v "$tool" > /dev/null || fail "needs $tool: ./dev packages boot image"; done
image=$(compgen -G "$folder/ninedot-arm64*.img" | head -n 1) || fail "no image in $folder: ./dev image"
[[ -s $folder/u-boot.bin ]] || fail "no $folder/u-boot.bin: ./dev image"

tests/board/boot_script_test.py "$folder"
rm -rf "$work"
mkdir -p "$work"
cp --sparse=always "$image" "$work/board.img"
cp "$folder/u-boot.bin" "$work/"
for who in owner stranger; do
  openssl req -x509 -newkey rsa:2048 -nodes -days 30 -subj "/CN=update test $who" -keyout "$work/$who.key" -out "$work/$who.pem" 2> /dev/null
done
mcopy -i "$work/board.img@@4M" ::ninedot.toml "$work/ninedot.toml"
# Five frames a second: what is tried here is not their speed, and an emulated board has enough to do.
sed -i 's/^listen = .*/listen = "0.0.0.0"/; s/^rate_hz = .*/rate_hz = 5.0/' "$work/ninedot.toml"
cp "$work/owner.pem" "$work/update-keyring.pem"
mcopy -o -i "$work/board.img@@4M" "$work"/{ninedot.toml,update-keyring.pem} ::

# Other systems, made of the image's own: one that says another version, one that says another kind of board, and one whose service never starts.
first=$(python3 -c 'import sys; sys.path.insert(0, "tests/board"); import qemu_board; print(qemu_board.partition(sys.argv[1], 2)[0])' "$work/board.img")
unsquashfs -q -n -o "$first" -d "$work/root" "$work/board.img" > /dev/null
# bundle NAME: of $work/root, by the owner.
bundle() {
  sed -i "s/^IMAGE_VERSION=.*/IMAGE_VERSION=test-$1/" "$work/root/usr/lib/os-release"
  mksquashfs "$work/root" "$work/root.squashfs" -comp zstd -Xcompression-level 3 -noappend -no-progress -quiet > /dev/null
  cp --sparse=always "$image" "$work/$1.img"
  dd if="$work/root.squashfs" of="$work/$1.img" bs=1M oflag=seek_bytes seek="$first" conv=notrunc status=none
  toolchains/bundle.sh "$work/owner.key" "$work/owner.pem" "$work/$1.img" "$work/$1.raucb"
}
bundle good
toolchains/bundle.sh "$work/stranger.key" "$work/stranger.pem" "$work/good.img" "$work/stranger.raucb"
# One whose contents were changed after it was signed, in the middle of the root.
cp "$work/good.raucb" "$work/changed.raucb"
printf 'changed' | dd of="$work/changed.raucb" bs=1 seek=$(($(stat -c %s "$work/good.raucb") / 2)) conv=notrunc status=none
sed -i.kept 's/^compatible=.*/&-other/' "$work/root/etc/rauc/system.conf"
bundle other
mv "$work/root/etc/rauc/system.conf.kept" "$work/root/etc/rauc/system.conf"
mkdir -p "$work/root/etc/systemd/system/ninedotd.service.d"
printf '[Service]\nExecStartPre=/bin/false\n' > "$work/root/etc/systemd/system/ninedotd.service.d/never.conf"
bundle never
rm -rf "$work/root" "$work/root.squashfs" "$work"/{good,other,never}.img

# They come on a USB stick, which is what QEMU's second disk stands for.
truncate -s 2G "$work/stick.img"
mkfs.vfat -F 32 -n UPDATES "$work/stick.img" > /dev/null
mcopy -i "$work/stick.img" "$work"/*.raucb ::
rm "$work"/*.raucb
exec python3 tests/board/update_test.py --work "$work" --loader "$work/u-boot.bin" --stick "$work/stick.img" --power-cuts "$cuts" --trial-s "${NINEDOT_TRIAL_S:-240}"
