"""A small Linux guest under QEMU, and a shell in it.

Everything that the tests do to devices happens in there: the host's own /dev, /sys and /proc are never touched.
"""

import json
import os
import pathlib
import shlex
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.request

BOOT_WITHIN_S = 120.0  # 6 s on an idle machine; the machine may be busy


class GuestFailed(Exception):
    """The guest does not do what every test takes for granted."""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Guest:
    """Context manager. `extra` are further arguments of QEMU; {folder} in them becomes a private folder for sockets."""

    MODBUS_PORT, FILES_PORT, PAGE_PORT = 1502, 8080, 8090

    def __init__(self, image, log, extra=()):
        self.image = pathlib.Path(image)
        self.log = pathlib.Path(log)
        self.extra = list(extra)
        self.modbus_port, self.files_port, self.page_port = free_port(), free_port(), free_port()
        self.process = None
        self.channel = None
        self.serial_number = 0

    def __enter__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ninedot-hil-"))
        try:
            self._boot()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self.channel:
            self.channel.close()
        if self.process and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _boot(self):
        shell = self.folder / "shell"
        command = [
            "qemu-system-x86_64",
            "-M",
            "q35",
            "-cpu",
            "max",
            "-smp",
            "2",
            "-m",
            "1G",
            "-accel",
            "tcg,thread=multi",
            "-nodefaults",
            "-display",
            "none",
            "-no-reboot",
            "-kernel",
            self.image / "kernel",
            "-initrd",
            self.image / "initramfs",
            "-append",
            # On a busy host the emulated timer comes too late for the kernel's check of it.
            "console=ttyS0 quiet loglevel=4 mitigations=off panic=1 no_timer_check",
            "-serial",
            f"file:{self.log}",
            "-chardev",
            f"socket,id=shell,path={shell},server=on,wait=off",
            "-device",
            "virtio-serial-pci",
            "-device",
            "virtconsole,chardev=shell",
            "-qmp",
            f"unix:{self.folder / 'qmp'},server=on,wait=off",
            "-netdev",
            f"user,id=net,restrict=on,hostfwd=tcp:127.0.0.1:{self.modbus_port}-:{self.MODBUS_PORT}"
            f",hostfwd=tcp:127.0.0.1:{self.files_port}-:{self.FILES_PORT}"
            f",hostfwd=tcp:127.0.0.1:{self.page_port}-:{self.PAGE_PORT}",
            "-device",
            "virtio-net-pci,netdev=net,romfile=",
        ] + [argument.format(folder=self.folder) for argument in self.extra]
        self.log.write_text("")
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        deadline = time.monotonic() + BOOT_WITHIN_S
        while "init: ready" not in self.log.read_text(errors="replace"):
            if self.process.poll() is not None:
                raise GuestFailed(f"QEMU ended: {self.process.stderr.read().decode(errors='replace').strip()}")
            if time.monotonic() > deadline:
                raise GuestFailed(f"the guest did not start within {BOOT_WITHIN_S:.0f} s; its console: {self.log}")
            time.sleep(0.1)
        self.channel = socket.socket(socket.AF_UNIX)
        self.channel.connect(os.fspath(shell))
        self.check("true")

    def run(self, command, timeout_s=30.0):
        """\\return  (exit status, what it wrote to both of its outputs)"""
        self.serial_number += 1
        end = f"--end-{self.serial_number}:"
        # In a subshell, so that `exit` and `cd` concern this command alone; without input, which is the shell's own; into a file,
        # because programs draw progress on terminals.
        line = f'({command}\n) < /dev/null > /tmp/.output 2>&1 3>&-; status=$?; cat /tmp/.output >&3; echo "\n{end}$status" >&3\n'
        self.channel.sendall(line.encode())
        text = b""
        deadline = time.monotonic() + timeout_s
        while True:
            left = deadline - time.monotonic()
            if left <= 0:
                raise GuestFailed(f"no end within {timeout_s:.0f} s: {command}\n{text.decode(errors='replace')}")
            self.channel.settimeout(left)
            try:
                part = self.channel.recv(65536)
            except socket.timeout:
                continue
            if not part:
                raise GuestFailed(f"the guest is gone during: {command}; its console: {self.log}")
            text += part
            output, found, status = text.rpartition(f"\n{end}".encode())
            if found and status.endswith(b"\n"):
                return int(status), output.decode(errors="replace").replace("\r", "").strip("\n")

    def check(self, command, timeout_s=30.0):
        """The output of a command that has to succeed."""
        status, output = self.run(command, timeout_s)
        if status != 0:
            raise GuestFailed(f"status {status}: {command}\n{output}")
        return output

    def fetch(self, path):
        """An ordinary file of the guest's, of any size: the console is for texts of some kilobytes."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.files_port}{path}", timeout=30) as reply:
            return reply.read()

    def qmp(self, command, **arguments):
        """One command of QEMU's machine protocol."""
        with socket.socket(socket.AF_UNIX) as monitor:
            monitor.settimeout(10)
            monitor.connect(os.fspath(self.folder / "qmp"))
            lines = monitor.makefile("rw")
            lines.readline()
            for request in ({"execute": "qmp_capabilities"}, {"execute": command, "arguments": arguments}):
                lines.write(json.dumps(request) + "\n")
                lines.flush()
                while True:
                    reply = json.loads(lines.readline())
                    if "return" in reply:
                        break
                    if "error" in reply:
                        raise GuestFailed(f"QEMU refuses {command}: {reply['error']['desc']}")

    def write(self, path, text):
        self.check(f"mkdir -p {shlex.quote(os.path.dirname(path))}; cat > {shlex.quote(path)} << '--eof--'\n{text}\n--eof--")
