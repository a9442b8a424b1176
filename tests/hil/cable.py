"""A serial cable between an emulated port of the guest and a terminal of this machine, which can be pulled."""

import os
import select
import socket
import threading
import time
import tty

from guest import GuestFailed


def connect_to(path):
    """The other end of QEMU's character device."""
    deadline = time.monotonic() + 10
    while True:
        line = socket.socket(socket.AF_UNIX)
        try:
            line.connect(os.fspath(path))
            return line
        except OSError as error:
            line.close()
            if time.monotonic() > deadline:
                raise GuestFailed(f"QEMU's serial port does not take a connection: {error}") from None
            time.sleep(0.05)


class Cable:
    """Context manager. \\param path  the socket of QEMU's character device. `device` is what a Modbus master opens."""

    def __init__(self, path):
        self.path = path
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)  # held open here, so that the masters may come and go
        self.device = os.ttyname(self.slave)
        self.line = None
        self.stopping, self.wake = os.pipe()
        self.thread = None

    def __enter__(self):
        self.plug()
        return self

    def __exit__(self, *_):
        self.unplug()
        for descriptor in (self.master, self.slave, self.stopping, self.wake):
            os.close(descriptor)

    def plug(self):
        self.line = connect_to(self.path)
        self.thread = threading.Thread(target=self._carry, daemon=True)
        self.thread.start()

    def unplug(self):
        if self.thread:
            os.write(self.wake, b".")
            self.thread.join()
            self.line.close()
            self.thread = None

    def send(self, data):
        """Bytes past any terminal, as noise or another master would send them."""
        self.line.sendall(data)

    def _carry(self):
        while True:
            ready = select.select([self.stopping, self.master, self.line], [], [])[0]
            if self.stopping in ready:
                os.read(self.stopping, 1)
                return
            try:
                if self.master in ready:
                    self.line.sendall(os.read(self.master, 4096))
                if self.line in ready:
                    data = self.line.recv(4096)
                    if not data:
                        os.read(self.stopping, 1)
                        return
                    os.write(self.master, data)
            except OSError:
                os.read(self.stopping, 1)
                return
