"""The parts that judge, without a guest: what is wrong must be called wrong."""

import contextlib
import io
import math
import pathlib
import struct
import sys
import tempfile
import types
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import run
from png_grey import read_png_grey
from registers import DifferenceFromRow, Registers, as_float32, rotation_vector_deg
from vimc_facts import CONTROLS, LINE_US, furthest_from_middle, is_switched_on, sensors_listed

ROW = dict(
    x_mm="711.123456",
    y_mm="-2897.642860",
    z_mm="250.985231",
    qw="0.500000000",
    qx="-0.500000000",
    qy="0.500000000",
    qz="0.500000000",
    sigma_x_mm="1.234567",
    sigma_y_mm="0.001000",
    sigma_z_mm="900.000000",
    ambiguity="0.123456",
    rms_px="0.034567",
    dots="9",
    landmark_id="0",
)


def words_of(row):
    """What the service would publish for a row."""
    words = [0] * 86
    words[0:2] = 0x9D09, 1

    def put(address, packed):
        words[address : address + 2] = struct.unpack(">HH", packed)

    quaternion = [float(row[name]) for name in ("qw", "qx", "qy", "qz")]
    for i, axis in enumerate("xyz"):
        put(40 + 2 * i, struct.pack(">f", float(row[f"{axis}_mm"])))
        put(16 + 2 * i, struct.pack(">i", round(float(row[f"{axis}_mm"]) * 1000)))
        put(22 + 2 * i, struct.pack(">i", round(rotation_vector_deg(*quaternion)[i] * 1000)))
        words[28 + i] = min(max(round(float(row[f"sigma_{axis}_mm"]) * 100), 1), 65535)
    for i, value in enumerate(quaternion):
        put(46 + 2 * i, struct.pack(">f", value))
    words[34], words[35], words[36] = 123, 35, 9
    return words


class Judging(unittest.TestCase):
    def test_the_registers_of_a_row_are_its_own(self):
        self.assertEqual(DifferenceFromRow(Registers(words_of(ROW)), ROW).differences, [])

    def test_one_bit_of_any_judged_register_is_a_difference(self):
        judged = [*range(17, 28, 2), *range(28, 31), 34, 35, 36, *range(41, 54, 2), 6]
        for address in judged:
            words = words_of(ROW)
            words[address] ^= 1
            self.assertTrue(DifferenceFromRow(Registers(words), ROW).differences, f"register {address}")

    def test_two_frames_in_one_reply_are_refused(self):
        words = words_of(ROW)
        words[3] = 1
        with self.assertRaises(ValueError):
            Registers(words)

    def test_a_float_is_rounded_as_the_service_does_it(self):
        self.assertEqual(as_float32(0.1), struct.unpack("f", struct.pack("f", 0.1))[0])
        self.assertAlmostEqual(math.hypot(*rotation_vector_deg(0.5, -0.5, 0.5, 0.5)), 120)


class Pictures(unittest.TestCase):
    def test_every_filter_of_png_is_undone(self):
        width, rows = 7, [bytes((37 * y + 11 * x * x) % 256 for x in range(7)) for y in range(5)]
        packed, above = b"", bytes(width)
        for kind, row in enumerate(rows):
            packed += bytes([kind])
            for x, value in enumerate(row):
                left, corner = (row[x - 1], above[x - 1]) if x else (0, 0)
                up = above[x]
                estimate = left + up - corner
                paeth = min((left, up, corner), key=lambda v: abs(estimate - v))
                packed += bytes([(value - (0, left, up, (left + up) // 2, paeth)[kind]) & 0xFF])
            above = row

        def chunk(name, body):
            return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "picture.png"
            file.write_bytes(
                b"\x89PNG\r\n\x1a\n"
                + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, 0, 0, 0, 0))
                + chunk(b"IDAT", zlib.compress(packed))
                + chunk(b"IEND", b"")
            )
            self.assertEqual(read_png_grey(file), (width, len(rows), b"".join(rows)))


class Stages(unittest.TestCase):
    def test_each_has_some_of_its_checks_in_the_smoke_part(self):
        for name, module in run.STAGES.items():
            self.assertTrue(module.SMOKE_CHECKS, name)
            self.assertLessEqual(set(module.SMOKE_CHECKS), set(module.CHECKS), name)

    def test_a_check_asks_for_as_much_of_its_stage_as_it_needs(self):
        self.assertEqual(run.stages_for(["visca.zoom"], smoke=False), {"visca": True})
        self.assertEqual(run.stages_for(["visca.silent"], smoke=False), {"visca": False})
        self.assertEqual(run.stages_for(["visca.zoom", "visca.silent"], smoke=False), {"visca": False})
        self.assertEqual(run.stages_for(["visca", "servo"], smoke=False), {"visca": False, "servo": False})
        self.assertEqual(run.stages_for(["visca"], smoke=True), {"visca": True})

    def test_stages_and_checks_that_are_not_there_are_refused(self):
        for asked in ("vista", "visca.zoon", "vista.zoom"):
            with self.assertRaises(SystemExit) as refused:
                run.stages_for([asked], smoke=False)
            self.assertIn("zoon" if "zoon" in asked else "vista", str(refused.exception.code))

    def failures_of(self, module, is_asked_for):
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            stage = run.Stage("made-up", module, pathlib.Path(folder), smoke=True, is_asked_for=is_asked_for)
            stage.run()
            return [check for check, *_ in stage.failed]

    def test_one_that_can_not_run_fails_where_it_was_asked_for(self):
        module = types.SimpleNamespace(CHECKS=("a",), SMOKE_CHECKS=("a",), run=lambda stage: stage.leave_out("nothing to run it on"))
        self.assertEqual(self.failures_of(module, is_asked_for=False), [])
        self.assertEqual(self.failures_of(module, is_asked_for=True), ["runs"])

    def test_a_check_that_was_not_made_fails(self):
        module = types.SimpleNamespace(CHECKS=("a", "b", "c"), SMOKE_CHECKS=("a", "b"), run=lambda stage: stage.ok("a", True))
        self.assertEqual(self.failures_of(module, is_asked_for=True), ["b"])


class Sensors(unittest.TestCase):
    def test_one_line_of_exposure_more_is_seen_in_the_stamps(self):
        given = [int(1e9 + 50e6 * i) for i in range(5)]
        right = [end - CONTROLS["exposure"] * LINE_US * 1000 / 2 for end in given]
        self.assertLess(furthest_from_middle(right, given), 1)
        self.assertGreater(furthest_from_middle([stamp - LINE_US * 1000 / 2 for stamp in right], given), 1000)
        self.assertGreater(furthest_from_middle(given, given), 1e6)
        self.assertEqual(furthest_from_middle([], given), math.inf)
        self.assertEqual(furthest_from_middle(right, []), math.inf)

    def test_a_link_that_is_off_is_not_on(self):
        self.assertTrue(is_switched_on('\tpad0: Source\n\t\t-> "Raw Capture 1":0 [ENABLED]\n'))
        self.assertFalse(is_switched_on('\t\t-> "Raw Capture 1":0 []\n\t\t-> "Raw Capture 0":0 [ENABLED]\n'))

    def test_a_sensors_lines_are_its_own(self):
        listed = sensors_listed(
            "sensor:Sensor A  vimc, platform:vimc.0\n  path       a\nsensor:Sensor B  vimc, platform:vimc.0\n  path       b\n  control    c\n"
            "/dev/video4  another\n  format     d\n"
        )
        self.assertEqual(listed, {"sensor:Sensor A": "  path       a\n", "sensor:Sensor B": "  path       b\n  control    c\n"})


if __name__ == "__main__":
    unittest.main()
