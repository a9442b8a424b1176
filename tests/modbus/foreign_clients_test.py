"""Stock clients read the register map: pymodbus and mbpoll, over TCP and over RTU on a pair of pseudo-terminals.

Usage: foreign_clients_test.py MODBUS_SERVE (the program built from serve_main.cpp)
The expected numbers are those of tests/proto/known_report.h, written down here a second time.
"""
import inspect
import math
import os
import re
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from pymodbus.client import ModbusSerialClient, ModbusTcpClient

SERVE = sys.argv.pop(1)
UNIT = 1
BAUD = 115200


def unit_argument(method):
    """The unit's keyword: `slave` up to pymodbus 3.9, `device_id` later, `unit` before 3."""
    names = inspect.signature(method).parameters
    for name in ("device_id", "slave", "unit"):
        if name in names:
            return {name: UNIT}
    return {"slave": UNIT}


def read(client, method_name, address, count):
    method = getattr(client, method_name)
    reply = method(address, count=count, **unit_argument(method))
    if reply.isError():
        raise AssertionError(reply)
    return reply.registers


def write(client, address, values):
    method = client.write_registers
    return method(address, values, **unit_argument(method))


def exception_code(reply):
    return getattr(reply, "exception_code", None)


def int32(words):
    return struct.unpack(">i", struct.pack(">HH", *words))[0]


def float32(words):
    return struct.unpack(">f", struct.pack(">HH", *words))[0]


class Server:
    """modbus_serve on a free port and on one end of a pseudo-terminal pair that socat holds together."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.far = os.path.join(self.folder.name, "controller")
        near = os.path.join(self.folder.name, "device")
        self.socat = subprocess.Popen(
            ["socat", f"pty,raw,echo=0,link={near}", f"pty,raw,echo=0,link={self.far}"])
        for _ in range(500):
            if os.path.exists(near) and os.path.exists(self.far):
                break
            time.sleep(0.01)
        try:
            self.process = subprocess.Popen(
                [SERVE, "--rtu", near], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            self.port = int(self.process.stdout.readline())
        except Exception:
            # socat left behind would hold the test's output open for ever.
            self.socat.terminate()
            self.socat.wait(10)
            raise

    def stop(self):
        self.process.stdin.close()
        status = self.process.wait(10)
        self.process.stdout.close()
        self.socat.terminate()
        self.socat.wait(10)
        self.folder.cleanup()
        return status


def setUpModule():
    global server
    server = Server()


def tearDownModule():
    # Under a sanitizer the status also tells what it found.
    if server.stop() != 0:
        raise AssertionError("modbus_serve did not end well")


class ChecksOfTheKnownReport:
    """What every client must see, whatever the transport."""

    def test_both_functions_read_the_whole_map(self):
        holding = read(self.client, "read_holding_registers", 0, 125)
        inputs = read(self.client, "read_input_registers", 0, 125)
        self.assertEqual(len(holding), 125)
        # The age and the counters of requests go on; the rest is the same.
        live = {8, 73, 74, 75, 76, 77, 79, 88, 89, 90, 91, 92, 93, 94, 95, 96, 97}
        for address in set(range(125)) - live:
            self.assertEqual(holding[address], inputs[address], f"register {address}")

    def test_values_are_those_of_the_report(self):
        r = read(self.client, "read_holding_registers", 0, 86)
        self.assertEqual(r[0], 0x9D09)
        self.assertEqual(r[2], 70001 & 0xFFFF)
        self.assertEqual(r[3], 66000 & 0xFFFF)
        self.assertEqual(r[39], r[3])
        self.assertEqual(r[4] & 1, 1)
        self.assertEqual(r[6:8], [7, 913])
        self.assertEqual(r[9], 88)
        self.assertEqual([v - 65536 if v > 32767 else v for v in r[10:16]], [2469, -5000, 6553, 300, -400, 1200])
        self.assertEqual([int32(r[a:a + 2]) for a in range(16, 28, 2)],
                         [1234568, -2500000, 3276700, 17189, -22918, 68755])
        self.assertEqual(r[28:39], [12, 34, 210, 29, 57, 115, 123, 46, 9, 1234, 65536 - 567])
        s = math.sin(0.65) / 1.3
        expected = [1234.5678, -2500.0, 3276.7, math.cos(0.65), 0.3 * s, -0.4 * s, 1.2 * s]
        for address, value in zip(range(40, 54, 2), expected):
            self.assertAlmostEqual(float32(r[address:address + 2]), value, delta=abs(value) * 1e-6)
        self.assertEqual(r[60], 350)
        self.assertEqual((r[61] << 16) + r[62], 100000)
        self.assertEqual(int32(r[80:82]), -1)
        self.assertEqual((r[82] << 16) + r[83], 0x12345678)
        self.assertEqual(float32(r[84:86]), 123456.0)

    def test_the_age_grows_between_two_reads(self):
        # The report is fixed, so only a fresh server shows an age below saturation; after that it stays there.
        first = read(self.client, "read_holding_registers", 8, 1)[0]
        time.sleep(0.05)
        second = read(self.client, "read_holding_registers", 8, 1)[0]
        self.assertTrue(second >= first + 450 or second == 65535, (first, second))

    def test_mistakes_get_their_exceptions(self):
        method = self.client.read_holding_registers
        self.assertEqual(exception_code(method(168, count=1, **unit_argument(method))), 2)
        self.assertEqual(exception_code(method(167, count=2, **unit_argument(method))), 2)
        self.assertEqual(exception_code(write(self.client, 10, [1])), 2)
        self.assertEqual(exception_code(write(self.client, 104, [2])), 3)

    def test_hold_is_written_and_releases_itself(self):
        self.assertFalse(write(self.client, 104, [1]).isError())
        self.assertEqual(read(self.client, "read_holding_registers", 104, 1), [1])
        self.assertTrue(read(self.client, "read_holding_registers", 4, 1)[0] & 0x200)
        time.sleep(0.6)
        self.assertEqual(read(self.client, "read_holding_registers", 104, 1), [0])

    def test_set_points_are_read_back(self):
        self.assertFalse(write(self.client, 105, [4500, 65536 - 1000]).isError())
        self.assertEqual(read(self.client, "read_holding_registers", 105, 2), [4500, 65536 - 1000])


class PymodbusOverTcp(ChecksOfTheKnownReport, unittest.TestCase):
    def setUp(self):
        self.client = ModbusTcpClient("127.0.0.1", port=server.port, timeout=5)
        self.assertTrue(self.client.connect())

    def tearDown(self):
        self.client.close()


class PymodbusOverRtu(ChecksOfTheKnownReport, unittest.TestCase):
    def setUp(self):
        # Pseudo-terminals have no parity bit; 8N1 is what pyserial can set on them.
        self.client = ModbusSerialClient(port=server.far, baudrate=BAUD, parity="N", timeout=5)
        self.assertTrue(self.client.connect())

    def tearDown(self):
        self.client.close()


class Mbpoll(unittest.TestCase):
    def poll(self, transport, first, count, kind, *more):
        """Values by address, as mbpoll prints them: `[16]: 	1234568`."""
        where = {"tcp": ["-m", "tcp", "-p", str(server.port)],
                 "rtu": ["-m", "rtu", "-b", str(BAUD), "-P", "none"]}[transport]
        target = {"tcp": "127.0.0.1", "rtu": server.far}[transport]
        command = ["mbpoll", *where, "-a", str(UNIT), "-0", "-1", "-o", "5", "-r", str(first), "-c", str(count),
                   "-t", kind, *more, target]
        run = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return {int(a): v for a, v in re.findall(r"^\[(\d+)\]:\s+(\S+)", run.stdout, re.MULTILINE)}

    def check(self, transport):
        for table in ("3", "4"):
            self.assertEqual(self.poll(transport, 0, 2, table + ":hex"), {0: "0x9D09", 1: "0x0001"})
            whole = self.poll(transport, 16, 3, table + ":int", "-B")
            self.assertEqual([int(v) for v in whole.values()], [1234568, -2500000, 3276700])
            floats = self.poll(transport, 40, 3, table + ":float", "-B")
            for shown, value in zip(floats.values(), (1234.5678, -2500.0, 3276.7)):
                self.assertAlmostEqual(float(shown), value, delta=0.01)

    def test_over_tcp(self):
        self.check("tcp")

    def test_over_rtu(self):
        self.check("rtu")


if __name__ == "__main__":
    unittest.main(verbosity=2)
