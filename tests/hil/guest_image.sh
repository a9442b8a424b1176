#!/bin/bash
# Makes what QEMU boots for the tests against kernel drivers: Debian's own kernel, and an initramfs of busybox, the modules of the drivers,
# the foreign tools and ours. Nothing of it is ever installed or mounted here; no rights are needed.
#
#   tests/hil/guest_image.sh BIN_FOLDER MEDIA_FOLDER OUT_FOLDER [--simulated-hardware]    makes OUT_FOLDER/kernel and OUT_FOLDER/initramfs
#
# MEDIA_FOLDER becomes /media in the guest. --simulated-hardware: with the drivers that kernel_modules.sh builds.
#
# The kernel package is downloaded once into ${NINEDOT_CACHE:-/var/tmp/ninedot-cache}/hil.
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
cache=${NINEDOT_CACHE:-/var/tmp/ninedot-cache}/hil
mkdir -p "$cache"
PATH=$PATH:/usr/sbin:/sbin

# What the stages load by name; what these depend on comes along. What a kernel has built in is no module.
modules=(vivid virtio_pci virtio_console virtio_net xhci_pci usbserial ftdi_sio)

kernel_package() {
  apt-cache depends --important linux-image-amd64 2> /dev/null | sed -n 's/^ *Depends: \(linux-image-[0-9].*\)/\1/p' | head -n 1
}

# The lists of a bare machine may be missing or older than the archive.
refresh_lists() {
  local sudo=()
  [[ $EUID -eq 0 ]] || sudo=(sudo -n)
  "${sudo[@]}" apt-get -q -o DPkg::Lock::Timeout=300 update > "$out/apt.log" 2>&1 || true
}

# The kernel's package unpacked, as $cache/linux-image-VERSION. A part of it never looks like the whole: it is moved there at the end.
fetch_kernel() {
  local package part
  package=$(kernel_package)
  [[ -n $package ]] || { refresh_lists; package=$(kernel_package); }
  [[ -n $package ]] || fail "apt knows no linux-image-amd64: put Debian's main archive into its sources"
  kernel=$cache/$package
  [[ -e $kernel/complete ]] && return
  echo "downloading $package"
  part=$(mktemp -d "$cache/part.XXXXXX")
  (cd "$part" && { apt-get -q download "$package" > "$out/apt.log" 2>&1 || { refresh_lists; apt-get -q download "$package" >> "$out/apt.log" 2>&1; }; }) ||
    fail "$package can't be downloaded; what apt-get said is in $out/apt.log"
  mkdir "$part/root"
  dpkg -x "$part"/*.deb "$part/root"
  rm "$part"/*.deb
  [[ -d $part/root/lib ]] || ln -s usr/lib "$part/root/lib"
  # Debian 13 compresses its modules, and busybox can't load those.
  find "$part/root/lib/" -name '*.ko.xz' -exec xz -d {} +
  touch "$part/root/complete"
  depmod -b "$part/root" "$(basename "$part"/root/lib/modules/*)" 2> /dev/null
  mv -T "$part/root" "$kernel" 2> /dev/null || [[ -e $kernel/complete ]]  # somebody else may have been faster
  rm -rf "$part"
}

copy_modules() {
  local version module path
  version=$(basename "$kernel"/lib/modules/*)
  for module in "${modules[@]}"; do
    modprobe -d "$kernel" -S "$version" --show-depends "$module" | sed -n 's/^insmod \([^ ]*\).*/\1/p'
  done | sort -u | while read -r path; do
    path=${path#"$kernel"}
    install -D -m 644 "$kernel$path" "$root$path"
  done
  cp "$kernel/lib/modules/$version/"modules.{order,builtin,builtin.modinfo} "$root/lib/modules/$version/" 2> /dev/null || true
  depmod -b "$root" "$version" 2> /dev/null
}

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
  "$source_dir/tests/hil/kernel_modules.sh" "$kernel" "$out/modules.log"
  modules+=(i2c-stub i2c-dev configfs gpio-sim pwm-pca9685)
fi
root=$(mktemp -d "$out/root.XXXXXX")
trap 'rm -rf "$root"' EXIT
mkdir -p "$root"/{bin,dev,etc,proc,sys,tmp,run}
cp /bin/busybox "$root/bin/busybox"
ln -s busybox "$root/bin/sh"
printf 'root:x:0:0:root:/:/bin/sh\n' > "$root/etc/passwd"
printf 'root:x:0:\nvideo:x:44:\ndialout:x:20:\n' > "$root/etc/group"
install -m 755 "$source_dir/tests/hil/guest_init.sh" "$root/init"
copy_modules
copy_programs "$(command -v v4l2-ctl)" "$bin/ninedot" "$bin/ninedotd"
cp -r "$media" "$root/media"
(cd "$root" && find . -print0 | sort -z | cpio --null --quiet -o -H newc -R 0:0) | gzip -1 > "$out/initramfs.part"
mv "$out/initramfs.part" "$out/initramfs"
cp -f "$kernel"/boot/vmlinuz-* "$out/kernel"
