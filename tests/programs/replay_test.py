"""`ninedot replay` from outside: what it writes, and what it leaves behind when it cannot."""

import csv
import io
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import APPROACH, BIN, run


def without_times(text):
    return [{name: value for name, value in row.items() if name != "process_us"}
            for row in csv.DictReader(io.StringIO(text))]


class Replay(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def damaged_recording(self):
        recording = self.folder / "damaged"
        shutil.copytree(APPROACH, recording)
        victim = sorted((recording / "frames").iterdir())[3]
        victim.write_bytes(victim.read_bytes()[:100])
        return recording, victim

    def fails(self, status, *arguments, says):
        result = run("ninedot", "replay", *arguments)
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn(str(says), result.stderr)
        return result

    def test_writes_the_same_rows_twice_and_to_a_file_what_it_prints(self):
        first = run("ninedot", "replay", APPROACH)
        second = run("ninedot", "replay", APPROACH, "--out", self.folder / "poses.csv")
        self.assertEqual((first.returncode, second.returncode), (0, 0), first.stderr + second.stderr)
        self.assertGreater(len(without_times(first.stdout)), 10)
        self.assertEqual(without_times(first.stdout), without_times((self.folder / "poses.csv").read_text()))
        self.assertEqual(second.stdout, "")
        self.assertRegex(second.stderr, r"^22 frames, landmark found in \d+, valid in \d+, median \d+\.\d+ ms per frame\n$")
        self.assertEqual([path.name for path in self.folder.iterdir()], ["poses.csv"])

    def test_tum_rows_carry_seconds_and_metres(self):
        rows = run("ninedot", "replay", APPROACH, "--format", "tum").stdout.splitlines()
        poses = without_times(run("ninedot", "replay", APPROACH).stdout)
        self.assertEqual(len(rows), len(poses))
        for row, pose in zip(rows, poses):
            time_s, x_m = (float(text) for text in row.split()[:2])
            self.assertAlmostEqual(time_s * 1e9, int(pose["timestamp_ns"]), delta=1000)
            self.assertAlmostEqual(x_m * 1000, float(pose["x_mm"]), places=5)

    def in_the_world(self, *arguments):
        """Rows of --out, --out-world and --out-track."""
        names = [self.folder / name for name in ("poses.csv", "world.csv", "track.csv")]
        result = run("ninedot", "replay", APPROACH, *arguments, "--out", names[0], "--out-world", names[1], "--out-track", names[2])
        self.assertEqual(result.returncode, 0, result.stderr)
        return [without_times(name.read_text()) for name in names]

    def test_of_one_landmark_at_the_origin_the_world_is_the_landmark(self):
        poses, world, track = self.in_the_world()
        valid = [row for row in poses if row["valid"] == "1"]
        self.assertGreater(len(valid), 10)
        self.assertEqual([row["frame"] for row in world], [row["frame"] for row in valid])
        for pose, row in zip(valid, world):
            for name in ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "sigma_x_mm", "sigma_rot_deg"):
                self.assertAlmostEqual(float(row[name]), float(pose[name]), places=3)
            self.assertEqual((row["landmarks_used"], row["landmarks_rejected"]), ("1", ""))
        self.assertGreaterEqual(len(track), len(world) - 1)
        self.assertIn("vx_mm_s", track[0])

    def test_the_body_is_where_the_camera_sits_on_it(self):
        config = self.folder / "body.toml"
        config.write_text('[body]\ncamera_mm = [0, 0, 1000]\n')
        _, cameras, _ = self.in_the_world("--config", config)
        _, bodies, tracked = self.in_the_world("--config", config, "--frame", "body")
        for camera, body in zip(cameras, bodies):
            apart_mm = sum((float(camera[name]) - float(body[name])) ** 2 for name in ("x_mm", "y_mm", "z_mm")) ** 0.5
            self.assertAlmostEqual(apart_mm, 1000, places=2)
            self.assertGreater(float(camera["z_mm"]), float(body["z_mm"]) + 900, "the camera stands above it")
        self.assertGreater(len(tracked), 10)

    def test_a_processor_without_avx2_gives_the_same_bytes(self):
        emulator = shutil.which("qemu-x86_64-static") or shutil.which("qemu-x86_64")
        if os.uname().machine != "x86_64" or os.environ.get("NINEDOT_SANITIZED"):
            self.skipTest("there is one code for all processors")
        self.assertIsNotNone(emulator, "qemu-user-static is missing: ./dev packages test")
        emulated = subprocess.run([emulator, "-cpu", "Nehalem", BIN / "ninedot", "replay", APPROACH], capture_output=True, text=True, timeout=120, check=True)
        rows = without_times(emulated.stdout)
        self.assertGreater(len(rows), 10)
        self.assertEqual(rows, without_times(run("ninedot", "replay", APPROACH).stdout))

    def test_in_real_time_no_row_differs_from_its_frame_s_own_time(self):
        times = {row["frame"]: row["timestamp_ns"] for row in without_times(run("ninedot", "replay", APPROACH).stdout)}
        rows = without_times(run("ninedot", "replay", APPROACH, "--realtime").stdout)
        self.assertGreater(len(rows), 0)
        for row in rows:
            self.assertEqual(times.get(row["frame"], row["timestamp_ns"]), row["timestamp_ns"])

    def test_overlay_draws_every_frame(self):
        result = run("ninedot", "replay", APPROACH, "--overlay", self.folder / "overlay", "--out", os.devnull)
        self.assertEqual(result.returncode, 0, result.stderr)
        pictures = sorted(path.name for path in (self.folder / "overlay").iterdir())
        self.assertEqual(len(pictures), 22)
        self.assertTrue((self.folder / "overlay" / pictures[0]).read_bytes().startswith(b"\x89PNG"))

    def test_never_replaces_a_device(self):
        self.assertEqual(run("ninedot", "replay", APPROACH, "--out", os.devnull).returncode, 0)
        self.assertFalse(pathlib.Path(os.devnull).is_file())

    def test_a_damaged_picture_ends_it_and_leaves_nothing_behind(self):
        recording, victim = self.damaged_recording()
        out = self.folder / "poses.csv"
        out.write_text("what was here before\n")
        self.fails(1, recording, "--out", out, says=victim.name)
        self.assertEqual(out.read_text(), "what was here before\n")
        self.assertEqual({path.name for path in self.folder.iterdir()}, {"damaged", "poses.csv"})

    def test_keep_going_leaves_the_damaged_picture_out(self):
        recording, victim = self.damaged_recording()
        result = run("ninedot", "replay", recording, "--keep-going")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(victim.name, result.stderr)
        self.assertIn("1 unreadable", result.stderr)
        self.assertNotIn(str(int(victim.stem)), [row["frame"] for row in without_times(result.stdout)])

    def test_a_disk_that_is_full(self):
        self.fails(1, APPROACH, "--out", "/dev/full", says="No space left")

    def test_a_folder_that_does_not_exist(self):
        self.fails(1, APPROACH, "--out", self.folder / "none" / "poses.csv", says="poses.csv")

    def test_what_is_no_recording(self):
        for name in ("none", "", self.folder):
            self.fails(2, self.folder / name if name else name, says=name or "RECORDING")

    def test_a_recording_without_calibration_and_a_calibration_of_another_size(self):
        recording = self.folder / "bare"
        shutil.copytree(APPROACH, recording)
        camera = (recording / "camera.yaml").read_text()
        (recording / "camera.yaml").unlink()
        self.fails(2, recording, says="--camera")
        (self.folder / "other.yaml").write_text(camera.replace("640", "1280"))
        self.fails(2, recording, "--camera", self.folder / "other.yaml", says="1280")

    def test_wrong_usage(self):
        self.fails(2, says="RECORDING")
        self.fails(2, APPROACH, "--format", "xml", says="xml")


if __name__ == "__main__":
    unittest.main(verbosity=2)
