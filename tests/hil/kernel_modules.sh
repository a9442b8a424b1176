#!/bin/bash
# Builds the drivers of simulated hardware that Debian's kernels leave out, against the headers and from the source of the very kernel:
# gpio-sim (lines that a test drives and reads), pwm-pca9685 (a PWM chip on I2C, whose registers i2c-stub keeps in memory) and vimc (two sensors
# behind a media graph; one of them with the controls of a real one, see vimc_sensor.sh).
#
#   tests/hil/kernel_modules.sh KERNEL_FOLDER LOG      KERNEL_FOLDER: the kernel's package, unpacked; modules go to lib/modules/*/extra
set -euo pipefail
fail() { echo "kernel_modules.sh: $*" >&2; exit 2; }
[[ $# -eq 2 ]] || fail "usage: tests/hil/kernel_modules.sh KERNEL_FOLDER LOG"
kernel=$(readlink -f "$1")
log=$(realpath "$2")
version=$(basename "$kernel"/lib/modules/*)
extra=$kernel/lib/modules/$version/extra
[[ ! -e $extra/complete || ! -e $extra/vimc.ko ]] || exit 0

work=$(mktemp -d "$kernel.modules.XXXXXX")
trap 'rm -rf "$work"' EXIT
headers=linux-headers-$version
source_package=linux-source-$(cut -d. -f1,2 <<< "$version")
mapfile -t needed < <(apt-cache depends --important "$headers" | sed -n 's/^ *Depends: \(linux-\(headers\|kbuild\)-.*\)/\1/p')
[[ ${#needed[@]} -ge 2 ]] || fail "apt does not know what $headers needs: is this the newest kernel? Remove $kernel"
echo "building gpio-sim, pwm-pca9685 and vimc for $version"
(cd "$work" && apt-get -q download "$headers" "${needed[@]}" "$source_package" > "$log" 2>&1) || fail "the kernel's headers or source can't be downloaded: $log"
for package in "$work"/*.deb; do dpkg -x "$package" "$work/root"; done
tar -C "$work" -xJf "$work/root/usr/src/$source_package.tar.xz" --strip-components 1 --wildcards '*/drivers/gpio/gpio-sim.c' '*/drivers/gpio/gpiolib.h' \
  '*/drivers/gpio/dev-sync-probe.[ch]' '*/kernel/irq/irq_sim.c' '*/drivers/pwm/pwm-pca9685.c' '*/drivers/media/test-drivers/vimc/*.[ch]' 2> "$work/tar.log" ||
  [[ -e $work/drivers/gpio/gpio-sim.c && -e $work/drivers/pwm/pwm-pca9685.c && -e $work/kernel/irq/irq_sim.c && -e $work/drivers/media/test-drivers/vimc/vimc-core.c ]] || fail "$source_package has no such drivers"

tree=$work/root/usr/src/$headers
# Where the package would be installed is written into it.
sed -i "s|/usr/src/|$work/root/usr/src/|" "$tree/Makefile"
build=$work/build
mkdir "$build"
cp "$work"/drivers/gpio/gpio-sim.c "$work"/drivers/gpio/*.h "$work"/drivers/pwm/pwm-pca9685.c "$build/"
# The interrupt simulator is built in or absent, and here it is absent; what it calls is not exported, but this is.
{
  printf '#include <linux/irq.h>\n#include <linux/irqdesc.h>\n#include <linux/module.h>\n'
  sed 's/irq_to_desc(\([^()]*\))/irq_data_to_desc(irq_get_irq_data(\1))/' "$work/kernel/irq/irq_sim.c"
} > "$build/irq_sim.c"
mv "$build/gpio-sim.c" "$build/gpio_sim_main.c"
objects="gpio_sim_main.o irq_sim.o"
if [[ -e $work/drivers/gpio/dev-sync-probe.c ]]; then cp "$work/drivers/gpio/dev-sync-probe.c" "$build/"; objects+=" dev-sync-probe.o"; fi
cp "$work"/drivers/media/test-drivers/vimc/*.[ch] "$build/"
"$(dirname "$(readlink -f "$0")")/vimc_sensor.sh" "$build"
{
  printf 'obj-m := gpio-sim.o pwm-pca9685.o vimc.o\ngpio-sim-y := %s\n' "$objects"
  printf 'vimc-y := %s\n' "$(cd "$build" && printf '%s ' vimc-*.c | sed 's/\.c /.o /g')"
} > "$build/Makefile"
# Type information for tracing programs would need the whole kernel, which is not in the packages.
make -C "$tree" M="$build" CONFIG_DEBUG_INFO_BTF_MODULES= modules >> "$log" 2>&1 || { tail -n 20 "$log" >&2; fail "the modules don't build: $log"; }
mkdir -p "$extra"
for module in "$build"/*.ko; do strip --strip-debug -o "$extra/$(basename "$module")" "$module"; done
/sbin/depmod -b "$kernel" "$version" 2> /dev/null
touch "$extra/complete"
