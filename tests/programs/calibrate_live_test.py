"""`ninedot calibrate pan-tilt` live: a simulated camera on a simulated head of which the configuration says nothing right."""

import json
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
from service_harness import BIN, PATIENCE_S, Client, Service, free_port, run

# Register of the head's state, and its values: a head that follows by wrong numbers need not come near the landmark.
HEAD_STATE, FOLLOWS, HOLD = 146, (1, 2, 3, 4), 5

# The fewest stops at the highest rate, so that it takes a quarter of a minute.
SCENARIO = """[camera]
source = "simulated"
width_px = 320
height_px = 240
rate_hz = 60
[body]
tilt_axis_mm = [0, 0, 40]
[pan_tilt]
driver = "simulated"
[pan_tilt.pan]
min_deg = -16
max_deg = 16
slew_deg_per_s = 200
[pan_tilt.tilt]
min_deg = -14
max_deg = 14
slew_deg_per_s = 200
[simulation]
duration_s = 1000
[[simulation.robot]]
t_s = 0
y_mm = 1100
heading_deg = -90
[simulation.head]
camera_mm = [30, -8, 20]
camera_rpy_deg = [1.0, -2.0, 1.5]
pan_calibration = [[-63.6, 2100], [63.6, 900]]
tilt_calibration = [[-54, 900], [54, 2100]]
[simulation.servo]
backlash_deg = 0.4
delay_ms = 20
"""


class CalibrateLive(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.out = self.folder / "head.toml"

    def command(self, scenario, *options):
        path = self.folder / "scenario.toml"
        path.write_text(scenario)
        return ("calibrate", "pan-tilt", "--config", path, "--out", self.out, *options)

    def refusal(self, scenario, *options):
        """What it says last; nothing is written."""
        result = run("ninedot", *self.command(scenario, *options))
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertFalse(self.out.exists())
        self.assertNotIn("\r", result.stderr, "no progress in a pipe")
        return result.stderr.splitlines()[-1]

    def test_it_finds_the_head_and_what_it_writes_is_taken(self):
        result = run("ninedot", *self.command(SCENARIO, "--stops", "4x3"))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("the head will move, within pan -16 to 16 deg, tilt -14 to 14 deg", result.stderr.splitlines()[0])
        text = self.out.read_text()
        camera = [float(number) for number in re.search(r"camera_mm = \[(.*?)\]", text)[1].split(",")]
        for found, true in zip(camera, (30, -8, 20)):
            self.assertAlmostEqual(found, true, delta=6, msg=text)
        play = float(re.search(r"pan_sigma_deg.*play ([\d.]+)", text)[1])
        self.assertAlmostEqual(play, 0.4, delta=0.1, msg=text)
        # In the place of the same keys the service takes it.
        merged = SCENARIO.replace("[body]\ntilt_axis_mm = [0, 0, 40]\n", "")
        for axis in ("pan", "tilt"):
            table = re.search(rf"\[pan_tilt\.{axis}\].*?\n(calibration = .*?\n\])", text, re.S)[1]
            merged = merged.replace(f"[pan_tilt.{axis}]\n", f"[pan_tilt.{axis}]\n{table}\n")
        merged += re.search(r"\[body\].*?\n\n", text, re.S)[0]
        path = self.folder / "merged.toml"
        path.write_text(merged)
        self.assertEqual(run("ninedot", "check", "--config", path).returncode, 0, run("ninedot", "check", "--config", path).stderr)
        # With these numbers directions are foretold to the play alone.
        again = run("ninedot", *self.command(merged, "--stops", "4x3"))
        self.assertEqual(again.returncode, 0, again.stderr)
        before = float(re.search(r"left out; to ([\d.]+) deg before", again.stderr)[1])
        self.assertLess(before, 0.5)

    def test_ctrl_c_stops_it_at_once_and_says_what_is_missing(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([BIN / "ninedot", *self.command(SCENARIO)], stderr=subprocess.PIPE, text=True)
            self.assertIn("the head will move", process.stderr.readline())
            time.sleep(2)
            process.send_signal(number)
            began = time.monotonic()
            _, said = process.communicate(timeout=PATIENCE_S)
            self.assertLess(time.monotonic() - began, 10)
            self.assertEqual(process.returncode, 1, said)
            self.assertIn("interrupted, the head stands", said)
            self.assertIn("stops with a landmark in sight", said.splitlines()[-1])
            self.assertFalse(self.out.exists())

    def test_a_terminal_shows_how_far_it_is_and_ctrl_c_near_the_end_uses_what_there_is(self):
        ours, theirs = pty.openpty()
        process = subprocess.Popen([BIN / "ninedot", *self.command(SCENARIO, "--stops", "4x3")], stderr=theirs)
        os.close(theirs)
        said, deadline, seen = "", time.monotonic() + PATIENCE_S, (0, 99)
        while seen[0] < seen[1] - 3 and time.monotonic() < deadline:
            if select.select([ours], [], [], 1)[0]:
                said += os.read(ours, 4096).decode()
                seen = max((tuple(map(int, pair)) for pair in re.findall(r"stop (\d+) of (\d+)", said)), default=seen)
        self.assertIn("looking for a landmark: stop 1, pan", said)
        self.assertIn("landmark in sight; Ctrl-C stops the head", said)
        process.send_signal(signal.SIGINT)
        while select.select([ours], [], [], 10)[0]:
            try:
                said += os.read(ours, 4096).decode()
            except OSError:  # the other end is closed
                break
        self.assertEqual(process.wait(PATIENCE_S), 0, said)
        os.close(ours)
        self.assertIn("interrupted, the head stands: what follows is of the stops until then", said)
        self.assertIn("[pan_tilt.pan]", self.out.read_text())

    def test_no_landmark_is_one_line(self):
        away = SCENARIO.replace("heading_deg = -90", "heading_deg = 90")
        self.assertIn("no landmark in sight at any of", self.refusal(away))

    def test_a_camera_that_ends_is_one_line(self):
        short = SCENARIO.replace("duration_s = 1000", "duration_s = 2").replace("[camera]\n", "[camera]\nloop = false\n")
        self.assertIn("the camera's pictures are over before the tour is", self.refusal(short))

    def test_a_running_service_is_asked_to_be_stopped(self):
        port = free_port()
        served = SCENARIO + f'[modbus.tcp]\nlisten = "127.0.0.1"\nport = {port}\n'
        with Service(served) as service:
            service.wait_for_log("read the position")
            self.assertIn(f"port {port} is a running ninedotd's", self.refusal(served))

    def served(self, more="[modbus]\nallow_writes = true\n"):
        """The scenario with what `--tap` needs, and its port."""
        port = free_port()
        return SCENARIO + f'{more}[tap]\nenabled = true\npath = "{self.folder}/tap"\n[modbus.tcp]\nlisten = "127.0.0.1"\nport = {port}\n', port

    @staticmethod
    def head_state(client):
        return client.read(HEAD_STATE, 1)[0]

    def wait_until_it_follows(self, client):
        client.wait_for(lambda registers: self.head_state(client) in FOLLOWS)

    def begin(self, served, *options):
        """A tour through the service that has come as far as its stops."""
        process = subprocess.Popen([BIN / "ninedot", *self.command(served, "--tap", "--stops", "4x3", "--progress", "json", *options)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in process.stdout:
            if json.loads(line).get("part") == "stops":
                return process
        self.fail(process.stderr.read())

    def test_through_a_running_service_it_goes_on_and_the_head_follows_again(self):
        served, port = self.served()
        with Service(served) as service, Client(port=port) as client:
            self.wait_until_it_follows(client)
            result = run("ninedot", *self.command(served, "--tap", "--stops", "4x3", "--progress", "json"))
            self.assertEqual(result.returncode, 0, result.stderr)
            news = [json.loads(line) for line in result.stdout.splitlines()]
            self.assertEqual([*dict.fromkeys(line.get("part") for line in news)], ["find", "reach", "stops", "home", None])
            self.assertEqual(news[-1]["state"], "done")
            self.assertLess(news[-1]["foretold_deg"], 0.5)
            self.assertGreater(news[-1]["before_deg"], 2)
            self.assertGreaterEqual(news[-1]["stops"], 15)
            self.assertTrue(all(-16.01 < line["pan_deg"] < 16.01 and -14.01 < line["tilt_deg"] < 14.01 for line in news if line["state"] == "moving"))
            camera = [float(number) for number in re.search(r"camera_mm = \[(.*?)\]", self.out.read_text())[1].split(",")]
            for found, true in zip(camera, (30, -8, 20)):
                self.assertAlmostEqual(found, true, delta=6, msg=self.out.read_text())
            self.wait_until_it_follows(client)
            self.assertEqual(service.end()[0], 0)

    def test_however_it_ends_the_head_follows_again(self):
        served, port = self.served()
        with Service(served) as service, Client(port=port) as client:
            self.wait_until_it_follows(client)
            for number in (signal.SIGINT, signal.SIGKILL, None):
                process = self.begin(served)
                self.assertEqual(self.head_state(client), HOLD)
                process.stdout.close() if number is None else process.send_signal(number)  # None: nobody listens any more
                began = time.monotonic()
                self.wait_until_it_follows(client)
                self.assertLess(time.monotonic() - began, 3)
                process.wait(PATIENCE_S)
                process.stderr.close()
                process.stdout.close()

    def test_who_sends_the_head_elsewhere_meanwhile_keeps_it(self):
        served, port = self.served()
        with Service(served) as service, Client(port=port) as client:
            self.wait_until_it_follows(client)
            process = self.begin(served)
            self.assertEqual(run("ninedot", "aim", "--pan-deg", "5", "--port", str(port)).returncode, 0)
            news, said = process.communicate(timeout=PATIENCE_S)
            self.assertEqual(process.returncode, 1, said)
            self.assertIn("another client has sent the head elsewhere", said.splitlines()[-1])
            self.assertEqual(json.loads(news.splitlines()[-1])["state"], "failed")
            time.sleep(1)
            self.assertEqual((self.head_state(client), client.read(37, 1)[0]), (HOLD, 500))
            # And nobody takes it from whoever has it.
            self.assertIn("a controller has sent the head where it is", self.refusal(served, "--tap"))
            self.assertEqual((self.head_state(client), client.read(37, 1)[0]), (HOLD, 500))

    def test_a_service_that_takes_no_commands_or_has_no_tap_is_one_line(self):
        served, port = self.served(more="")
        with Service(served) as service:
            service.wait_for_log("read the position")
            self.assertIn("set modbus.allow_writes = true", self.refusal(served, "--tap"))
            self.assertIn("write `enabled = true` under [tap]", self.refusal(SCENARIO, "--tap"))
        self.assertIn(f"{self.folder}/tap", self.refusal(served, "--tap"))

    def test_a_head_that_does_not_answer_is_one_line(self):
        absent = SCENARIO.replace('driver = "simulated"', 'driver = "visca"\ndevice = "/dev/none"')
        self.assertIn("/dev/none", self.refusal(absent))


if __name__ == "__main__":
    unittest.main()
