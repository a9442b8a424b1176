"""Updates of the image in QEMU, with the boot loader that boards have. Started by update_test.sh, which makes the bundles."""

import argparse
import hashlib
import random
import re
import sys
import time

import boot_state
from boot_test import BOOT_LIMIT_S, wait_for_pose
from qemu_board import Board, Failure, partition
from reporting import note, require, table

STICK = "/run/stick"
ROOTS = {"A": 2, "B": 5}
MIB = 1 << 20
MARK = b"not yet written over"


class UpdateTest:
    """One board through its life."""

    def __init__(self, arguments):
        self.board = Board(arguments.work, loader=arguments.loader, stick=arguments.stick)
        self.image, self.console = f"{arguments.work}/board.img", f"{arguments.work}/console.log"
        self.cuts, self.trial_s = arguments.power_cuts, arguments.trial_s
        self.limit_s = max(BOOT_LIMIT_S, 2 * self.trial_s)
        self.rng = random.Random("power cuts")

    # What the board says and what its disk holds.

    def power_on(self, trial_s=None):
        self.board.power_on(f"ninedot.trial_s={trial_s or self.trial_s}")

    def state(self):
        """Returns the boot loader's variables, from the disk"""
        found = boot_state.newest(self.image)
        require(found is not None, "neither copy of the boot loader's variables is whole")
        return found[1]

    def starts(self):
        """Returns the systems that U-Boot has started so far, with how many starts each had left"""
        with open(self.console, encoding="utf-8", errors="replace") as file:
            return re.findall(r"ninedot: system ([AB]), starts left before this one: (\w+)", file.read())

    def sum_of(self, number):
        first, length = partition(self.image, number)
        with open(self.image, "rb") as file:
            file.seek(first)
            return hashlib.sha256(file.read(length)).hexdigest()

    def running(self):
        """Returns system and version of what runs, by what it says itself"""
        line = self.board.run("cat /proc/cmdline")
        slot = re.search(r"rauc\.slot=([AB])", line)
        require(slot and f"root=PARTUUID=39444f54-0{ROOTS[slot[1]]}" in line, f"the kernel's command line: {line}")
        return slot[1], self.board.run("sed -n 's/^IMAGE_VERSION=//p' /etc/os-release")

    def wait_for_system(self, system, version=None):
        """Until that system serves poses and has told the boot loader so"""
        limit_s = self.limit_s
        wait_for_pose(self.board, limit_s)
        self.board.wait_for_shell(limit_s)
        self.board.run("until [ \"$(systemctl show -P SubState ninedot-confirm)\" = dead ]; do sleep 1; done", limit_s=limit_s)
        said = self.board.run("journalctl -u ninedot-confirm -o cat --no-pager")
        require("this system works: kept" in said, f"not confirmed: {said}")
        slot, says = self.running()
        require(slot == system, f"system {slot} runs, not {system}; starts {self.starts()}")
        require(version is None or says == version, f"version {says} runs, not {version}")
        require(self.state()[f"BOOT_{system}_LEFT"] == "9", f"confirmed, and the boot loader has {self.state()}")

    def mount_stick(self):
        self.board.run(f"mkdir -p {STICK} && {{ mountpoint -q {STICK} || mount -o ro /dev/vdb {STICK}; }}")

    def install(self, name):
        """Returns exit status and what RAUC said"""
        self.mount_stick()
        return self.board.try_run(f"rauc install {STICK}/{name}.raucb", 2 * self.limit_s)

    # What must hold.

    def check_first_start(self):
        started = time.monotonic()
        self.power_on()
        self.wait_for_system("A")
        note("as made, by U-Boot", f"system A runs and is confirmed after {time.monotonic() - started:.0f} s")
        said = self.board.run("rauc status --detailed")
        require("Booted from: rootfs.0 (A)" in said, f"rauc status: {said}")
        require(self.board.run("fw_printenv BOOT_ORDER") == "BOOT_ORDER=A B", "fw_printenv reads other variables than the boot script wrote")
        status, said = self.board.try_run("setpriv --reuid=ninedot --clear-groups rauc status mark-bad other")
        require(status != 0 and self.state()["BOOT_B_LEFT"] == "0", f"the service's user may command updates: {said}")
        self.board.run("echo kept > /var/lib/ninedot/kept; sync")
        self.identity = self.board.run("cat /etc/machine-id")

    def check_refused(self):
        before, roots = self.state(), self.sum_of(ROOTS["B"])
        for name, what, reason in (("stranger", "a bundle that a stranger signed", "signature verification failed"),
                                   ("other", "a bundle for another kind of board", "compatible mismatch")):
            status, said = self.install(name)
            require(status != 0 and reason in said.lower(), f"{what}: {status}, {said}")
            require(self.state() == before and self.sum_of(ROOTS["B"]) == roots, f"{what} was refused and something has changed")
            note(what, "refused, nothing changed")
        status, said = self.install("changed")
        require(status != 0, f"a bundle that was changed after it was signed: {said}")
        require(self.state()["BOOT_ORDER"].split()[0] == "A" and self.state()["BOOT_A_LEFT"] == "9", f"the boot loader has {self.state()}")
        require(self.state()["BOOT_B_LEFT"] == "0", f"half a system may be started: {self.state()}")
        note("a bundle that was changed after it was signed", "refused; the system that runs stays the one that starts")

    def check_cut_while_writing(self):
        """Power goes while the other system is being written: the one that ran starts."""
        shares = [self.rng.uniform(0.05, 0.9) for _ in range(self.cuts)]
        for share in shares:
            self.mount_stick()
            place = partition(self.image, ROOTS["B"])[0] + int(share * 100) * MIB  # of a root that has more than 100 MiB
            with open(self.image, "r+b") as file:
                file.seek(place)
                file.write(MARK)
            self.board.type(f"rauc install {STICK}/good.raucb")
            self.wait_until_written(place)
            self.board.cut_power()
            require(self.state() == {"BOOT_ORDER": "A", "BOOT_A_LEFT": "9", "BOOT_B_LEFT": "0"}, f"half a system may be started: {self.state()}")
            self.power_on()
            self.wait_for_system("A")
        if shares:
            note(f"power cuts while the other system was being written (at {', '.join(f'{share:.0%}' for share in shares)})", "A starts each time")

    def wait_until_written(self, place, limit_s=600):
        """Until what stood at a place of the disk is written over."""
        end = time.monotonic() + limit_s
        with open(self.image, "rb", buffering=0) as file:  # what was read once is not what stands there
            while time.monotonic() < end:
                file.seek(place)
                if file.read(len(MARK)) != MARK:
                    return
                self.board.listen(0.05)
        raise Failure(f"the installation writes nothing: {self.board.heard[-500:]!r}")

    def check_update(self):
        """A good bundle: the other system runs, with what is on the data partition; a power cut before it is confirmed costs one of its starts."""
        started = time.monotonic()
        status, said = self.install("good")
        require(status == 0, f"rauc install: {said}")
        note("a good bundle", f"installed in {time.monotonic() - started:.0f} s")
        require(self.state() == {"BOOT_ORDER": "B A", "BOOT_A_LEFT": "9", "BOOT_B_LEFT": "2"}, f"the boot loader has {self.state()}")
        expects = self.board.run("cat /data/board/update-expects")
        require(expects == "camera", f"frames come, and the new system is not asked for them: {self.board.run('journalctl -u rauc -n 30 -o cat --no-pager')}")
        before = len(self.starts())
        if self.cuts:
            self.board.type("systemctl reboot")
            self.wait_for_start(before)
            end = time.monotonic() + self.rng.uniform(3, 20)
            while time.monotonic() < end:
                self.board.listen(0.2)
            self.board.cut_power()
            require(self.state()["BOOT_B_LEFT"] == "1", f"a power cut in the first start, and the boot loader has {self.state()}")
            self.power_on()
        else:
            self.board.type("systemctl reboot")
            self.wait_for_start(before)
        self.wait_for_system("B", "test-good")
        require(self.board.run("cat /var/lib/ninedot/kept") == "kept" and self.board.run("cat /etc/machine-id") == self.identity, "/data was not kept")
        require(self.starts()[before:] == [("B", "2"), ("B", "1")][:1 + bool(self.cuts)], f"starts: {self.starts()[before:]}")
        note("the start after it" + (", with a power cut before it was confirmed" if self.cuts else ""), "system B runs, confirmed, /data kept")

    def wait_for_start(self, before):
        end = time.monotonic() + self.limit_s
        while len(self.starts()) == before:
            require(time.monotonic() < end, f"no start within {self.limit_s} s")
            self.board.listen(0.2)
        self.board.heard = b""

    def check_cut_while_counting(self):
        """Power goes while the boot loader's variables are being written, by fw_setenv as RAUC does it."""
        for _ in range(self.cuts):
            self.board.heard = b""
            self.board.type("n=0; while fw_setenv test $n; do n=$((n + 1)); echo counted=$n=; done")
            end = time.monotonic() + self.rng.uniform(2, 6)
            while time.monotonic() < end or not re.search(rb"counted=\d", self.board.heard):  # and not the echo of the command
                self.board.listen(0.1)
                require(time.monotonic() < end + 60, "fw_setenv writes nothing")
            self.board.cut_power()
            whole = [boot_state.unpack(copy) is not None for copy in boot_state.read_copies(self.image)]
            require(any(whole) and self.state()["BOOT_ORDER"] == "B A", f"copies that are whole: {whole}")
            # As a disk leaves it that had erased a sector and not written it yet.
            number, _ = boot_state.newest(self.image)
            copies = boot_state.read_copies(self.image)
            boot_state.write_copy(self.image, number, copies[number][:512] + b"\xff" * 512 + copies[number][1024:])
            self.power_on()
            self.wait_for_system("B", "test-good")
        if self.cuts:
            note(f"power cuts while the boot loader's variables were being written, the newest copy torn ({self.cuts})", "B starts, by the other copy")

    def check_never_works(self):
        """A bundle whose service never starts: left by itself, for the system before."""
        status, said = self.install("never")
        require(status == 0, f"rauc install: {said}")
        require(self.state() == {"BOOT_ORDER": "A B", "BOOT_A_LEFT": "2", "BOOT_B_LEFT": "9"}, f"the boot loader has {self.state()}")
        before, started = len(self.starts()), time.monotonic()
        # By the switch, so that it starts with the two minutes that boards have.
        self.board.run("sync")
        self.board.cut_power()
        self.power_on(120)
        self.wait_for_start(before)
        while ("B", "9") not in self.starts()[before:]:
            require(time.monotonic() - started < 1200 + self.limit_s, f"not left: starts {self.starts()[before:]}")
            require(self.state()["BOOT_A_LEFT"] != "9", f"a system whose service never starts was kept: starts {self.starts()[before:]}")
            self.board.listen(0.5)
        back = time.monotonic() - started
        self.wait_for_system("B", "test-good")
        require(self.starts()[before:] == [("A", "2"), ("A", "1"), ("B", "9")], f"starts: {self.starts()[before:]}")
        require(self.state()["BOOT_A_LEFT"] == "0", f"the boot loader has {self.state()}")
        require(self.board.run("cat /var/lib/ninedot/kept") == "kept", "/data was not kept")
        note("a bundle whose service never starts", f"two starts, then by itself system B again, {back:.0f} s after power")


def main():
    parser = argparse.ArgumentParser()
    for name in ("work", "loader", "stick"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--power-cuts", type=int, required=True)
    parser.add_argument("--trial-s", type=int, required=True)
    started = time.monotonic()
    test = UpdateTest(parser.parse_args())
    try:
        test.check_first_start()
        test.check_refused()
        test.check_cut_while_writing()
        test.check_update()
        test.check_cut_while_counting()
        test.check_never_works()
    except Failure as failure:
        print(f"FAILED: {failure}", file=sys.stderr)
        return 1
    finally:
        test.board.cut_power()
    width = max(len(what) for what, _ in table)
    print("\n" + "\n".join(f"{what:<{width}}  {seen}" for what, seen in table) + f"\n\nupdate test passed in {time.monotonic() - started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
