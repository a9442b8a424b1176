#!/bin/bash
# Makes the board image: 64-bit ARM, Debian 13, read-only root, data partition, configuration on a FAT partition. docs/board.md says what is on it.
#
#   toolchains/image.sh [--pi5] [--update]     as root; result: build/image/ninedot-arm64.img, ninedot-arm64.spdx.json, which says what it is made of,
#                                              and for QEMU u-boot.bin (-bios), or vmlinuz and initrd.gz (-kernel and -initrd)
#
# --pi5: for the Raspberry Pi 5, with the kernel and the libcamera of Debian's backports; the same files in build/image-pi5, ninedot-arm64-pi5.img.
# Made with one system, A; the place of the other is empty until the first update: toolchains/bundle.sh.
#
# Debian's part is made once, again when the list of its packages changes, and with --update: from what Debian's archive has now. The same sources
# give the same bytes (SOURCE_DATE_EPOCH: the last commit's time). NINEDOT_CACHE, NINEDOT_MIRROR, NINEDOT_JOBS: as for toolchains/cross.sh; NINEDOT_SECURITY_MIRROR: roots.sh.
set -euo pipefail
shopt -s inherit_errexit
update='' pi5=''
for word in "$@"; do
  case $word in
    --update) update=yes ;;
    --pi5) pi5=-pi5 ;;
    *) echo "image.sh: unknown '$word': toolchains/image.sh [--pi5] [--update]" >&2; exit 2 ;;
  esac
done
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."
source toolchains/roots.sh

started=$SECONDS
disk_signature=39444f54     # the same on all boards: it names the disk that the root is on, and no board has two of them
data_uuid=9d090000-0000-4000-8000-000000000003
fat_mib=128 data_mib=64     # data: a few files; the journal takes 4 MiB
root_mib=256 boot_mib=64    # of each system: twice what they take today. They can't grow later
name=ninedot-arm64$pi5 out=build/image$pi5
image=$out/$name.img
# Unpacked by nobody: OpenCV's core asks for the graphics stack, of which it calls nothing without a window.
left_out=(/usr/share/man/ /usr/share/info/ /usr/share/locale/ /usr/share/lintian/ /usr/share/bash-completion/ /usr/share/zsh/
  /usr/lib/aarch64-linux-gnu/libLLVM /usr/lib/aarch64-linux-gnu/libgallium /usr/lib/aarch64-linux-gnu/libz3 /usr/lib/aarch64-linux-gnu/dri/)
# Of the radios' firmware only that of the Raspberry Pis' own Wi-Fi, and which channels each country permits.
firmware_kept=(brcm/brcmfmac43430-sdio.{bin,clm_blob,raspberrypi*} brcm/brcmfmac43455-sdio.{bin,clm_blob,raspberrypi*} cypress/cyfmac43430-sdio.* cypress/cyfmac43455-sdio.*
  regulatory.db*)
# No screen, no sound, no server's controllers, no radio but the Raspberry Pis' own: half of the drivers' size.
drivers_left_out=(sound kernel/sound drivers/gpu drivers/infiniband drivers/scsi/lpfc drivers/scsi/qla2xxx drivers/scsi/mpt3sas
  drivers/net/ethernet/mellanox drivers/net/ethernet/intel drivers/net/ethernet/broadcom/bnxt drivers/net/ethernet/broadcom/bnx2x
  drivers/net/wireless/{admtek,ath,atmel,broadcom/b43,broadcom/b43legacy,broadcom/brcm80211/brcmsmac,intel,intersil,marvell,mediatek,ralink,realtek,rsi,ti,zydas}
  fs/btrfs fs/xfs fs/ocfs2 fs/gfs2 fs/ceph fs/bcachefs drivers/md/{bcache,dm-vdo,persistent-data,raid*,md-*,dm-cache*,dm-raid*,dm-thin*,dm-era*,dm-clone*}
  drivers/isdn drivers/accel)

require_root
for tool in mmdebstrap python3 mksquashfs mcopy mkfs.vfat mke2fs sfdisk cpio depmod xz dtc mkimage mkenvimage; do
  command -v "$tool" > /dev/null || roots_fail "needs $tool: ./dev packages cross image"
done
require_emulation arm64
SOURCE_DATE_EPOCH=$(source_date_epoch)
export SOURCE_DATE_EPOCH
image_version=$(sed -n 's/^project(ninedot VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)+$(date -u -d "@$SOURCE_DATE_EPOCH" +%Y%m%d%H%M)
[[ $image_version == [0-9]* ]] || roots_fail "CMakeLists.txt does not say the version"

# Kept in the root as packages: what is unpacked later without its installation scripts, which would make an initrd under emulation for minutes;
# and the kernel's headers and source, of the very same version, for toolchains/modules.sh.
# shellcheck disable=SC2016
download_kernel='
cd /board
kernel=$(apt-cache depends linux-image-rt-arm64 | sed -n "s/.*Depends: \(linux-image-[0-9].*\)/\1/p" | head -n 1)
apt-get download busybox-static raspi-firmware u-boot-rpi u-boot-qemu "$kernel"
version=$(dpkg-deb -f "$kernel"_*.deb Version) abi=${kernel#linux-image-}
source=linux-source-$(echo "$abi" | cut -d . -f 1,2)
apt-get download "linux-headers-$abi=$version" "linux-headers-${abi%-rt-arm64}-common-rt=$version" "linux-kbuild-${abi%-rt-arm64}=$version" "$source=$version"'
# The same of backports, where the kernel is in four packages. A Raspberry Pi 5 has its firmware on the board.
# shellcheck disable=SC2016
if [[ -n $pi5 ]]; then download_kernel='
cd /board
abi=$(apt-cache depends linux-image-rt-arm64 | sed -n "s/.*Depends: linux-image-\([0-9].*\)/\1/p" | head -n 1)
version=$(apt-cache show --no-all-versions "linux-image-$abi" | sed -n "s/^Version: //p")
apt-get download busybox-static u-boot-rpi u-boot-qemu
for name in "image-$abi" "base-$abi" "binary-$abi" "modules-$abi" "headers-$abi" "headers-${abi%-rt-arm64}-common" "kbuild-${abi%-rt-arm64}" \
  "source-$(echo "$abi" | cut -d . -f 1,2)"; do apt-get download "linux-$name=$version"; done'
fi

# debian_base DEB...: the folder with Debian's part, made if need be. The packages that ours ask for are in it.
debian_base() {
  local names key base log option=() place sources
  sources=$(board_sources; [[ -z $pi5 ]] || backports_source)
  names=$( (for place in "$@"; do dpkg-deb -f "$place" Depends; done | tr ',' '\n' | sed 's/|.*//; s/(.*//; s/ //g' | grep -v '^ninedot$'
    sed 's/#.*//; s/ //g' systemd/image/packages.txt) | grep . | sort -u)
  key=$(sha256sum <<< "$sources${pi5:+ $backports_pin} $names ${left_out[*]} $download_kernel" | cut -c 1-12)
  base=$ninedot_cache/board$pi5-$key
  if [[ ! -d $base || -n $update ]]; then
    echo "== making Debian's part: $base (takes 5 to 10 minutes)" >&2
    mkdir -p "$ninedot_cache"
    rm -rf --one-file-system "$base.part"
    log=$ninedot_cache/board$pi5.log
    [[ -z $pi5 ]] || option+=("$backports_hook")
    for place in "${left_out[@]}"; do option+=("--dpkgopt=path-exclude=$place*"); done
    option+=("--dpkgopt=path-exclude=/usr/share/doc/*" "--dpkgopt=path-include=/usr/share/doc/*/copyright" "--dpkgopt=path-include=/usr/share/doc/ninedot/*")
    # shellcheck disable=SC2016
    script=$download_kernel backports_pin=$backports_pin new_root --variant=minbase --architectures=arm64 "${option[@]}" --include="${names//$'\n'/,}" \
      --customize-hook='mkdir "$1/board" && chroot "$1" sh -ec "$script"' \
      "$ninedot_suite" "$base.part" - <<< "$sources" > "$log" 2>&1 || root_failed "Debian's part" "$log" "$ninedot_suite${pi5:+-backports}"
    # The old one goes when there is a new one: an archive that can't be reached leaves what there was.
    rm -rf --one-file-system "$base"
    mv "$base.part" "$base"
  fi
  echo "$base"
}

# unpack DEB FOLDER [TAR OPTION...]
unpack() {
  local deb=$1 folder=$2; shift 2
  mkdir -p "$folder"
  dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$folder" --keep-directory-symlink "$@"
}

# fill_root ROOT: everything that is ours, and nothing that differs from one making to the next.
fill_root() {
  local root=$1 option=() place version
  # Before the kernel, which is no package here: that spares running depmod emulated. dpkg is told to do without that package.
  version=$(basename "$root"/board/linux-image-*.deb | cut -d _ -f 1)
  in_root "$root" "$(dirname "$modules")" dpkg -i --ignore-depends="$version" "$(basename "$modules")"
  for place in "${drivers_left_out[@]}"; do option+=("--exclude=*/kernel/${place#kernel/}"); done
  for place in "$root"/board/linux-{image,base,binary,modules}-[0-9]*.deb; do [[ ! -e $place ]] || unpack "$place" "$root" "${option[@]}"; done
  option=()
  for place in "${firmware_kept[@]}"; do option+=(! -path "$root/usr/lib/firmware/$place"); done
  find "$root/usr/lib/firmware" ! -type d "${option[@]}" -delete
  version=$(basename "$root"/usr/lib/modules/*)
  depmod -b "$root" "$version"
  in_root "$root" "$(dirname "$deb")" dpkg -i "$(basename "$deb")" "$(basename "$web_deb")"
  cp -r systemd/image/root/. "$root/"
  # The page and ssh wait for a file of the FAT partition: conditions of their units.
  in_root "$root" "$PWD" systemctl enable ninedot-configure.service systemd-networkd.service systemd-timesyncd.service ssh.service ninedot-web.service \
    ninedot-confirm.service
  # Work for a system that updates itself, and logins that nobody has a password for.
  in_root "$root" "$PWD" systemctl mask apt-daily.timer apt-daily-upgrade.timer dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service \
    fstrim.timer getty-static.service wpa_supplicant.service
  mkdir -p "$root/etc/systemd/system-generators"
  ln -s /dev/null "$root/etc/systemd/system-generators/systemd-ssh-generator"
  mkdir -p "$root/data" "$root/var/lib/ninedot" "$root/var/lib/ninedot-web"
  echo ninedot > "$root/etc/hostname"
  printf '127.0.0.1 localhost\n127.0.1.1 ninedot\n::1 localhost\n' > "$root/etc/hosts"
  : > "$root/etc/machine-id"
  printf 'IMAGE_ID=%s\nIMAGE_VERSION=%s\n' "$name" "$image_version" >> "$root/usr/lib/os-release"
  # An update of one board would not start on the other.
  sed -i "s/^compatible=.*/compatible=$name/" "$root/etc/rauc/system.conf"
  rm -rf "$root/ninedot" "$root"/etc/ssh/ssh_host_* "$root"/var/lib/apt/lists/* "$root"/var/cache/* "$root"/var/log/* "$root"/var/lib/systemd/* \
    "$root"/var/lib/dpkg/*-old "$root"/etc/*- "$root/etc/resolv.conf" "$root"/tmp/* "$root"/run/* "${root:?}"/dev/* "$root"/initrd.img* "$root"/vmlinuz*
}

# make_initrd ROOT FOLDER: BusyBox, one script, and the drivers on the way to the disk.
make_initrd() {
  local root=$1 tree=$2/initrd version file
  version=$(basename "$root"/usr/lib/modules/*)
  mkdir -p "$tree"/{bin,dev,proc,sys,run,root,modules}
  unpack "$root"/board/busybox-static_*.deb "$2/busybox"
  install -m 755 "$2/busybox/usr/bin/busybox" "$tree/bin/busybox"
  install -m 755 systemd/image/init "$tree/init"
  # In an order in which each finds what it needs; built-in ones and those of other kernels fall out.
  sed '/^#/d' systemd/image/modules.txt ${pi5:+systemd/image/modules-pi5.txt} | while read -r file; do
    modprobe -d "$root" -S "$version" --show-depends "$file" 2> /dev/null | sed -n 's/^insmod \([^ ]*\).*/\1/p' || true
  done | awk '!seen[$0]++' | while read -r file; do
    if [[ $file == *.xz ]]; then xz -dc "$file"; else cat "$file"; fi > "$tree/modules/$(basename "${file%.xz}")"
    basename "${file%.xz}" >> "$tree/modules/order"
  done
  mknod -m 600 "$tree/dev/console" c 5 1
  find "$tree" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
  (cd "$tree" && find . | LC_ALL=C sort | cpio --quiet --reproducible -o -H newc) | gzip -9n > "$out/initrd.gz"
}

# make_fat IMAGE MIB LABEL SERIAL-NUMBER FOLDER: a FAT with what the folder holds, the same bytes from the same files.
make_fat() {
  local image=$1 type=(-F 32)
  [[ $2 -ge 128 ]] || type=()
  find "$5" -exec touch -d "@$SOURCE_DATE_EPOCH" {} +
  rm -f "$image"
  truncate -s "$2M" "$image"
  mkfs.vfat "${type[@]}" -n "$3" -i "$4" --invariant "$image" > /dev/null
  (cd "$5" && find . -mindepth 1 -type d -printf '%P\n' | LC_ALL=C sort | TZ=UTC xargs -r -I {} mmd -i "$image" ::{})
  (cd "$5" && find . -type f -printf '%P\n' | LC_ALL=C sort | TZ=UTC xargs -I {} mcopy -m -i "$image" {} ::{})
}

# make_boot FOLDER: what the boot loader needs of a system, beside its root.
make_boot() {
  mkdir -p "$1/boot"
  cp "$out/vmlinuz" "$out/initrd.gz" "$1/boot/"
  make_fat "$1/boot.img" "$boot_mib" BOOT "$disk_signature" "$1/boot"
}

# make_config ROOT FOLDER: the configuration, the boot loader, and what a Raspberry Pi loads before it.
make_config() {
  local root=$1 tree=$2/fat
  mkdir -p "$tree"
  sed 's/$/\r/' systemd/image/README.txt > "$tree/README.TXT"
  cp "$root/etc/ninedot/ninedot.toml" "$tree/"
  cp "systemd/image/config$pi5.txt" "$tree/config.txt"
  # A Raspberry Pi 5 has a serial line for that alone, and U-Boot perhaps no screen there.
  echo "ro quiet panic=10 systemd.gpt_auto=0${pi5:+ console=ttyAMA10,115200} console=tty1" > "$tree/cmdline.txt"
  unpack "$root"/board/u-boot-rpi_*.deb "$2/u-boot-rpi"
  cp "$2/u-boot-rpi/usr/lib/u-boot/rpi_arm64/u-boot.bin" "$tree/"
  cp "$2/u-boot-rpi/usr/share/doc/u-boot-rpi/copyright" "$tree/LICENCE.u-boot"
  sed '/^ *#/d' systemd/image/boot.cmd > "$2/boot.txt"
  mkimage -A arm64 -T script -n ninedot -d "$2/boot.txt" "$tree/boot.scr" > /dev/null
  # Debian's U-Boot for these boards looks here for its own variables; 0x4000 bytes is what it was built for.
  sed "/^#/d${pi5:+; s/=vidconsole/=serial,vidconsole/}" systemd/image/u-boot-rpi.txt | mkenvimage -p 0 -s 0x4000 -o "$tree/uboot.env" -
  if [[ -n $pi5 ]]; then
    cp "$root"/usr/lib/modules/*/dtb/broadcom/bcm2712-*rpi-5-b.dtb "$tree/"
  else
    unpack "$root"/board/raspi-firmware_*.deb "$2/firmware"
    cp "$2"/firmware/usr/lib/raspi-firmware/{bootcode.bin,start*.elf,fixup*.dat} "$tree/"
    cp "$2/firmware/usr/share/doc/raspi-firmware/copyright" "$tree/LICENCE.raspi-firmware"
    cp "$root"/usr/lib/linux-image-*/broadcom/bcm2{711,712,837}-rpi-*.dtb "$tree/"
  fi
  toolchains/overlays.sh "$tree/overlays" ${pi5:+pi5}
  make_fat "$2/fat.img" "$fat_mib" NINEDOT "$disk_signature" "$tree"
}

# make_disk FOLDER: all partitions in one file. Those of system B are logical ones: a table has four places, and the first three are as they always were.
make_disk() {
  local first=4 table='' number at=()
  truncate -s "${data_mib}M" "$1/data.img"
  E2FSPROGS_FAKE_TIME=$SOURCE_DATE_EPOCH mke2fs -q -t ext4 -L ninedot-data -U "$data_uuid" -J size=4 -m 1 \
    -E "hash_seed=$data_uuid,lazy_itable_init=0,lazy_journal_init=0,root_owner=0:0" "$1/data.img"
  [[ $(stat -c %s "$1/root.squashfs") -le $((root_mib * 1048576)) ]] || { echo "the root has more than $root_mib MiB"; return 1; }
  # next MIB TYPE: one more line of the table, and where it begins in at[].
  next() { at+=("$first"); table+="start=${first}MiB, size=$1MiB, type=$2"$'\n' first=$((first + $1)); }
  next "$fat_mib" "c, bootable"
  next "$root_mib" 83
  next "$data_mib" 83
  table+="start=${first}MiB, size=$((3 + root_mib + 2 * boot_mib))MiB, type=5"$'\n'
  at+=("$first")
  for number in "$root_mib" "$boot_mib" "$boot_mib"; do  # each behind a table of its own
    first=$((first + 1))
    next "$number" 83
  done
  rm -f "$image"
  truncate -s "${first}M" "$image"
  printf 'label: dos\nlabel-id: 0x%s\n%s' "$disk_signature" "$table" | sfdisk -q "$image"
  place() { dd if="$1" of="$image" bs=1M seek="$2" conv=notrunc,sparse status=none; }
  place "$1/fat.img" "${at[0]}"
  place "$1/root.squashfs" "${at[1]}"
  place "$1/data.img" "${at[2]}"
  place "$1/boot.img" "${at[5]}"
  # Which system starts: both copies of what boot.cmd reads and writes. B is empty.
  printf 'BOOT_ORDER=A B\nBOOT_A_LEFT=9\nBOOT_B_LEFT=0\n' | mkenvimage -r -p 0 -s 0x4000 -o "$1/state" -
  place "$1/state" 1
  place "$1/state" 2
}

NINEDOT_JOBS=${NINEDOT_JOBS:-$(nproc)} toolchains/cross.sh arm64 ${pi5:+--backports}
built=build/package-arm64${pi5:+-backports}
deb=$(ls "$built"/package/ninedot_*_arm64.deb)
web_deb=$(ls "$built"/package/ninedot-web_*_arm64.deb)
base=$(debian_base "$deb" "$web_deb")
modules=$(toolchains/modules.sh "$base/board" "$built/root")
work=$(mktemp -d "$ninedot_cache/board-work-XXXXXX")
log=
# shellcheck disable=SC2154
trap 'status=$?; rm -rf --one-file-system "$work"; [[ $status -eq 0 || -z $log ]] || { tail -n 20 "$log" >&2; echo "image.sh: failed; the whole output: $log" >&2; }' EXIT
mkdir -p "$out"
echo "== making the image"
cp -a "$base" "$work/root"
log=$out/image.log
fill_root "$work/root" > "$log" 2>&1
vmlinuz=$(compgen -G "$work/root/boot/vmlinuz-*" || compgen -G "$work/root/usr/lib/modules/*/vmlinuz")
install -m 644 "$vmlinuz" "$out/vmlinuz"
make_initrd "$work/root" "$work" >> "$log" 2>&1
unpack "$work"/root/board/u-boot-qemu_*.deb "$work/u-boot-qemu" ./usr/lib/u-boot/qemu_arm64/u-boot.bin >> "$log" 2>&1
install -m 644 "$work/u-boot-qemu/usr/lib/u-boot/qemu_arm64/u-boot.bin" "$out/u-boot.bin"
make_boot "$work" >> "$log" 2>&1
make_config "$work/root" "$work" >> "$log" 2>&1
mapfile -t unpacked < <(find "$work/root/board" -regextype egrep -regex '.*/(linux-(image|base|binary|modules)-[0-9]|busybox-static_|raspi-firmware_|u-boot-rpi_).*')
toolchains/sbom.py "$work/root" --name "$name" --version "$image_version" --out "$out/$name.spdx.json" --unpacked "${unpacked[@]}" >> "$log" 2>&1
install -D -m 644 "$out/$name.spdx.json" "$work/root/usr/share/ninedot/sbom.spdx.json"
rm -rf "$work"/root/board "$work"/root/boot/* "$work"/root/usr/lib/linux-image-* "$work"/root/usr/lib/modules/*/{vmlinuz,System.map,dtb}
env -u SOURCE_DATE_EPOCH mksquashfs "$work/root" "$work/root.squashfs" -comp zstd -Xcompression-level 19 -noappend -no-progress -quiet \
  -mkfs-time "$SOURCE_DATE_EPOCH" -all-time "$SOURCE_DATE_EPOCH" -processors "${NINEDOT_JOBS:-$(nproc)}" >> "$log" 2>&1
make_disk "$work" >> "$log" 2>&1
mib() { echo "$(($(stat -c %s "$1") / 1048576)) MiB"; }
echo "== $image: $(mib "$image"), of which root $(mib "$work/root.squashfs") ($(du -sm --apparent-size "$work/root" | cut -f 1) MiB unpacked)"
echo "== kernel $(mib "$out/vmlinuz"), initrd $(mib "$out/initrd.gz"), sha256 $(sha256sum "$image" | cut -c 1-16), made in $((SECONDS - started)) s"
