"""`ninedot simulate`, and ninedotd with a simulated camera on a simulated head."""

import csv
import io
import os
import pathlib
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import SOURCE, Client, Service, free_port, int16, int32, run

BUNDLED = SOURCE / "tests" / "recordings" / "simulated.toml"
VALID = 1 << 0
COLUMNS = ("t_s,x_mm,y_mm,heading_deg,pan_true_deg,tilt_true_deg,pan_command_deg,tilt_command_deg,state,visible,valid,"
           "centre_error_deg")
STANDING = """[simulation]
duration_s = 2
[[simulation.robot]]
t_s = 0
y_mm = 1500
x_mm = 300
heading_deg = -90
[simulation.servo]
pan_start_deg = 5
"""


def write(folder, text):
    path = pathlib.Path(folder) / "scenario.toml"
    path.write_text(text)
    return path


class Simulate(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def rows(self, scenario, *options):
        result = run("ninedot", "simulate", scenario, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return list(csv.DictReader(io.StringIO(result.stdout)))

    def test_the_bundled_scenario_keeps_the_landmark_in_view(self):
        rows = self.rows(BUNDLED)
        self.assertEqual(",".join(rows[0]), COLUMNS)
        self.assertEqual(len(rows), 8 * 35)
        for i, row in enumerate(rows):
            self.assertAlmostEqual(float(row["t_s"]), i / 35, places=6)
        hidden = [row for row in rows if 4.0 <= float(row["t_s"]) < 4.5]
        self.assertTrue(all(row["visible"] == "0" and row["valid"] == "0" for row in hidden))
        # Standing, after a second: within the servo's dead band and a little more.
        standing = [row for row in rows if 0.8 < float(row["t_s"]) < 1.0 or 3.8 < float(row["t_s"]) < 4.0]
        for row in standing:
            self.assertEqual((row["visible"], row["valid"]), ("1", "1"))
            self.assertLess(float(row["centre_error_deg"]), 1.6)

    def test_the_same_seed_gives_the_same_bytes(self):
        for controller in ("servoing", "pid"):
            logs = {}
            for name, seed in (("a", 3), ("b", 3), ("c", 4)):
                path = self.folder / name
                result = run("ninedot", "simulate", BUNDLED, "--out", path, "--seed", str(seed), "--controller", controller)
                self.assertEqual((result.returncode, result.stdout), (0, ""), result.stderr)
                self.assertEqual(len(result.stderr.splitlines()), 1, "no progress in a pipe")
                logs[name] = path.read_bytes()
            self.assertEqual(logs["a"], logs["b"])
            self.assertNotEqual(logs["a"], logs["c"])

    def test_it_is_five_times_as_fast_as_reality(self):
        summary = run("ninedot", "simulate", BUNDLED).stderr
        ratio = float(summary.split(" times as fast")[0].split()[-1])
        self.assertGreater(ratio, 5, summary)

    def test_truth_is_that_of_the_geometry(self):
        # 300 mm beside the landmark, 1500 before it, looking at the wall: it lies to the right, where x is smaller.
        rows = self.rows(write(self.folder, STANDING), "--controller", "pid")
        self.assertAlmostEqual(float(rows[0]["centre_error_deg"]), 11.3099 + 5, places=3)
        last = rows[-1]
        self.assertLess(float(last["centre_error_deg"]), 1)
        self.assertAlmostEqual(float(last["pan_true_deg"]), -11.31, delta=1)
        self.assertEqual((float(last["x_mm"]), float(last["y_mm"]), float(last["heading_deg"])), (300, 1500, -90))

    def test_landmarks_of_a_map_are_known_by_their_colours(self):
        text = STANDING + ('[[landmarks]]\nid = 7\ncode = "KRGBKKRB"\nposition_mm = [0, 0, 0]\n'
                           '[[landmarks]]\nid = 8\ncode = "KKKRRGBG"\nposition_mm = [-700, 0, 0]\n')
        rows = self.rows(write(self.folder, text.replace("x_mm = 300", "x_mm = 500")))
        self.assertGreater(sum(row["valid"] == "1" for row in rows), 66)

    def test_a_mistake_is_one_line_with_its_line_and_leaves_nothing(self):
        for text, words in ((STANDING + "speed = 3", ":10: unknown key 'speed' in [simulation.servo]; did you mean 'speed_deg_s'?"),
                            (STANDING.replace("duration_s = 2", "duration_s = 0"), ":2: 'duration_s' is 0; write 0.1 to 86400 s"),
                            (STANDING.replace("t_s = 0", "t_s = 0\nt_s = 0"), ":5: "),
                            (STANDING.replace("= 5", "= 50"), ":9: 'pan_start_deg' is 50; write -45 to 45"),
                            (STANDING + "[[simulation.hidden]]\nfrom_s = 1", ":10: a hidden interval needs a 'to_s'"),
                            ("[simulation]\nduration_s = 2", ":1: a scenario needs [[simulation.robot]]"),
                            ("[camera]\nrate_hz = 30\n", ":1: a scenario needs [[simulation.robot]]"),
                            (STANDING + '[camera]\ncalibration = "none.yaml"', "none.yaml: no such calibration"),
                            (STANDING + '[[landmarks]]\nid = 1\ncode = "KRGBKKRB"\n[[landmarks]]\nid = 2\ncode = "KKKRRGBG"\n',
                             "no landmark has a place: write position_mm")):
            out = self.folder / "log.csv"
            result = run("ninedot", "simulate", write(self.folder, text), "--out", out)
            self.assertEqual(result.returncode, 2, text)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn(words, result.stderr)
            self.assertFalse(out.exists())

    def test_a_scenario_or_a_folder_that_is_not_there(self):
        self.assertEqual(run("ninedot", "simulate", self.folder / "none.toml").returncode, 2)
        result = run("ninedot", "simulate", BUNDLED, "--out", self.folder / "none" / "log.csv")
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (1, 1), result.stderr)
        for words in (("--controller", "mpc"), ("--seed", "-1"), ("--seed", "x")):
            result = run("ninedot", "simulate", BUNDLED, *words)
            self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
            self.assertIn(words[0], result.stderr)
            self.assertIn("see 'ninedot simulate --help'", result.stderr)


class SimulatedService(unittest.TestCase):
    """The whole service, in real time."""

    def config(self, port):
        return BUNDLED.read_text().replace("port = 1502", f"port = {port}")

    def test_the_head_follows_a_simulated_landmark(self):
        port = free_port()
        with Service(self.config(port)) as service, Client(port=port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            # The robot comes from the left end of its way, and the head, which stood elsewhere, turns to the landmark.
            left = client.wait_for(lambda registers: registers[4] & VALID and int16(registers, 37) > 2500)
            right = client.wait_for(lambda registers: registers[4] & VALID and int16(registers, 37) < -2500)
            self.assertLess(int32(left, 16), -400_000, "x of the camera in 0.001 mm")
            self.assertGreater(int32(right, 16), 400_000)
            for registers in (left, right):
                self.assertAlmostEqual(int32(registers, 18) / 1e6, 1.5, delta=0.05)
                self.assertGreaterEqual(registers[9], 200, "the camera's delay, 20 ms, is part of the latency")
            time.sleep(1.2)
            rate_hz = client.read()[60] / 10
            self.assertGreater(rate_hz, 25)
            self.assertEqual(service.end()[0], 0)
            self.assertIn("camera: simulated, 8.0 s of a robot's way, over and over", service.log_text())

    def test_a_head_goes_where_it_is_sent_as_its_servos_allow(self):
        port = free_port()
        slow = self.config(port).replace("speed_deg_s = 353.0", "speed_deg_s = 20.0").replace(
            'driver = "simulated"', 'driver = "simulated"\nfollow = false')
        with Service(slow) as service, Client(port=port) as client:
            client.wait_for(lambda registers: registers[4] & VALID or registers[2] > 10)
            before = client.read()
            client.write(105, [(-3000) & 0xFFFF, 0])
            client.write(100, [2, 9])
            # Open loop: it says where it was told to stand, and is not there yet; the picture shows it.
            client.wait_for(lambda registers: int16(registers, 37) == -3000)
            self.assertNotEqual(int16(before, 37), -3000)
            self.assertEqual(service.end()[0], 0)

    def test_check_knows_a_simulated_camera(self):
        result = run("ninedot", "check", "--config", BUNDLED)
        self.assertIn(result.returncode, (0, 2))
        self.assertNotIn("camera", result.stderr)

    def test_a_simulated_camera_can_be_recorded(self):
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            result = run("ninedot", "record", "--config", BUNDLED, "--out", folder, "--frames", "5")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(len(list((pathlib.Path(folder) / "frames").iterdir())), 5)
            self.assertTrue((pathlib.Path(folder) / "camera.yaml").exists())


if __name__ == "__main__":
    unittest.main()
