#!/bin/bash
# The board image, booted in QEMU: serves poses with the configuration from its FAT partition, recovers from a crash, a hang and
# power cuts. Judges function, never speed.
#
#   tests/board/boot_test.sh [POWER-CUTS]     after ./dev image; default 3 power cuts
#
# NINEDOT_IMAGE: the folder with the image (default build/image; the Raspberry Pi 5's: build/image-pi5). QEMU's console is kept in build/image/boot_test/.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."

cuts=${1:-3} folder=${NINEDOT_IMAGE:-build/image} work=build/image/boot_test
fail() { echo "boot_test.sh: $*" >&2; exit 2; }
[[ $cuts =~ ^[0-9]+$ ]] || fail "how many power cuts? tests/board/boot_test.sh [POWER-CUTS]"
for tool in qemu-system-aarch64 mcopy fdtoverlay fdtput unsquashfs python3 ssh-keygen; do command -v "$tool" > /dev/null || fail "needs $tool: ./dev packages boot"; done
image=$(compgen -G "$folder/ninedot-arm64*.img" | head -n 1) || fail "no image in $folder: ./dev image"
for file in vmlinuz initrd.gz; do [[ -s $folder/$file ]] || fail "no $folder/$file: ./dev image"; done

rm -rf "$work"
mkdir -p "$work"
cp --sparse=always "$image" "$work/board.img"
tests/board/sbom_test.py "$folder"
cp "$folder/vmlinuz" "$folder/initrd.gz" "$work/"  # a new image may be made meanwhile
# Overlays are for boards that QEMU has not: they are tried on the boards' device trees.
mkdir "$work/trees"
mcopy -i "$work/board.img@@4M" '::*.dtb' "$work/trees/"
if [[ $image == *-pi5.img ]]; then tests/board/overlays_pi5_test.py "$work/trees"; else tests/board/overlays_test.py "$work/trees"; fi
# What a person would put on the FAT partition before the first boot: edited on a system with other line ends.
mcopy -i "$work/board.img@@4M" ::ninedot.toml "$work/ninedot.toml"
# Five frames a second: no more than an emulated board can take, so that what load takes from the service can be seen.
sed -i 's/^listen = .*/listen = "0.0.0.0"/; s/^rate_hz = .*/rate_hz = 5.0/; s/$/\r/' "$work/ninedot.toml"
printf '\r\n[tap]\r\nenabled = true\r\n[web]\r\nlisten = "0.0.0.0"\r\ntoken_file = "/etc/ninedot/web-token"\r\n' >> "$work/ninedot.toml"
printf '0123456789abcdef0123456789abcdef\r\n' > "$work/web-token"
printf 'cabinet-7\r\n' > "$work/hostname"
printf '[Match]\nType=ether\n\n[Network]\nDHCP=yes\nAddress=10.0.2.77/24\nNTP=10.0.2.2\n' > "$work/network"
printf 'country = DE\r\nname = Hall 7\r\npassword = boot test password\r\n' > "$work/wifi"
printf '8\r\n' > "$work/journal"
mcopy -i "$work/board.img@@4M" ::config.txt "$work/config.txt"
printf 'dtoverlay=camera-ov9821\r\n' >> "$work/config.txt"  # no such overlay
ssh-keygen -q -t ed25519 -N '' -C boot_test -f "$work/key"
cp "$work/key.pub" "$work/authorized_keys"
mcopy -o -i "$work/board.img@@4M" "$work"/{ninedot.toml,hostname,network,authorized_keys,web-token,config.txt,wifi,journal} ::
exec python3 tests/board/boot_test.py --work "$work" --kernel "$work/vmlinuz" --initrd "$work/initrd.gz" --power-cuts "$cuts"
