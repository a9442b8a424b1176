#!/bin/bash
# Makes what QEMU boots for the tests against kernel drivers: Debian's own kernel, and an initramfs of busybox, the modules of the drivers,
# the foreign tools and ours. Nothing of it is ever installed or mounted here; no rights are needed.
#
#   tests/hil/guest_image.sh BIN_FOLDER MEDIA_FOLDER OUT_FOLDER [--simulated-hardware]    makes OUT_FOLDER/kernel and OUT_FOLDER/initramfs
#
# MEDIA_FOLDER becomes /media in the guest. --simulated-hardware: with the drivers that kernel_modules.sh builds.
set -euo pipefail
fail() { echo "guest_image.sh: $*" >&2; exit 2; }

[[ $# -eq 3 || ($# -eq 4 && $4 == --simulated-hardware) ]] ||
  fail "usage: tests/hil/guest_image.sh BIN_FOLDER MEDIA_FOLDER OUT_FOLDER [--simulated-hardware]"
simulated=${4:-}
[[ $(dpkg --print-architecture) == amd64 ]] || fail "the guest runs this machine's programs, and so far it is an amd64 machine: use one"
source_dir=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
bin=$(readlink -f "$1")
media=$(readlink -f "$2")
mkdir -p "$3"
out=$(readlink -f "$3")
# shellcheck source=tests/hil/guest_kernel.sh
source "$source_dir/tests/hil/guest_kernel.sh"

modules=(vivid virtio_pci virtio_console virtio_net xhci_pci usbserial ftdi_sio)

# copy_programs PROGRAM...: into /bin, with the shared libraries that the loader would take, at their places.
copy_programs() {
  local library
  cp -L "$@" "$root/bin/"
  ldd "$@" | grep -o '/[^ :]*\.so[^ :]*' | sort -u | while read -r library; do
    [[ -e $root$library ]] || install -D -m 755 "$library" "$root$library"
  done
}

fetch_kernel
if [[ -n $simulated ]]; then
  add_simulated_hardware
  modules+=(vimc)
fi
root=$(mktemp -d "$out/root.XXXXXX")
trap 'rm -rf "$root"' EXIT
mkdir -p "$root"/{bin,dev,etc,proc,sys,tmp,run}
cp /bin/busybox "$root/bin/busybox"
ln -s busybox "$root/bin/sh"
printf 'root:x:0:0:root:/:/bin/sh\n' > "$root/etc/passwd"
printf 'root:x:0:\nvideo:x:44:\ndialout:x:20:\n' > "$root/etc/group"
install -m 755 "$source_dir/tests/hil/guest_init.sh" "$root/init"
copy_modules "$root"
copy_programs "$(command -v v4l2-ctl)" "$(command -v media-ctl)" "$bin/ninedot" "$bin/ninedotd"
cp -r "$media" "$root/media"
(cd "$root" && find . -print0 | sort -z | cpio --null --quiet -o -H newc -R 0:0) | gzip -1 > "$out/initramfs.part"
mv "$out/initramfs.part" "$out/initramfs"
cp -f "$kernel"/boot/vmlinuz-* "$out/kernel"
