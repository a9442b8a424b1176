#!/usr/bin/python3
"""The drivers of the ninedot-modules package, in Debian's kernel on QEMU: all are loaded on its board "virt"; then each camera's driver meets its
overlay on the model of a Raspberry Pi 3's chip. There is no camera, so a driver that has taken the overlay (clock, lanes, link frequency, power) fails
where it first talks to the sensor, on I2C: that is what is looked for.

    tests/board/drivers_test.py FOLDER PACKAGE     FOLDER: the kernel's packages and BusyBox, as toolchains/image.sh keeps them in
                                                   /var/tmp/ninedot-cache/board-*/board, or that of backports, in board-pi5-*/board; PACKAGE: what
                                                   toolchains/modules.sh made of it

Needs qemu-system-arm, device-tree-compiler, kmod, cpio, xz-utils. Takes two to five minutes. The board's power switch, on a line of the firmware that QEMU
has not, is why the tree is the Zero 2 W's, which has the same chip.
"""

import glob
import os
import re
import subprocess
import sys
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
LIMIT_S = 300  # a busy machine emulates slowly

# What the driver says when nobody answers on I2C, having taken everything else.
UNANSWERED = {
    "ov9281": ("ov9282", r"ov9282 \d+-0060: (error -\w+: )?failed to power-on the sensor"),
    "imx296": ("imx296", r"imx296 \d+-001a: (8-bit write to|failed to get sensor out of standby)"),
    "imx219": ("imx219", r"imx219 \d+-0010: .*failed to read chip id"),
    "ov5647": ("ov5647", r"ov5647 \d+-0036: write sensor_oe_enable_regs error"),
}

INIT = """#!/bin/busybox sh
export PATH=/bin
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
while read -r module; do insmod "/modules/$module" && echo "loaded $module" || echo "refused $module"; done < /modules/order
sleep 2
dmesg | grep -E '[0-9]+-00[0-9a-f]{2}: |nknown symbol|disagrees|invalid module format' | sed 's/^/says: /'
echo "pwm chips: $(ls /sys/class/pwm)"
echo "uart0: $(ls /sys/bus/platform/devices /sys/bus/amba/devices 2> /dev/null | grep -c 3f201000.serial)"
echo "overlays: $(ls /proc/device-tree/ninedot-overlays 2> /dev/null)"
echo the-end
while :; do sleep 60; done
"""


def fail(what):
    print(f"FAILED: {what}", file=sys.stderr)
    sys.exit(1)


def unpack(pattern, place):
    found = glob.glob(pattern)
    if len(found) != 1:
        sys.exit(f"drivers_test.py: {len(found)} of {pattern}: ./dev image makes them")
    subprocess.run(["dpkg-deb", "-x", found[0], place], check=True)


class Guest:
    """A kernel with a first program that loads drivers and tells what the kernel says."""

    def __init__(self, folder, package, work):
        self.work, self.root = work, os.path.join(work, "root")
        # The kernel of backports is in four packages.
        parts = [kind for kind in ("image", "base", "binary", "modules") if glob.glob(f"{folder}/linux-{kind}-[0-9]*.deb")]
        for pattern in (*(f"{folder}/linux-{kind}-[0-9]*.deb" for kind in parts or ["image"]), f"{folder}/busybox-static_*.deb", package):
            unpack(pattern, self.root)
        os.symlink("usr/lib", os.path.join(self.root, "lib"))
        self.version = os.listdir(os.path.join(self.root, "usr/lib/modules"))[0]
        subprocess.run(["/sbin/depmod", "-b", self.root, self.version], check=True)
        extra = glob.glob(os.path.join(self.root, "usr/lib/modules", self.version, "extra", "*.ko"))
        self.extra = sorted(os.path.basename(path)[:-3] for path in extra)

    def find(self, *patterns):
        """Returns the file of the kernel's packages that is at one of these places"""
        return next(path for pattern in patterns for path in glob.glob(os.path.join(self.root, pattern)))

    def files_of(self, modules):
        """Returns the files to load, in an order in which each finds what it needs"""
        files = []
        for module in modules:
            said = subprocess.run(["/sbin/modprobe", "-d", self.root, "-S", self.version, "--show-depends", module],
                                  capture_output=True, text=True, check=True).stdout
            files += [line.split()[1] for line in said.splitlines() if line.startswith("insmod")]
        return list(dict.fromkeys(files))

    def make_initrd(self, modules):
        tree = tempfile.mkdtemp(dir=self.work)
        for name in ("bin", "dev", "proc", "sys", "modules"):
            os.mkdir(os.path.join(tree, name))
        subprocess.run(["cp", os.path.join(self.root, "usr/bin/busybox"), os.path.join(tree, "bin/")], check=True)
        names = []
        for path in self.files_of(modules):
            name = os.path.basename(path).removesuffix(".xz")
            with open(os.path.join(tree, "modules", name), "wb") as file:
                subprocess.run(["xz", "-dc", path] if path.endswith(".xz") else ["cat", path], stdout=file, check=True)
            names.append(name)
        with open(os.path.join(tree, "modules/order"), "w", encoding="ascii") as file:
            file.write("".join(name + "\n" for name in names))
        with open(os.path.join(tree, "init"), "w", encoding="ascii") as file:
            file.write(INIT)
        os.chmod(os.path.join(tree, "init"), 0o755)
        initrd = tree + ".cpio"
        subprocess.run(f"cd '{tree}' && find . | cpio --quiet -o -H newc > '{initrd}'", shell=True, check=True)
        return initrd

    def run(self, machine, modules):
        """Returns what the guest wrote on its console"""
        console = tempfile.mktemp(dir=self.work)
        kernel = self.find("boot/vmlinuz-*", "usr/lib/modules/*/vmlinuz")
        qemu = subprocess.Popen(["qemu-system-aarch64", *machine, "-kernel", kernel, "-initrd", self.make_initrd(modules),
                                 "-append", "console=ttyAMA0,115200 panic=-1 loglevel=1", "-serial", f"file:{console}",
                                 "-display", "none", "-monitor", "none", "-no-reboot"], stdin=subprocess.DEVNULL)
        try:
            end = time.monotonic() + LIMIT_S
            while time.monotonic() < end and qemu.poll() is None:
                time.sleep(0.5)
                with open(console, encoding="ascii", errors="replace") as file:
                    said = file.read()
                if "the-end" in said:
                    return said
        finally:
            qemu.kill()
            qemu.wait()
        fail(f"no end within {LIMIT_S} s on {machine}: {said[-1000:]}")


def check_all_load(guest):
    said = guest.run(["-M", "virt", "-cpu", "cortex-a53", "-m", "512"], guest.extra)
    for name in guest.extra:
        if f"loaded {name}.ko" not in said:
            fail(f"{name} can't be loaded: {said}")
    if re.search("refused|nknown symbol|disagrees|invalid module format", said):
        fail(said)
    print(f"ok: {len(guest.extra)} drivers load into {guest.version}: {', '.join(guest.extra)}", flush=True)


def check_overlay(guest, sensor):
    driver, pattern = UNANSWERED[sensor]
    tree = os.path.join(guest.work, f"{sensor}.dtb")
    board = guest.find(*(f"usr/lib/{place}/broadcom/bcm2837-rpi-zero-2-w.dtb" for place in ("linux-image-*", "modules/*/dtb")))
    asked = [f"camera-{sensor}-zero2", "pwm-gpio12-13", "uart-ttyAMA0"]
    subprocess.run(["fdtoverlay", "-i", board, "-o", tree, *(os.path.join(guest.work, "overlays", name + ".dtbo") for name in asked)], check=True)
    said = guest.run(["-M", "raspi3b", "-dtb", tree], ["fixed", "i2c-bcm2835", "pwm-bcm2835", "bcm2835-unicam", driver])
    told = re.findall("says: (.*)", said)
    if not re.search(pattern, said):
        fail(f"{sensor}: the driver did not come as far as the sensor: {told or said}")
    for wanted in ("pwm chips: pwmchip0", "uart0: 1", *asked):
        if wanted not in said:
            fail(f"{sensor}: not seen: {wanted}: {said[-1500:]}")
    print(f"ok: camera-{sensor}: taken by the driver; it misses the sensor alone: {re.search(pattern, said)[0]}", flush=True)


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: tests/board/drivers_test.py FOLDER PACKAGE")
    with tempfile.TemporaryDirectory() as work:
        subprocess.run([os.path.join(ROOT, "toolchains/overlays.sh"), os.path.join(work, "overlays")], check=True)
        guest = Guest(sys.argv[1], sys.argv[2], work)
        check_all_load(guest)
        for sensor in UNANSWERED:
            check_overlay(guest, sensor)


if __name__ == "__main__":
    main()
