"""What the pose registers of ninedotd carry when [outputs] asks for it, against a computation of its own from `ninedot replay`."""

import csv
import math
import os
import pathlib
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import APPROACH, PATIENCE_S, Client, Service, config_text, float32, free_port, int16, int32, replay_rows, run

VALID = 1 << 0
WORLD = "[[landmarks]]\nid = 3\nposition_mm = [4000, -1000, 1200]\nheading_deg = 90\n"
# The camera looks to the left of the robot, 30 degrees down, and stands ahead of its middle.
BODY = ("[body]\npan_axis_mm = [300, -50, 900]\nmount_rpy_deg = [0, 0, 90]\ncamera_mm = [0, 0, 60]\ncamera_rpy_deg = [0, 30, 0]\n"
        "mount_sigma_deg = 2\n")


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(m):
    return [list(column) for column in zip(*m)]


def times(m, v):
    return [sum(m[i][k] * v[k] for k in range(3)) for i in range(3)]


def of_quaternion(w, x, y, z):
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def about_y(deg):
    s, c = math.sin(math.radians(deg)), math.cos(math.radians(deg))
    return [[c, 0, s], [0, 1, 0], [-s, 0, c]]


def about_z(deg):
    s, c = math.sin(math.radians(deg)), math.cos(math.radians(deg))
    return [[c, -s, 0], [s, c, 0], [0, 0, 1]]


OPTICAL = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]  # the camera's right is -y of a body, its down -z, its forward x
BODY_CAMERA = product(product(about_z(90), about_y(30)), OPTICAL)
CAMERA_MM = [300, -50, 960]


def camera_of(row):
    return of_quaternion(*(float(row[name]) for name in ("qw", "qx", "qy", "qz"))), [float(row[name]) for name in ("x_mm", "y_mm", "z_mm")]


def body_of(row):
    """The body in the world, from the camera's row."""
    R, p = camera_of(row)
    R = product(R, transposed(BODY_CAMERA))
    return R, [a - b for a, b in zip(p, times(R, CAMERA_MM))]


def yaw_pitch_roll(R):
    return [math.degrees(a) for a in (math.atan2(R[1][0], R[0][0]), math.asin(-R[2][0]), math.atan2(R[2][1], R[2][2]))]


class PoseRegisters(unittest.TestCase):
    def run_service(self, extra, poses, content, convention, order):
        """Poses: (R, p) of all rows. Order: which of yaw, pitch, roll the angles 1, 2 and 3 are."""
        port = free_port()
        seen = set()
        with Service(config_text(port=port, extra=extra)) as service, Client(port=port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            deadline = time.monotonic() + PATIENCE_S
            while len(seen) < 8:
                self.assertLess(time.monotonic(), deadline, f"only frames {seen}")
                # What one request can't read is of one frame where the sequence numbers say so.
                registers = client.read() + client.read(125, 21)
                if not registers[4] & VALID or registers[145] != registers[3]:
                    continue
                self.assertEqual((registers[125], registers[126]), (content, convention))
                seen.add(self.check(registers, poses, order))
            status = run("ninedot", "status", "--port", str(port))
            self.assertEqual(service.end()[0], 0)
        return status.stdout

    def check(self, registers, poses, order):
        position = [int32(registers, address) / 1000 for address in (16, 18, 20)]
        distances = [max(abs(a - b) for a, b in zip(position, p)) for _, p in poses]
        nearest = min(range(len(poses)), key=distances.__getitem__)
        self.assertLess(distances[nearest], 0.002)
        R, p = poses[nearest]
        told = yaw_pitch_roll(R)
        for i in range(3):
            wanted = told[order[i]]
            self.assertAlmostEqual(int32(registers, 127 + 2 * i) / 1000, wanted, delta=0.0006)
            self.assertAlmostEqual(int16(registers, 136 + i) / 100, wanted, delta=0.0051)
            self.assertAlmostEqual(float32(registers, 139 + 2 * i), wanted, delta=0.0001)
            self.assertAlmostEqual(float32(registers, 40 + 2 * i), p[i], delta=0.002)
            self.assertAlmostEqual(int16(registers, 10 + i) * 0.5, p[i], delta=0.2521)
        quaternion = [float32(registers, address) for address in (46, 48, 50, 52)]
        for row, wanted in zip(of_quaternion(*quaternion), R):
            for a, b in zip(row, wanted):
                self.assertAlmostEqual(a, b, delta=1e-6)
        return nearest

    def world_rows(self, extra, *arguments):
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            config, world = pathlib.Path(folder) / "config.toml", pathlib.Path(folder) / "world.csv"
            config.write_text(config_text(extra=extra))
            rows = replay_rows(APPROACH, "--config", config, "--out-world", world, *arguments)
            with open(world, encoding="utf-8") as file:
                return rows, list(csv.DictReader(file))

    def test_carry_the_robot_in_the_world_with_a_fanuc_s_angles(self):
        extra = WORLD + BODY
        _, world = self.world_rows(extra)
        status = self.run_service(extra + '[outputs]\npose = "body_in_world"\neuler = "fanuc"\n', [body_of(row) for row in world], 2, 1,
                                  (2, 1, 0))
        self.assertIn("body to world", status)
        self.assertRegex(status, r"angles +-?\d+\.\d+ +-?\d+\.\d+ +-?\d+\.\d+ deg \(FANUC W, P, R\)")

    def test_carry_the_camera_in_the_landmark_s_frame(self):
        rows, _ = self.world_rows(WORLD)
        self.run_service(WORLD + '[outputs]\npose = "camera_in_landmark"\n', [camera_of(row) for row in rows], 1, 0, (0, 1, 2))

    def test_carry_the_camera_in_the_world_as_ever_and_tell_a_kuka_s_angles(self):
        _, world = self.world_rows(WORLD)
        self.run_service(WORLD + '[outputs]\neuler = "kuka"\n', [camera_of(row) for row in world], 0, 2, (0, 1, 2))

    def test_replay_adds_the_angles_that_it_is_asked_for(self):
        extra = WORLD + BODY
        _, cameras = self.world_rows(extra)
        self.assertNotIn("yaw_deg", cameras[0])
        for euler, names in (("zyx", ("yaw", "pitch", "roll")), ("fanuc", ("r", "p", "w")), ("kuka", ("a", "b", "c"))):
            _, bodies = self.world_rows(extra, "--frame", "body", "--euler", euler)
            for camera, body in zip(cameras, bodies):
                R, p = body_of(camera)
                for axis, wanted in zip("xyz", p):
                    self.assertAlmostEqual(float(body[f"{axis}_mm"]), wanted, delta=0.001)
                for name, wanted in zip(names, yaw_pitch_roll(R)):
                    self.assertAlmostEqual(float(body[f"{name}_deg"]), wanted, delta=1e-5)
                    self.assertGreater(float(body[f"sigma_{name}_deg"]), 1.9, "the mount is known to 2 degrees about each axis")

    def test_a_robot_without_a_world_is_refused_in_one_line(self):
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            config = pathlib.Path(folder) / "config.toml"
            config.write_text(config_text(extra='[outputs]\npose = "body_in_world"\n'))
            for program in (("ninedot", "check", "--config"), ("ninedotd", "--config")):
                refused = run(*program, config)
                self.assertEqual(refused.returncode, 2)
                self.assertRegex(refused.stderr, r"^[^\n]*config\.toml:\d+: 'pose' is 'body_in_world', and no landmark has a place[^\n]*\n$")


if __name__ == "__main__":
    unittest.main(verbosity=2)
