#!/bin/bash
# Builds the drivers that Debian's arm64 kernel leaves out, from Debian's own source of that very kernel, and packs them.
#
#   toolchains/modules.sh FOLDER [ROOT]     as root; prints the path of ninedot-modules-KERNEL_*_arm64.deb
#
# FOLDER holds the kernel's packages of one version, as toolchains/image.sh lays them there: linux-image (that of backports with linux-binary and
# linux-modules), linux-headers (and its -common), linux-kbuild, linux-source. The compiler is the cross root's (toolchains/cross.sh makes it; default
# build/package-arm64/root): the release's own, which built the kernel. What was built is kept, by the kernel's version and by this file; nothing is downloaded.
set -euo pipefail
shopt -s inherit_errexit
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."
source toolchains/roots.sh

# Files of the source, by the module that they make. A kernel that has one itself keeps its own. v4l2-cci is what imx219 reaches its registers with;
# Debian's 6.12 builds it for no one.
drivers=(
  "bcm2835-unicam   drivers/media/platform/broadcom/bcm2835-unicam.c"
  "v4l2-cci         drivers/media/v4l2-core/v4l2-cci.c"
  "imx219           drivers/media/i2c/imx219.c"
  "imx296           drivers/media/i2c/imx296.c"
  "imx708           drivers/media/i2c/imx708.c"
  "ov5647           drivers/media/i2c/ov5647.c"
  "ov9282           drivers/media/i2c/ov9282.c"
  "pwm-pca9685      drivers/pwm/pwm-pca9685.c"
  "sc16is7xx        drivers/tty/serial/sc16is7xx.c"
  "sc16is7xx_i2c    drivers/tty/serial/sc16is7xx_i2c.c"
  "sc16is7xx_spi    drivers/tty/serial/sc16is7xx_spi.c"
)
headers=(drivers/media/platform/broadcom/bcm2835-unicam-regs.h drivers/tty/serial/sc16is7xx.h)

[[ $# -eq 1 || $# -eq 2 ]] && [[ -d $1 ]] || roots_fail "say where the kernel's packages are: toolchains/modules.sh FOLDER [ROOT]"
require_root
require_emulation arm64  # the kernel's build programs come as arm64 ones
folder=$(readlink -f "$1")
cross=$(readlink -f "${2:-build/package-arm64/root}") || cross=
[[ -d $cross ]] || roots_fail "no cross compiler: toolchains/cross.sh arm64 first"
for kind in image-[0-9]* headers-*-arm64 headers-*-common* kbuild source; do
  compgen -G "$folder/linux-${kind}*.deb" > /dev/null || roots_fail "no linux-$kind*.deb in $folder: remove that folder's root and make it anew"
done

kernel_deb=$(ls "$folder"/linux-image-[0-9]*.deb)
kernel=$(dpkg-deb -f "$kernel_deb" Package)
kernel=${kernel#linux-image-} kernel=${kernel%-unsigned}
version=$(dpkg-deb -f "$kernel_deb" Version)
for deb in "$folder"/linux-{headers,kbuild,source}-*.deb; do
  [[ $(dpkg-deb -f "$deb" Version) == "$version" ]] || roots_fail "$(basename "$deb") is not of the kernel's version $version: remove the root of $folder and make it anew"
done
package=ninedot-modules-$kernel
key=$(cat toolchains/modules.sh <(echo "$kernel $version") | sha256sum | cut -c 1-12)
kept=$ninedot_cache/modules-$key made=$ninedot_cache/modules-$key/${package}_${version}_arm64.deb
if [[ -s $made ]]; then
  echo "$made"
  exit 0
fi

echo "== building drivers for $kernel" >&2
started=$SECONDS
mkdir -p "$ninedot_cache"
work=$(mktemp -d "$ninedot_cache/modules-work-XXXXXX")
log=$ninedot_cache/modules.log
trap 'rm -rf --one-file-system "$work"' EXIT
fail() { tail -n 20 "$log" >&2; roots_fail "$1; the whole output: $log"; }
: > "$log"

# The source keeps its folders out of the build: all drivers are built side by side, as they include nothing of each other's places.
for deb in "$folder"/linux-{headers,kbuild,source}-*.deb; do dpkg-deb -x "$deb" "$work"; done
archive=$(ls "$work"/usr/src/linux-source-*.tar.xz)
top=$(basename "$archive" .tar.xz)
wanted=("${drivers[@]##* }" "${headers[@]}")
# What the archive lacks makes tar fail; it is told below, by name.
tar -C "$work" -xJf "$archive" "${wanted[@]/#/$top/}" 2>> "$log" || true
mkdir "$work/build"
modules=() lacking=()
# Of backports' kernel both are in packages of their own.
image_deb=$kernel_deb drivers_deb=$kernel_deb
for deb in "$folder"/linux-binary-[0-9]*.deb; do [[ ! -e $deb ]] || image_deb=$deb; done
for deb in "$folder"/linux-modules-[0-9]*.deb; do [[ ! -e $deb ]] || drivers_deb=$deb; done
theirs=$(dpkg-deb --fsys-tarfile "$drivers_deb" | tar -t)
for driver in "${drivers[@]}"; do
  name=${driver%% *} file=$work/$top/${driver##* }
  [[ $theirs != */"$name".ko* ]] || continue
  if [[ -e $file ]]; then cp "$file" "$work/build/"; modules+=("$name"); else lacking+=("$name"); fi
done
for file in "${headers[@]}"; do cp "$work/$top/$file" "$work/build/"; done
[[ ${#modules[@]} -gt 0 ]] || fail "$top has none of the drivers"
[[ ${#lacking[@]} -eq 0 ]] || echo "== $top has no ${lacking[*]}" >&2
{
  for name in "${modules[@]}"; do echo "obj-m += $name.o"; done
  # It is part of a kernel by this option, which Debian's 6.12 has not.
  [[ ! -e $work/build/v4l2-cci.c ]] || echo "ccflags-y += -DCONFIG_V4L2_CCI_I2C=1"
} > "$work/build/Makefile"
# Where the package would be installed is written into it.
sed -i "s|/usr/src/|/ninedot/usr/src/|" "$work/usr/src/linux-headers-$kernel/Makefile"
# Type information for tracing programs would need the whole kernel, which is not in the packages.
in_root "$cross" "$work" make -j "${NINEDOT_JOBS:-$(nproc)}" -C "/ninedot/usr/src/linux-headers-$kernel" M=/ninedot/build \
  CONFIG_DEBUG_INFO_BTF_MODULES= modules >> "$log" 2>&1 || fail "the drivers don't build"

tree=$work/package
place=$tree/usr/lib/modules/$kernel/extra
install -d "$place" "$tree/DEBIAN" "$tree/usr/share/doc/$package"
for name in "${modules[@]}"; do
  in_root "$cross" "$work/build" aarch64-linux-gnu-strip --strip-debug "$name.ko" >> "$log" 2>&1 || fail "$name.ko was not built"
  install -m 644 "$work/build/$name.ko" "$place/"
done
# The kernel's own date, so that the same kernel gives the same package.
SOURCE_DATE_EPOCH=$(dpkg-deb --fsys-tarfile "$image_deb" | tar -tv --full-time --utc --wildcards '*/vmlinuz*' | awk '{ print $4 "T" $5 "Z" }' | date -u -f - +%s)
export SOURCE_DATE_EPOCH
maintainer='The ninedot developers <maintainers@ninedot.invalid>'
cat > "$tree/usr/share/doc/$package/copyright" << END
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: linux
Source: https://www.kernel.org/
Comment: Drivers of the Linux kernel, built from Debian's source package linux, version $version, unchanged: ${modules[*]}.
 Each file of the source names its authors.

Files: *
Copyright: 1991-$(date -u -d "@$SOURCE_DATE_EPOCH" +%Y) Linus Torvalds and many others
License: GPL-2

License: GPL-2
 On Debian systems the full text of the GNU General Public License, version 2, is in the file /usr/share/common-licenses/GPL-2.
END
gzip -9n > "$tree/usr/share/doc/$package/changelog.Debian.gz" << END
$package ($version) unstable; urgency=medium

  * Built from the source of this kernel.

 -- $maintainer  $(LC_ALL=C date -u -R -d "@$SOURCE_DATE_EPOCH")
END
cat > "$tree/DEBIAN/control" << END
Package: $package
Version: $version
Architecture: arm64
Maintainer: $maintainer
Section: kernel
Priority: optional
Depends: kmod, linux-image-$kernel (= $version) | linux-image-$kernel-unsigned (= $version)
Installed-Size: $(du -sk "$tree/usr" | cut -f 1)
Description: drivers that Debian's kernel $kernel leaves out
 Cameras on the ribbon cable of a Raspberry Pi, the PCA9685 PWM chip and the SC16IS7xx serial chips: ${modules[*]}.
END
for script in postinst postrm; do
  printf '#!/bin/sh\nset -e\n[ ! -d /lib/modules/%s/kernel ] || depmod %s\n' "$kernel" "$kernel" > "$tree/DEBIAN/$script"
  chmod 755 "$tree/DEBIAN/$script"
done
rm -rf --one-file-system "$kept"
mkdir -p "$kept"
dpkg-deb --root-owner-group -Zxz -b "$tree" "$made.part" >> "$log" 2>&1 || fail "the package can't be made"
mv "$made.part" "$made"
echo "== $(basename "$made"): ${#modules[@]} drivers in $((SECONDS - started)) s" >&2
echo "$made"
