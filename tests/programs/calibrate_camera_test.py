#!/usr/bin/python3
"""`ninedot calibrate camera` at a camera that runs: what a terminal shows, what a pipe gets, and what Ctrl-C leaves."""
import os
import pathlib
import pty
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import BIN, PATIENCE_S, SANITIZED

# The landmark is at the world's origin and looks along Y. A robot stands before it, drives on, and stands again. A sanitized
# program renders some ten times slower, and time does not wait for it: a quarter of the pixels.
SCENARIO = f"""
[camera]
source = "simulated"
{"width_px = 320" if SANITIZED else ""}
{"height_px = 240" if SANITIZED else ""}
[simulation]
duration_s = 60
""" + "".join(f"""
[[simulation.robot]]
t_s = {t}
x_mm = {x}
y_mm = 700
z_mm = 0
heading_deg = -90
""" for t, x in ((0.0, 0), (1.0, 0), (2.0, 100), (60.0, 100)))


class Calibration:
    """The command, at work in a folder of its own."""

    def __init__(self, scenario, stderr, **options):
        self.folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.path = pathlib.Path(self.folder.name)
        (self.path / "config.toml").write_text(scenario)
        self.process = subprocess.Popen([BIN / "ninedot", "calibrate", "camera", "--config", "config.toml", "--out",
                                         "camera.yaml"], cwd=self.path, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=stderr, **options)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()
        self.folder.cleanup()

    def names(self):
        return sorted(path.name for path in self.path.iterdir())


def read_until(descriptor, pattern, text=""):
    """What is written until it has `pattern`, or until the other end is closed where that is None."""
    deadline = time.monotonic() + PATIENCE_S
    while (pattern is None or not re.search(pattern, text)) and time.monotonic() < deadline:
        if select.select([descriptor], [], [], 1)[0]:
            try:
                more = os.read(descriptor, 65536)
            except OSError:  # a terminal whose other end is closed
                break
            if not more:
                break
            text += more.decode(errors="replace")
    return text


class CalibrateCamera(unittest.TestCase):
    def test_a_terminal_shows_what_is_wanted_and_ctrl_c_loses_nothing(self):
        master, terminal = pty.openpty()
        with Calibration(SCENARIO, terminal) as calibration:
            os.close(terminal)
            text = read_until(master, r"2 views; wanted")
            calibration.process.send_signal(signal.SIGINT)
            text = read_until(master, None, text)
            self.assertEqual(calibration.process.wait(PATIENCE_S), 1)
            os.close(master)
            self.assertEqual(calibration.names(), ["camera-views", "config.toml"])
            self.assertEqual(len(list((calibration.path / "camera-views" / "frames").iterdir())), 2)
            again = subprocess.run([BIN / "ninedot", "calibrate", "camera", "camera-views", "--out", "camera.yaml"],
                                   cwd=calibration.path, capture_output=True, text=True, check=False)
            self.assertIn("two views are too few", again.stderr)
        self.assertRegex(text, "\x1b\\[\\d+A\r")  # in place
        for wanted in ("1 view; wanted: upper left", "hold still", "have that: move on, to upper left",
                       "tilted to the right", "nearer", "Ctrl-C ends"):
            self.assertIn(wanted, text)
        self.assertRegex(text, r"\[ +[12] \]", "where the sheet is now")
        # What stays on the terminal: the table is gone, one line tells the outcome.
        last = text.rsplit("\x1b[J", 1)[1]
        self.assertRegex(last, r"ninedot: stopped too early: two views are too few.*kept in camera-views\r\n$")
        self.assertEqual(last.count("\n"), 1)

    def test_a_pipe_gets_one_line_for_each_view(self):
        with Calibration(SCENARIO, subprocess.PIPE) as calibration:
            stderr = calibration.process.stderr.fileno()
            text = read_until(stderr, r"\n2 views")
            calibration.process.send_signal(signal.SIGINT)
            text = read_until(stderr, None, text)
            self.assertEqual(calibration.process.wait(PATIENCE_S), 1)
        self.assertNotIn("\x1b", text)
        lines = text.splitlines()
        self.assertEqual([line.split(";")[0] for line in lines[:3]], ["0 views", "1 view", "2 views"])
        self.assertEqual(len(lines), 4, text)
        self.assertTrue(lines[3].startswith("ninedot: stopped too early: "), text)

    def test_a_source_that_ends_is_used_as_far_as_it_goes(self):
        with Calibration(SCENARIO.replace("duration_s = 60", "duration_s = 1"), subprocess.PIPE) as calibration:
            text = calibration.process.communicate(timeout=PATIENCE_S)[1].decode()
            self.assertEqual(calibration.process.returncode, 1)
        self.assertIn("pictures show the sheet in one place", text)

    def test_the_next_attempt_keeps_its_views_beside_those_of_the_first(self):
        with Calibration(SCENARIO, subprocess.PIPE) as calibration:
            (calibration.path / "camera-views").mkdir()
            read_until(calibration.process.stderr.fileno(), r"\n1 view")
            calibration.process.send_signal(signal.SIGINT)
            calibration.process.communicate(timeout=PATIENCE_S)
            self.assertIn("camera-views-2", calibration.names())


if __name__ == "__main__":
    unittest.main()
