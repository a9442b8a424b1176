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
from faults_stage import gives_less_than, sequence_wraps, share_given, stamps_cross
from guest import GuestFailed
from png_grey import read_png_grey
from registers import REASON_NO_LANDMARK, REASON_TOO_OLD, DifferenceFromRow, Registers, as_float32, rotation_vector_deg
from tracing import Frame
from vimc_facts import CONTROLS, LINE_US, furthest_from_middle, is_switched_on, lines_of_stamps, sensors_listed

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

    def test_a_pose_that_grew_old_was_valid_when_it_was_taken(self):
        words = words_of(ROW)
        for status, reason, taken in ((1, 0, True), (0, REASON_TOO_OLD, True), (0, REASON_NO_LANDMARK, False)):
            words[4], words[5] = status, reason
            self.assertEqual(Registers(words).valid_when_taken, taken, f"reason {reason}")

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
            return [(check, detail) for check, _, detail in stage.failed]

    def test_one_that_can_not_run_fails_where_it_was_asked_for(self):
        module = types.SimpleNamespace(CHECKS=("a",), SMOKE_CHECKS=("a",), run=lambda stage: stage.leave_out("nothing to run it on"))
        self.assertEqual(self.failures_of(module, is_asked_for=False), [])
        self.assertEqual(self.failures_of(module, is_asked_for=True), [("runs", "nothing to run it on")])

    def test_a_check_that_was_not_made_fails(self):
        module = types.SimpleNamespace(CHECKS=("a", "b", "c"), SMOKE_CHECKS=("a", "b"), run=lambda stage: stage.ok("a", True))
        self.assertEqual(self.failures_of(module, is_asked_for=True), [("b", run.NOT_REACHED)])

    def test_what_does_not_come_in_time_is_the_failure_of_the_check_that_waits(self):
        def waits_in_vain(stage, failure):
            stage.ok("a", True)
            stage.begin("b")
            raise failure

        def with_failure(failure):
            return types.SimpleNamespace(
                CHECKS=("a", "b", "c"), SMOKE_CHECKS=("a", "b", "c"), run=lambda stage: waits_in_vain(stage, failure)
            )

        with contextlib.redirect_stderr(io.StringIO()):
            in_vain = self.failures_of(with_failure(AssertionError("not within 30 s")), is_asked_for=True)
            gone = self.failures_of(with_failure(GuestFailed("the guest is gone")), is_asked_for=True)
        self.assertEqual(in_vain, [("b", "not within 30 s"), ("runs", "not within 30 s"), ("c", run.NOT_REACHED)])
        self.assertEqual(gone, [("runs", "the guest is gone"), ("b", run.NOT_REACHED), ("c", run.NOT_REACHED)])


class Witnesses(unittest.TestCase):
    """A fault that was not there must not pass for one that the service lived through."""

    @staticmethod
    def numbered(*sequences):
        return [Frame(stamp_ns=10**9 * i, sequence=sequence, at_ns=10**9 * i) for i, sequence in enumerate(sequences)]

    @staticmethod
    def stamped(*stamps_ns):
        return [Frame(stamp_ns=int(stamp), sequence=i, at_ns=10**9 * i) for i, stamp in enumerate(stamps_ns)]

    def test_the_share_is_of_what_the_driver_counted(self):
        self.assertEqual(share_given(self.numbered(*range(1000, 1100))), 1)
        self.assertEqual(share_given(self.numbered(5, 8, 11, 14)), 0.4)
        self.assertEqual(share_given(self.numbered(7)), 1)

    def test_as_many_frames_as_before_are_none_dropped(self):
        every_third = self.numbered(*range(0, 100, 3))
        quiet = share_given(every_third)
        self.assertFalse(gives_less_than(quiet)(every_third)[0])
        self.assertFalse(gives_less_than(quiet)(self.numbered(*range(0, 100, 4)))[0])
        self.assertEqual(
            gives_less_than(quiet)(self.numbered(*range(0, 100, 9))), (True, "the driver gives 12 % of its frames away, 34 % before")
        )

    def test_a_count_wraps_from_its_end_to_its_start(self):
        last = (1 << 32) - 1
        self.assertEqual(sequence_wraps(self.numbered(last - 1, last, 0, 1)), (True, f"sequence {last} then 0"))
        self.assertTrue(sequence_wraps(self.numbered(last - 4, 3, 5))[0], "frames that are missing there are no matter")

    def test_without_a_wrap_none_is_seen(self):
        last = (1 << 32) - 1
        for what, sequences in (
            ("a quiet stream", range(200)),
            ("nothing given away", ()),
            ("the end alone", (last - 1, last)),
            ("the start alone", (0, 1)),
            ("started anew", (300, 301, 0, 1)),
            ("started anew just before the wrap", (300, 301, last - 1, last)),
            ("twice: streams that were started anew", (last, 0, last, 0)),
        ):
            self.assertFalse(sequence_wraps(self.numbered(*sequences))[0], what)
        self.assertEqual(sequence_wraps(self.numbered(1, 2)), (False, "no wrap"))

    def test_stamps_cross_a_boundary_on_their_way_up(self):
        at = (1 << 31) * 10**9
        self.assertEqual(stamps_cross(at)(self.stamped(at - 17, at)), (True, f"stamp {at - 17} then {at} ns"))
        # The kernel's numbers have a sign: past 2^63 they are negative.
        self.assertTrue(stamps_cross(1 << 63)(self.stamped((1 << 63) - 10**7, -(1 << 63) + 10**7))[0])

    def test_without_a_crossing_none_is_seen(self):
        for at in ((1 << 31) * 10**9, 1 << 63):
            for what, stamps in (
                ("a quiet stream", (20e9, 20.1e9, 20.2e9)),
                ("nothing given away", ()),
                ("before it alone", (at - 2 * 10**9, at - 10**9)),
                ("behind it alone", (at + 10**9, at + 2 * 10**9)),
                ("the clock set behind it", (20 * 10**9, at + 10**9)),
                ("the clock set back", (at + 10**9, at - 10**9)),
                ("twice", (at - 1, at, at - 1, at)),
            ):
                self.assertFalse(stamps_cross(at)(self.stamped(*stamps))[0], what)
        self.assertEqual(stamps_cross(1 << 63)(self.stamped(1, 2)), (False, "no wrap"))


class Sensors(unittest.TestCase):
    def test_one_line_of_exposure_more_is_seen_in_the_stamps(self):
        given = [int(1e9 + 50e6 * i) for i in range(5)]
        right = [end - CONTROLS["exposure"] * LINE_US * 1000 / 2 for end in given]
        self.assertLess(furthest_from_middle(right, given), 1)
        self.assertGreater(furthest_from_middle([stamp - LINE_US * 1000 / 2 for stamp in right], given), 1000)
        self.assertGreater(furthest_from_middle(given, given), 1e6)
        self.assertEqual(furthest_from_middle([], given), math.inf)
        self.assertEqual(furthest_from_middle(right, []), math.inf)

    def test_a_stamp_says_which_exposure_it_was_reckoned_with(self):
        given = [Frame(int(1e9 + 50e6 * i), i, int(1.001e9 + 50e6 * i)) for i in range(3)]
        stamps = [frame.stamp_ns - lines * LINE_US * 1000 / 2 for frame, lines in zip(given, (654, 653, 100))]
        self.assertEqual(lines_of_stamps(stamps, given), ([654, 653, 100], [frame.at_ns for frame in given]))

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
