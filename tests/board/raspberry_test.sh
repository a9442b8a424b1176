#!/bin/bash
# What a Raspberry Pi's firmware would load from the FAT partition (U-Boot, device tree, command line), started on QEMU's Raspberry Pi 3: U-Boot starts
# system A from the SD card, which finds its root, takes the configuration over and starts the service. The firmware itself is not run.
#
#   tests/board/raspberry_test.sh     after ./dev image; takes 3 to 6 minutes
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."

folder=${NINEDOT_IMAGE:-build/image} work=build/image/raspberry_test limit_s=900
fail() { echo "raspberry_test.sh: $*" >&2; exit 2; }
for tool in qemu-system-aarch64 mcopy python3; do command -v "$tool" > /dev/null || fail "needs $tool: ./dev packages boot"; done
[[ -s $folder/ninedot-arm64.img ]] || fail "no $folder/ninedot-arm64.img: ./dev image"

rm -rf "$work"
mkdir -p "$work"
cp --sparse=always "$folder/ninedot-arm64.img" "$work/card.img"
truncate -s 1G "$work/card.img"  # cards come in powers of two
mcopy -i "$work/card.img@@4M" ::u-boot.bin ::bcm2837-rpi-3-b.dtb ::cmdline.txt "$work/"
# The service manager reports to the serial console instead of a screen that nobody sees. The watchdog stays off: arming it resets QEMU's
# board at once (its model of the power manager knows no time-out).
line=$(sed 's/console=tty1//; s/\bquiet\b//' "$work/cmdline.txt")
qemu-system-aarch64 -M raspi3b -kernel "$work/u-boot.bin" -dtb "$work/bcm2837-rpi-3-b.dtb" \
  -append "$line console=ttyAMA0,115200 loglevel=3 systemd.show_status=1 systemd.getty_auto=0 systemd.watchdog_sec=0" \
  -drive "file=$work/card.img,format=raw,if=sd" -serial "file:$work/console.log" -serial null \
  -display none -monitor none -no-reboot < /dev/null &
qemu=$!
trap 'kill -9 $qemu 2> /dev/null || true' EXIT

started=$SECONDS
said() { grep -q -a -E "$1" "$work/console.log" 2> /dev/null; }
until said 'Started .*ninedotd.service'; do
  kill -0 $qemu 2> /dev/null || { echo "FAILED: QEMU has ended: $work/console.log" >&2; exit 1; }
  ! said 'Failed to start .*ninedot|ninedot-init:' || { grep -a -E 'Failed|ninedot-init' "$work/console.log" >&2; exit 1; }
  [[ $((SECONDS - started)) -lt $limit_s ]] || { tail -n 5 "$work/console.log" >&2; echo "FAILED: no ninedotd after $limit_s s" >&2; exit 1; }
  sleep 2
done
said 'Finished .*ninedot-configure.service' || { echo "FAILED: the configuration was not taken over" >&2; exit 1; }
# U-Boot writes to a screen that nobody sees; what it did is on the card: this start is counted, in the second of the two copies.
left=$(python3 -c 'import sys; sys.path.insert(0, "tests/board"); import boot_state; print((boot_state.unpack(boot_state.read_copies(sys.argv[1])[1]) or (0, {}))[1].get("BOOT_A_LEFT"))' "$work/card.img")
[[ $left == 8 ]] || { echo "FAILED: U-Boot has not counted the start: BOOT_A_LEFT=$left" >&2; exit 1; }
took=$((SECONDS - started))
# And after it the system is kept, without a key for updates on the card: the first copy, written after the second, gives it nine starts again.
newest() { python3 -c 'import sys; sys.path.insert(0, "tests/board"); import boot_state; place, values = boot_state.newest(sys.argv[1]); print(place, values["BOOT_A_LEFT"])' "$work/card.img"; }
until [[ $(newest) == "0 9" ]]; do
  [[ $((SECONDS - started)) -lt $limit_s ]] || { echo "FAILED: the system is not kept" >&2; exit 1; }
  sleep 2
done
echo "ok: Raspberry Pi 3 (QEMU): system A by U-Boot, root from the SD card, configuration taken over, ninedotd started after $took s, the system kept after $((SECONDS - started)) s"
