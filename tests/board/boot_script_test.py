#!/usr/bin/env python3
"""Which of the two systems the boot script starts, tried with Debian's U-Boot in QEMU and kernels that do nothing but switch off.

    tests/board/boot_script_test.py [FOLDER]     after ./dev image; FOLDER: the image's (default build/image); a minute or two

The script is the image's own, from its FAT partition; what counts is on a small disk of the test's.
"""

import glob
import os
import re
import struct
import subprocess
import sys
import tempfile

from boot_state import newest, pack, read_copies, write_copy

MIB = 1 << 20
# The image's partitions with less in them: number, first MiB, how many.
PARTITIONS = {1: (4, 64), 2: (68, 1), 3: (69, 1), 4: (70, 134), 5: (71, 1), 6: (73, 64), 7: (138, 64)}
failures = []


def kernel_that_switches_off():
    """Returns an arm64 kernel's header and, as its only code, PSCI's SYSTEM_OFF"""
    code = struct.pack("<4I", 0x52800100, 0x72B08000, 0xD4000002, 0x14000000)  # w0 = 0x84000008; hvc 0; wait for ever
    header = struct.pack("<IIQQQ", 0x14000010, 0, 0, 0x10000, 0xA).ljust(56, b"\0") + b"ARM\x64"
    return (header.ljust(64, b"\0") + code).ljust(4096, b"\0")


class Disk:
    """A disk with the image's boot script; `systems` have a kernel."""

    def __init__(self, work, image, systems="AB"):
        self.path = f"{work}/disk.img"
        self.work = work
        with open(self.path, "wb") as file:
            file.truncate(204 * MIB)
        lines = [f"start={first}MiB, size={count}MiB, type={5 if number == 4 else 'c, bootable' if number == 1 else 83}"
                 for number, (first, count) in PARTITIONS.items()]
        subprocess.run(["sfdisk", "-q", self.path], input="label: dos\nlabel-id: 0x39444f54\n" + "\n".join(lines) + "\n", text=True, check=True)
        subprocess.run(["mcopy", "-o", "-i", f"{image}@@4M", "::boot.scr", work], check=True)
        self.make_fat(1, ["boot.scr"])
        with open(f"{work}/vmlinuz", "wb") as file:
            file.write(kernel_that_switches_off())
        with open(f"{work}/initrd.gz", "wb") as file:
            file.write(b"nobody reads this")
        for number, system in ((6, "A"), (7, "B")):
            self.make_fat(number, ["vmlinuz", "initrd.gz"] if system in systems else [])

    def make_fat(self, number, names):
        first, count = PARTITIONS[number]
        fat = f"{self.work}/fat.img"
        if os.path.exists(fat):
            os.remove(fat)
        with open(fat, "wb") as file:
            file.truncate(count * MIB)
        subprocess.run(["mkfs.vfat", fat], check=True, stdout=subprocess.DEVNULL)
        for name in names:
            subprocess.run(["mcopy", "-i", fat, f"{self.work}/{name}", "::"], check=True)
        subprocess.run(["dd", f"if={fat}", f"of={self.path}", "bs=1M", f"seek={first}", "conv=notrunc", "status=none"], check=True)

    def start(self, loader):
        """Returns what U-Boot said until the machine switched off or began anew"""
        done = subprocess.run(
            ["qemu-system-aarch64", "-M", "virt", "-cpu", "cortex-a53", "-m", "1G", "-bios", loader, "-nic", "none",
             "-drive", f"file={self.path},format=raw,if=none,id=d0", "-device", "virtio-blk-pci,drive=d0", "-nographic", "-monitor", "none", "-no-reboot"],
            stdin=subprocess.DEVNULL, capture_output=True, timeout=300, check=False)
        return done.stdout.decode(errors="replace")


def state(order, a_left, b_left):
    return {"BOOT_ORDER": order, "BOOT_A_LEFT": str(a_left), "BOOT_B_LEFT": str(b_left)}


def check(what, disk, loader, copies, system, after, trial=False):
    """Starts with these two copies on the disk: this system has to be started, and the state has to be this afterwards, in a copy that was the older one."""
    for number, copy in enumerate(copies):
        write_copy(disk.path, number, copy)
    kept = newest(disk.path)
    said = disk.start(loader)
    started = re.findall(r"ninedot: system ([AB]), starts left before this one: \w+; (.*)", said)
    wrong = []
    if system:
        root = {"A": "02", "B": "05"}[system]
        if [name for name, _ in started] != [system]:
            wrong.append(f"started {started}, not {system}")
        elif f"root=PARTUUID=39444f54-{root} rauc.slot={system}" not in started[0][1] or (" ninedot.trial" in started[0][1]) != trial:
            wrong.append(f"the kernel's command line: {started[0][1]}")
    found = newest(disk.path)
    if found is None or found[1] != after:
        wrong.append(f"afterwards {found}, not {after}")
    if kept and "cannot be started" not in said and read_copies(disk.path)[kept[0]] != copies[kept[0]]:
        wrong.append("the newest copy was written over, not the older one")
    if wrong:
        failures.append(what)
        print(f"FAILED {what}: {'; '.join(wrong)}\n{said}", flush=True)
    else:
        print(f"ok     {what}", flush=True)


def torn(new, old, sectors):
    """Returns a copy of which only the first sectors had been written when the power went"""
    return new[:512 * sectors] + old[512 * sectors:]


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else "build/image"
    loader, image = f"{folder}/u-boot.bin", next(iter(glob.glob(f"{folder}/ninedot-arm64*.img")), f"{folder}/ninedot-arm64.img")
    for file in (loader, image):
        if not os.path.exists(file):
            print(f"boot_script_test.py: no {file}: ./dev image", file=sys.stderr)
            return 2
    nothing = b"\xff" * 0x4000
    with tempfile.TemporaryDirectory() as work:
        disk = Disk(work, image)
        first = state("A B", 9, 0)
        check("as made: A", disk, loader, [pack(1, first)] * 2, "A", state("A B", 8, 0))
        updated = state("B A", 9, 2)
        check("after an update: B, on trial", disk, loader, [pack(1, first), pack(2, updated)], "B", state("B A", 9, 1), trial=True)
        check("the last start of a trial", disk, loader, [pack(3, state("B A", 9, 1)), pack(2, updated)], "B", state("B A", 9, 0), trial=True)
        check("no starts left: the one before", disk, loader, [pack(3, state("B A", 9, 0)), pack(2, updated)], "A", state("B A", 8, 0))
        check("a slot that is being written to is not in the order", disk, loader, [pack(3, state("A", 9, 9)), pack(2, first)], "A", state("A", 8, 9))
        check("confirmed: no trial", disk, loader, [pack(3, state("B A", 9, 9)), pack(4, state("B A", 9, 3))], "B", state("B A", 9, 2))
        check("counts 255 and 0: 0 is newer, first place", disk, loader, [pack(0, updated), pack(255, first)], "B", state("B A", 9, 1), trial=True)
        check("counts 255 and 0: 0 is newer, second place", disk, loader, [pack(255, first), pack(0, updated)], "B", state("B A", 9, 1), trial=True)
        check("count 255 is followed by 0", disk, loader, [pack(255, updated), pack(254, first)], "B", state("B A", 9, 1), trial=True)
        check("equal counts: the first", disk, loader, [pack(7, updated), pack(7, first)], "B", state("B A", 9, 1), trial=True)
        for sectors in (1, 17, 31):
            # Text differs in the first sector only; a long variable makes the others differ.
            long_old, long_new = ({**values, "filler": letter * 16000} for values, letter in ((first, "o"), (updated, "n")))
            check(f"power cut after {sectors} of 32 sectors of the variables", disk, loader,
                  [torn(pack(3, long_new), pack(1, long_old), sectors), pack(2, first)], "A", state("A B", 8, 0))
        check("neither copy whole: begins anew", disk, loader, [nothing, nothing], "A", state("A B", 8, 9))
        check("no starts left at all: both get new ones", disk, loader, [pack(3, state("B A", 0, 0)), nothing], "", state("A B", 9, 9))
        disk = Disk(work, image, systems="A")
        check("B without a kernel: counted out", disk, loader, [pack(1, first), pack(2, updated)], "B", state("B A", 9, 0), trial=True)
        copies = read_copies(disk.path)
        check("and A at the next start", disk, loader, copies, "A", state("B A", 8, 0))
    print("boot script test " + (f"FAILED: {len(failures)}" if failures else "passed"))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
