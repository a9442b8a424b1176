#!/bin/bash
# Compiles the device-tree overlays of the board image from systemd/image/overlays.
#
#   toolchains/overlays.sh FOLDER [pi5]     FOLDER is made; one NAME.dtbo for each line dtoverlay=NAME that config.txt may have; pi5: those of its image
#
# A camera's overlay is made of a board's file and a sensor's: camera-SENSOR for the Raspberry Pi 4, camera-SENSOR-BOARD for others. Each leaves
# its name in the device tree, below /ninedot-overlays, by which the board knows what was applied (systemd/image/root/usr/lib/ninedot/configure).
set -euo pipefail
shopt -s inherit_errexit
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."
fail() { echo "overlays.sh: $*" >&2; exit 2; }
[[ $# -eq 1 || $# -eq 2 && $2 == pi5 ]] || fail "say where to: toolchains/overlays.sh FOLDER [pi5]"
command -v dtc > /dev/null || fail "needs dtc: ./dev packages image"
out=$1 sources=systemd/image/overlays
mkdir -p "$out"

# compile NAME SOURCE...
compile() {
  local name=$1 source; shift
  {
    printf '/dts-v1/;\n/plugin/;\n'
    for source in "$@"; do printf '/include/ "%s.dtsi"\n' "$source"; done
    printf '/ { fragment@99 { target-path = "/"; __overlay__ { ninedot-overlays { %s; }; }; }; };\n' "$name"
  } | dtc -I dts -O dtb -i "$sources" -W no-unit_address_vs_reg -o "$out/$name.dtbo" - || fail "$name can't be compiled"
}

sensors=(ov9281 imx296 imx219 ov5647)
if [[ -n ${2:-} ]]; then
  for sensor in "${sensors[@]}"; do
    for board in pi5 pi5-cam0; do compile "camera-$sensor-$board" "$board" "$sensor"; done
  done
  compile i2c-gpio2-3 i2c-gpio2-3
  exit
fi
for sensor in "${sensors[@]}"; do
  compile "camera-$sensor" pi4 "$sensor"
  for board in pi3 zero2; do compile "camera-$sensor-$board" "$board" "$sensor"; done
done
for name in pwm-gpio12-13 pwm-gpio18-19 uart-ttyAMA0; do compile "$name" "$name"; done
