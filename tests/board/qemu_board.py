"""The board image in QEMU: power on and off, a root shell on its virtual console, Modbus TCP through its emulated network."""

import http.client
import os
import re
import socket
import struct
import subprocess
import time
import zlib

# Without the root: that is the boot loader's to say. With KASLR the kernel keeps its page tables apart, in spite of mitigations=off, which costs an
# emulated processor a flush at each system call.
ARGUMENTS = ("ro panic=10 systemd.gpt_auto=0 console=ttyAMA0 quiet loglevel=3 systemd.show_status=0 "
             "mitigations=off nokaslr audit=0 systemd.getty_auto=0 systemd.debug_shell=hvc0")
COMMAND_LINE = "root=PARTUUID=39444f54-02 " + ARGUMENTS
# With ACPI, QEMU leaves the GPIO chip out when there is a boot loader, whose device tree (below) has it.
MACHINE = ["-M", "virt,acpi=off", "-cpu", "cortex-a53", "-smp", "2", "-m", "1G"]
BOARD_SERIAL = "10000000a1b2c3d4"  # as long as a Raspberry Pi's


def partition(path, number):
    """Returns where a partition of a disk image begins and how long it is, in bytes; from 5 on, it is one of those behind one another in the fourth"""
    def entry(table, place):
        image.seek(table * 512)
        return struct.unpack_from("<II", image.read(512), 446 + 16 * place + 8)

    with open(path, "rb") as image:
        first, count = entry(0, min(number, 4) - 1)
        table = container = first
        for place in range(5, number + 1):
            first, count = entry(table, 0)
            first += table
            if place < number:
                table = container + entry(table, 1)[0]
    return first * 512, count * 512


class Failure(Exception):
    """What the test found wrong."""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Board:
    """One machine; its disk image keeps what was written from one power-on to the next.

    With a loader (U-Boot) it starts as a board does, and starts again when its system asks for it; without one QEMU loads the kernel of the first system.
    """

    def __init__(self, work, kernel=None, initrd=None, loader=None, stick=None):
        self.work, self.kernel, self.initrd, self.loader, self.stick = work, kernel, initrd, loader, stick
        self.qemu = self.console = None
        self.heard = b""
        self.port, self.ssh_port, self.page_port = free_port(), free_port(), free_port()
        self.asked = 0

    def device_tree(self, arguments=""):
        """Returns the machine's own tree with a serial number, and the kernel's arguments if there are any, as a board's firmware puts them there"""
        path = f"{self.work}/board-{zlib.crc32(arguments.encode()):x}.dtb"
        if not os.path.exists(path):
            subprocess.run(["qemu-system-aarch64", *MACHINE[:1], f"{MACHINE[1]},dumpdtb={path}.new", *MACHINE[2:], "-nic", "none", "-display", "none"],
                           stdin=subprocess.DEVNULL, capture_output=True, check=True)
            subprocess.run(["fdtput", "-t", "s", f"{path}.new", "/", "serial-number", BOARD_SERIAL], check=True)
            if arguments:
                subprocess.run(["fdtput", "-t", "s", f"{path}.new", "/chosen", "bootargs", arguments], check=True)
            os.rename(f"{path}.new", path)
        return path

    def power_on(self, more_arguments=""):
        """With a loader: `more_arguments` for the kernel."""
        path = f"{self.work}/console.sock"
        if self.loader:
            start = ["-bios", self.loader, "-dtb", self.device_tree(f"{ARGUMENTS} {more_arguments}".strip())]
        else:
            start = ["-dtb", self.device_tree(), "-kernel", self.kernel, "-initrd", self.initrd, "-append", COMMAND_LINE, "-no-reboot"]
        if self.stick:
            start += ["-drive", f"file={self.stick},format=raw,if=none,id=d1,readonly=on", "-device", "virtio-blk-pci,drive=d1"]
        self.qemu = subprocess.Popen(
            ["qemu-system-aarch64", *MACHINE, "-accel", "tcg,thread=multi",
             "-drive", f"file={self.work}/board.img,format=raw,if=none,id=d0", "-device", "virtio-blk-pci,drive=d0",
             "-netdev", f"user,id=n0,hostfwd=tcp:127.0.0.1:{self.port}-:1502,hostfwd=tcp:127.0.0.1:{self.ssh_port}-:22,"
             f"hostfwd=tcp:127.0.0.1:{self.page_port}-:8090",
             "-device", "virtio-net-pci,netdev=n0,romfile=",
             "-chardev", f"socket,id=c0,path={path},server=on,wait=off,logfile={self.work}/shell.log,logappend=on",
             "-device", "virtio-serial-pci", "-device", "virtconsole,chardev=c0",
             "-chardev", f"file,id=c1,path={self.work}/console.log,append=on", "-serial", "chardev:c1",
             "-display", "none", "-monitor", "none", *start],
            stdin=subprocess.DEVNULL)
        for _ in range(100):
            try:
                self.console = socket.socket(socket.AF_UNIX)
                self.console.connect(path)
                break
            except OSError:
                self.console.close()
                time.sleep(0.1)
        else:
            raise Failure("QEMU does not open its console")
        self.heard = b""

    def cut_power(self):
        """As a cabinet's switch does it: no signal that anything in the machine could act on."""
        if self.qemu:
            self.qemu.kill()
            self.qemu.wait()
            self.console.close()
            self.qemu = None

    def partition(self, number):
        """Returns where a partition of the disk image begins and how long it is, in bytes"""
        return partition(f"{self.work}/board.img", number)

    def overwrite(self, number, length):
        """The first bytes of a partition become 0xFF, as in flash that was erased."""
        start, whole = self.partition(number)
        with open(f"{self.work}/board.img", "r+b") as image:
            image.seek(start)
            image.write(b"\xff" * min(length, whole))

    def put_on_fat(self, text, name):
        """A file onto the configuration partition, as from another computer's card reader."""
        path = f"{self.work}/{name}"
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        subprocess.run(["mcopy", "-o", "-i", f"{self.work}/board.img@@{self.partition(1)[0]}", path, "::"], check=True)

    def take_from_fat(self, name):
        """A file of the configuration partition is deleted, likewise."""
        subprocess.run(["mdel", "-i", f"{self.work}/board.img@@{self.partition(1)[0]}", f"::{name}"], check=True)

    def page(self, path, token=""):
        """Returns HTTP status and body of the board's page, or None while nobody answers"""
        line = http.client.HTTPConnection("127.0.0.1", self.page_port, timeout=20)
        try:
            line.request("GET", path, headers={"Authorization": f"Bearer {token}"} if token else {})
            answer = line.getresponse()
            return answer.status, answer.read()
        except (OSError, http.client.HTTPException):
            return None
        finally:
            line.close()

    def log_in(self, command):
        """By ssh with the key that boot_test.sh made. Returns exit status and output"""
        done = subprocess.run(
            ["ssh", "-q", "-i", f"{self.work}/key", "-p", str(self.ssh_port), "-o", "BatchMode=yes", "-o", "StrictHostKeyChecking=no",
             "-o", f"UserKnownHostsFile={self.work}/known_hosts", "-o", "ConnectTimeout=60", "root@127.0.0.1", command],
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False)
        return done.returncode, done.stdout.strip()

    def listen(self, seconds):
        """Takes in what the console says, for so long or until it says something."""
        self.console.settimeout(max(seconds, 0.01))
        try:
            chunk = self.console.recv(65536)
        except TimeoutError:
            return
        if not chunk:
            raise Failure("QEMU has ended by itself: see the console's log")
        self.heard += chunk

    def type(self, line):
        self.console.sendall(line.encode() + b"\n")

    def wait_for_shell(self, limit_s):
        """Asks until somebody answers."""
        end = time.monotonic() + limit_s
        while time.monotonic() < end:
            self.type("echo shell-is-$((40 + 2))")
            self.listen(2.0)
            if b"shell-is-42" in self.heard:
                self.run("true", limit_s=60)
                return
        raise Failure(f"no shell on the console within {limit_s} s: {self.heard[-300:]!r}")

    def run(self, command, limit_s=60):
        """Returns what the command prints; a command that fails or does not end is a failure of the test."""
        status, text = self.try_run(command, limit_s)
        if status != 0:
            raise Failure(f"'{command}' ended with {status}: {text}")
        return text

    def try_run(self, command, limit_s=60):
        """Returns exit status and what was printed"""
        self.asked += 1
        begin, end = f"<<{self.asked}", f">>{self.asked}"
        # The marks are put together by the shell, so that an echo of the command line is not taken for its output.
        self.type(f"printf '%s\\n' '<''<{self.asked}'; {{ {command}\n}} 2>&1; printf '%s %s=\\n' '>''>{self.asked}' $?")
        deadline = time.monotonic() + limit_s
        pattern = re.compile(re.escape(begin.encode()) + rb"\r*\n(.*?)" + re.escape(end.encode()) + rb" (\d+)=", re.S)
        while time.monotonic() < deadline:
            found = pattern.search(self.heard)
            if found:
                self.heard = self.heard[found.end():]
                return int(found[2]), found[1].decode(errors="replace").replace("\r", "").strip()
            self.listen(deadline - time.monotonic())
        raise Failure(f"'{command}' did not end within {limit_s} s: {self.heard[-300:]!r}")

    def registers(self, first, count):
        """Returns the registers, or None while nobody answers"""
        request = struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, first, count)
        try:
            with socket.create_connection(("127.0.0.1", self.port), timeout=3) as line:
                line.sendall(request)
                reply = b""
                while len(reply) < 9 + 2 * count:
                    chunk = line.recv(512)
                    if not chunk:
                        return None
                    reply += chunk
        except OSError:
            return None
        if reply[7] != 3:
            raise Failure(f"Modbus exception: {reply.hex()}")
        return struct.unpack(f">{count}H", reply[9:9 + 2 * count])
