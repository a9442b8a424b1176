#!/bin/bash
# Makes what QEMU boots for the stage `installed`: this machine's Debian with systemd and udev, on a disk, and in it our packages as
# apt installs them. As root. Nothing of it is mounted here; what is made is a file.
#
#   tests/hil/installed_image.sh PACKAGES_FOLDER MEDIA_FOLDER OUT_FOLDER    makes OUT_FOLDER/{kernel,initramfs,disk}
#
# PACKAGES_FOLDER: with ninedot_*.deb and ninedot-web_*.deb. MEDIA_FOLDER becomes /media. What the packages need is installed once into
# ${NINEDOT_CACHE:-/var/tmp/ninedot-cache}/hil/installed-*.tar, and again after a week, as the archive moves on.
set -euo pipefail
fail() { echo "installed_image.sh: $*" >&2; exit 2; }

[[ $# -eq 3 ]] || fail "usage: tests/hil/installed_image.sh PACKAGES_FOLDER MEDIA_FOLDER OUT_FOLDER"
[[ $EUID -eq 0 ]] || fail "needs root, to make a Debian: use sudo"
for tool in mmdebstrap mke2fs; do command -v "$tool" > /dev/null || fail "needs $tool: ./dev packages hil"; done
source_dir=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
media=$(readlink -f "$2")
mkdir -p "$3"
out=$(readlink -f "$3")
newest() { ls -t "$1"_*_amd64.deb 2> /dev/null | head -n 1; }
packages=("$(newest "$1/ninedot")" "$(newest "$1/ninedot-web")")
[[ -s ${packages[0]} && -s ${packages[1]} ]] || fail "no ninedot_*.deb and ninedot-web_*.deb in $1: ./dev package"
# shellcheck source=tests/hil/guest_kernel.sh
source "$source_dir/tests/hil/guest_kernel.sh"

# What the disk needs; ext4 asks for its checksums by name, which no list of dependencies says.
disk_modules=(virtio_pci virtio_blk crc32c_generic ext4)
modules=("${disk_modules[@]}" vivid vimc virtio_console virtio_net xhci_pci usbserial ftdi_sio)
# dbus is how `systemctl` and udev's own tools speak with systemd on every board; v4l2-ctl feeds vivid; busybox is the host's door.
needed=(systemd-sysv udev dbus kmod busybox-static v4l-utils)

make_base() {
  local suite mirror part
  suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
  mirror=${NINEDOT_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' | sort -u | head -n 1)}
  [[ -n $mirror ]] || fail "no Debian archive in this machine's apt sources: set NINEDOT_MIRROR"
  base=$cache/installed-$suite-$({ for package in "${packages[@]}"; do dpkg-deb -f "$package" Depends; done; echo "${needed[*]}"; } | sha256sum | cut -c 1-12).tar
  [[ ! -f $base || -n $(find "$base" -mtime +7) ]] || return 0
  echo "making a Debian $suite with systemd and what the packages need"
  part=$base.$$
  # Installed once so that all they need is there, and removed again: which rights and states they leave is theirs to say, each time.
  # shellcheck disable=SC2016
  mmdebstrap --quiet --mode=root --variant=minbase --format=tar --include="$(IFS=,; echo "${needed[*]}")" \
    --customize-hook="copy-in ${packages[*]} /root" \
    --customize-hook='chroot "$1" sh -c "apt-get -q -y --no-install-recommends install /root/*.deb && apt-get -q -y purge ninedot ninedot-web && rm /root/*.deb"' \
    "$suite" "$part" "$mirror" > "$out/base.log" 2>&1 || { tail -n 5 "$out/base.log" >&2; rm -f "$part"; fail "no Debian could be made: $out/base.log"; }
  mv "$part" "$base"
}

# As on a machine that is set up before it runs: nothing is started by the installation.
install_packages() {
  cp "${packages[@]}" "$root/root/"
  unshare --mount --propagation private /bin/bash -c '
    mount -t proc proc "$1/proc" && mount -t tmpfs -o mode=755 tmpfs "$1/dev" && mknod -m 666 "$1/dev/null" c 1 3 &&
    exec chroot "$1" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
      sh -c "dpkg -i /root/ninedot_*.deb /root/ninedot-web_*.deb"' install_packages "$root" > "$out/install.log" 2>&1 < /dev/null ||
    { cat "$out/install.log" >&2; fail "the packages can't be installed"; }
}

# The host's door: a root shell on the virtual console, and files by HTTP. Not before everything that boots by itself has.
add_door() {
  install -m 755 "$source_dir/tests/hil/guest_door.sh" "$root/usr/local/sbin/guest-door"
  cat > "$root/etc/systemd/system/guest-door.service" << 'END'
[Unit]
After=multi-user.target
[Service]
ExecStart=/usr/local/sbin/guest-door
StandardInput=null
StandardOutput=journal
IgnoreSIGPIPE=no
[Install]
WantedBy=guest.target
END
  cat > "$root/etc/systemd/system/guest.target" << 'END'
[Unit]
Requires=multi-user.target
After=multi-user.target
AllowIsolate=yes
END
  mkdir -p "$root/etc/systemd/system/guest.target.wants"
  ln -s ../guest-door.service "$root/etc/systemd/system/guest.target.wants/"
  ln -sf guest.target "$root/etc/systemd/system/default.target"
  ln -sf /dev/null "$root/etc/systemd/system/serial-getty@.service"
  ln -sf /dev/null "$root/etc/systemd/system/getty@.service"
  printf 'hil\n' > "$root/etc/hostname"
  printf '/dev/vda / ext4 rw,noatime 0 0\n' > "$root/etc/fstab"
  : > "$root/etc/machine-id"
}

make_initramfs() {
  local first
  first=$(mktemp -d "$out/first.XXXXXX")
  mkdir -p "$first"/{bin,dev,proc,sys,root}
  cp /bin/busybox "$first/bin/busybox"
  cat > "$first/init" << 'END'
#!/bin/busybox sh
# The disk's drivers, then the disk.
/bin/busybox --install -s /bin
export PATH=/bin
mount -t proc proc /proc
mount -t devtmpfs dev /dev
for module in virtio_pci virtio_blk crc32c_generic ext4; do modprobe $module; done
for _ in 1 2 3 4 5 6 7 8 9 10; do [ -e /dev/vda ] && break; sleep 0.2; done
mount -t ext4 /dev/vda /root || exec poweroff -f
umount /proc
exec switch_root /root /lib/systemd/systemd
END
  chmod 755 "$first/init"
  (modules=("${disk_modules[@]}"); copy_modules "$first")
  (cd "$first" && find . -print0 | sort -z | cpio --null --quiet -o -H newc -R 0:0) | gzip -1 > "$out/initramfs"
  rm -rf "$first"
}

fetch_kernel
add_simulated_hardware
make_base
root=$(mktemp -d "$out/root.XXXXXX")
trap 'rm -rf --one-file-system "$root"' EXIT
chmod 755 "$root"
tar -C "$root" -xf "$base" --exclude='./dev/*'
install_packages
copy_modules "$root"
add_door
cp -r "$media/." "$root/media/"
chmod -R a+rX "$root/media"
make_initramfs
rm -f "$out/disk"
mke2fs -q -F -t ext4 -d "$root" "$out/disk" "$(($(du -sm "$root" | cut -f 1) * 5 / 4 + 200))M" > "$out/disk.log"
cp -f "$kernel"/boot/vmlinuz-* "$out/kernel"
