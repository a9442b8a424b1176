"""ninedotd reads its map again on SIGHUP: a right one at once and without losing a frame, a wrong one not at all."""

import fcntl
import os
import pathlib
import pty
import signal
import subprocess
import sys
import tempfile
import termios
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import BIN, PATIENCE_S, SANITIZED, Client, Service, config_text, free_port, int32

VALID = 1 << 0
MOVED_MM = 1000
# Slow, so that no frame is dropped on a machine that is busy with other things: a sanitized frame takes 60 ms.
RATE_HZ = 5 if SANITIZED else 15
ROUND_S = 22 / RATE_HZ  # of the recording, which is played again and again


def landmark(number, x_mm=None):
    """One without a place takes no part, and makes the map one of several landmarks all the same."""
    return f"[[landmarks]]\nid = {number}\n" + ("" if x_mm is None else f"position_mm = [{x_mm}, 0, 0]\n")


def hall(x_mm, others=1):
    return landmark(1, x_mm) + "".join(landmark(2 + i) for i in range(others))


def position(registers):
    return tuple(int32(registers, address) for address in (16, 18, 20))


def counters(registers):
    """Frames lost between sensor and loop, and frames that could not be read."""
    return (registers[63] << 16 | registers[64], registers[65] << 16 | registers[66])


class Reload(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(folder.cleanup)
        self.map = pathlib.Path(folder.name) / "hall.toml"
        self.port = free_port()

    def service(self, map_text, **options):
        self.map.write_text(map_text)
        return Service(f'map = "{self.map}"\n' + config_text(port=self.port, rate_hz=RATE_HZ, **options))

    def reload(self, service, map_text, answer):
        if map_text is None:
            self.map.unlink()
        else:
            self.map.write_text(map_text)
        said = service.log_text().count(answer)
        service.process.send_signal(signal.SIGHUP)
        deadline = time.monotonic() + PATIENCE_S
        while service.log_text().count(answer) == said:
            self.assertIsNone(service.process.poll())
            self.assertLess(time.monotonic(), deadline, service.log_text())
            time.sleep(0.02)

    def positions(self, client, rounds=1.4):
        """By valid frames alone."""
        seen = set()
        deadline = time.monotonic() + rounds * ROUND_S
        while time.monotonic() < deadline:
            registers = client.read()
            if registers[4] & VALID:
                seen.add(position(registers))
            time.sleep(0.005)
        return seen

    def check_moved(self, before, now):
        self.assertGreater(len(now), 5)
        for x, y, z in now:
            self.assertTrue(any(max(abs(x - 1000 * MOVED_MM - a), abs(y - b), abs(z - c)) <= 2 for a, b, c in before), (x, y, z))

    def run_through(self, first, second, options):
        with self.service(first, **options) as service, Client(port=self.port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            before = self.positions(client, rounds=2)
            lost = counters(client.read())
            heartbeat, begin = client.read()[2], time.monotonic()
            self.reload(service, second, "read again")
            client.wait_for(lambda registers: registers[4] & VALID and position(registers) not in before)
            self.check_moved(before, self.positions(client))
            for wrong, line in (("[[landmarks]]\nid = 1\nplace = 3\n[[landmarks]]\nid = 1\n", ":3: unknown key 'place'"),
                                ("[[landmarks]]\nid = 1\n[[landmarks]]\nid = 1\n", ":4: two landmarks have the id 1"),
                                ("", ":1: a map needs [[landmarks]]"),
                                ("[camera]\nrate_hz = 1\n", ":1: 'camera' does not belong here"),
                                ("x = " + 300 * "[", "hall.toml:1: "),
                                (None, "hall.toml: ")):
                self.reload(service, wrong, "map kept: ")
                self.assertIn(line, service.log_text())
            self.check_moved(before, self.positions(client))
            registers = client.read()
            self.assertEqual(counters(registers), lost, "frames are lost")
            expected = RATE_HZ * (time.monotonic() - begin)
            self.assertLess(abs(((registers[2] - heartbeat) & 0xFFFF) - expected), 3 + 0.05 * expected, "and all of them arrive")
            self.assertEqual(service.log_text().count("map kept: "), 6)
            # The same place as at first, and everything else as it was.
            self.reload(service, first, "read again")
            client.wait_for(lambda registers: registers[4] & VALID and position(registers) in before)
            self.assertEqual(service.end(signal.SIGTERM), (0, ""))
            return service.log_text()

    def test_of_several_landmarks(self):
        log = self.run_through(hall(0), hall(MOVED_MM, others=999), {})
        self.assertIn(f"map {self.map} read again: 1000 in all, 998 added, 0 removed, 1 moved, 0 with another", log)
        self.assertIn(f"map {self.map} read again: 2 in all, 0 added, 998 removed, 1 moved, 0 with another", log)

    def test_of_one_landmark(self):
        log = self.run_through(landmark(1, 0), landmark(1, MOVED_MM), {"solver": "full"})
        self.assertEqual(log.count("read again: 1 in all, 0 added, 0 removed, 1 moved"), 2)

    def test_from_one_landmark_to_several_needs_a_restart_and_says_so(self):
        with self.service(landmark(1, 0)) as service, Client(port=self.port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            self.reload(service, hall(0), "map kept: ")
            self.assertIn("restart the service", service.log_text())
            client.wait_for(lambda registers: registers[4] & VALID)

    def test_a_map_full_of_mistakes_is_told_in_few_lines(self):
        with self.service(hall(0)) as service, Client(port=self.port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            service.wait_for_log("found at")
            lines = len(service.log_text().splitlines())
            self.reload(service, 500 * landmark(7), "map kept: ")
            self.assertEqual(len(service.log_text().splitlines()), lines + 22, service.log_text())
            self.assertIn("479 more: see 'ninedot check --config ", service.log_text())

    def test_without_a_map_file_it_says_so_and_goes_on(self):
        with Service(config_text(port=self.port)) as service, Client(port=self.port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            service.process.send_signal(signal.SIGHUP)
            service.wait_for_log("there is no map file")
            client.wait_for(lambda registers: registers[4] & VALID)
            self.assertEqual(service.end(signal.SIGTERM), (0, ""))

    def test_the_end_of_its_terminal_ends_it(self):
        self.map.write_text(landmark(1, 0))
        config = self.map.parent / "config.toml"
        config.write_text(f'map = "{self.map}"\n' + config_text(port=self.port))
        ours, terminal = pty.openpty()

        def take_terminal():
            os.setsid()
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)

        with open(self.map.parent / "stderr", "w+") as log:
            process = subprocess.Popen([BIN / "ninedotd", "--config", config], stdin=terminal, stdout=log, stderr=log,
                                       preexec_fn=take_terminal)
            os.close(terminal)
            try:
                with Client(port=self.port) as client:
                    client.wait_for(lambda registers: registers[4] & VALID)
                process.send_signal(signal.SIGHUP)
                deadline = time.monotonic() + PATIENCE_S
                while "read again" not in pathlib.Path(log.name).read_text():
                    self.assertIsNone(process.poll(), "a SIGHUP of somebody else's")
                    self.assertLess(time.monotonic(), deadline)
                    time.sleep(0.02)
                os.close(ours)
                self.assertEqual(process.wait(PATIENCE_S), 0)
            finally:
                process.kill()
                process.wait()


if __name__ == "__main__":
    unittest.main(verbosity=2)
