"""Starts ninedotd on a recording for a test, and reads it with foreign Modbus clients."""

import contextlib
import csv
import inspect
import io
import logging
import os
import pathlib
import signal
import socket
import struct
import subprocess
import tempfile
import time

SOURCE = pathlib.Path(os.environ["NINEDOT_SOURCE_DIR"])
BIN = pathlib.Path(os.environ["NINEDOT_BIN_DIR"])
APPROACH = SOURCE / "tests" / "recordings" / "approach"
SANITIZED = bool(os.environ.get("NINEDOT_SANITIZED"))
# Sanitizers make everything several times slower; a test never waits this long when all is well.
PATIENCE_S = 60

os.environ["TERM"] = "xterm"  # of whatever terminal the tests were started

logging.disable(logging.CRITICAL)  # pymodbus reports every attempt to connect to a service that is still starting


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def config_text(recording=APPROACH, *, port=None, rtu_device=None, solver="full", rate_hz=35.0, extra=""):
    # Without tracking a frame's pose depends on that frame alone, so that the looped service and one replay agree exactly.
    text = f"""
[camera]
source = "recording"
device = "{recording}"
rate_hz = {rate_hz}
[pose]
solver = "{solver}"
tracking = false
{extra}
"""
    if port is not None:
        text += f'[modbus.tcp]\nlisten = "127.0.0.1"\nport = {port}\n'
    if rtu_device is not None:
        text += f'[modbus.rtu]\ndevice = "{rtu_device}"\nbaud = 115200\nparity = "N"\nunit = 7\n'
    return text


class Service:
    """A running ninedotd; leaves with SIGINT, as Ctrl-C does."""

    def __init__(self, config, *options):
        self.folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.config = pathlib.Path(self.folder.name) / "config.toml"
        self.config.write_text(config)
        self.log = open(pathlib.Path(self.folder.name) / "stderr", "w+")
        self.process = subprocess.Popen([BIN / "ninedotd", "--config", self.config, *options], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=self.log, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        status, log = self.process.poll(), self.log_text()
        if status is None:
            self.process.kill()
        self.process.communicate()
        self.log.close()
        self.folder.cleanup()
        # Whatever the test waited for in vain, this is why.
        assert exception[0] is None or status in (None, 0), f"ninedotd had ended with status {status}: {log}"

    def log_text(self):
        return pathlib.Path(self.log.name).read_text()

    def wait_for_log(self, text):
        deadline = time.monotonic() + PATIENCE_S
        while text not in self.log_text():
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise AssertionError(f"'{text}' never appeared in: {self.log_text()}")
            time.sleep(0.02)

    def end(self, with_signal=signal.SIGINT):
        """Exit status and standard output after a polite request to end."""
        self.process.send_signal(with_signal)
        out, _ = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out


def run(program, *arguments, **options):
    return subprocess.run([BIN / program, *arguments], capture_output=True, text=True, timeout=10 * PATIENCE_S,
                          stdin=subprocess.DEVNULL, **options)


def replay_rows(recording, *arguments):
    result = run("ninedot", "replay", recording, *arguments)
    assert result.returncode == 0, result.stderr
    return list(csv.DictReader(io.StringIO(result.stdout)))


@contextlib.contextmanager
def serial_line():
    """Two ends of a serial line without hardware. The kernel's pty knows no parity, so the tests use none."""
    with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
        ends = [os.path.join(folder, name) for name in ("service", "client")]
        cable = subprocess.Popen(["socat", *(f"pty,raw,echo=0,link={end}" for end in ends)], stderr=subprocess.DEVNULL)
        try:
            deadline = time.monotonic() + PATIENCE_S
            while not all(os.path.exists(end) for end in ends):
                assert cable.poll() is None and time.monotonic() < deadline, "socat did not make a pty pair"
                time.sleep(0.01)
            yield ends
        finally:
            cable.terminate()
            cable.wait()


class Client:
    """pymodbus, whose keyword for the unit changed its name between versions."""

    def __init__(self, *, port=None, device=None, unit=1):
        import pymodbus.client
        if port is not None:
            self.client = pymodbus.client.ModbusTcpClient("127.0.0.1", port=port, timeout=5)
        else:
            self.client = pymodbus.client.ModbusSerialClient(device, baudrate=115200, parity="N", stopbits=1, timeout=5)
        names = inspect.signature(self.client.read_holding_registers).parameters
        keyword = next((name for name in ("device_id", "slave", "unit") if name in names), "slave")
        self.unit = {keyword: unit}

    def __enter__(self):
        deadline = time.monotonic() + PATIENCE_S
        while not self.client.connect():
            assert time.monotonic() < deadline, "nothing answers"
            time.sleep(0.05)
        return self

    def __exit__(self, *exception):
        self.client.close()

    def read(self, address=0, count=125, holding=True):
        read = self.client.read_holding_registers if holding else self.client.read_input_registers
        reply = read(address, count=count, **self.unit)
        assert not reply.isError(), reply
        return reply.registers

    def write(self, address, values):
        reply = self.client.write_registers(address, values, **self.unit)
        assert not reply.isError(), reply

    def wait_for(self, condition):
        deadline = time.monotonic() + PATIENCE_S
        while True:
            registers = self.read()
            if condition(registers):
                return registers
            assert time.monotonic() < deadline, f"never came true; status {registers[4]}, reason {registers[5]}"
            time.sleep(0.01)


def int32(registers, address):
    return struct.unpack(">i", struct.pack(">HH", *registers[address:address + 2]))[0]


def float32(registers, address):
    return struct.unpack(">f", struct.pack(">HH", *registers[address:address + 2]))[0]


def int16(registers, address):
    return struct.unpack(">h", struct.pack(">H", registers[address]))[0]
