"""One read of the service's registers (docs/registers.md), and whether it is the pose of a row of `ninedot replay`."""

import math
import pathlib
import re
import struct


def register_count():
    """How many the map has, as the service is built with it"""
    header = pathlib.Path(__file__).resolve().parents[2] / "proto" / "register_map.h"
    return int(re.search(r"kRegisterCount = (\d+);", header.read_text(encoding="utf-8")).group(1))


class Registers:
    def __init__(self, words):
        if (words[0], words[1]) != (0x9D09, 1):
            raise ValueError(f"no register map of ours: {words[:2]}")
        if words[3] != words[39]:
            raise ValueError("two frames mixed in one reply")
        self.words = words

    def word(self, address):
        return self.words[address]

    def uint32(self, address):
        return self.words[address] << 16 | self.words[address + 1]

    def int32(self, address):
        value = self.uint32(address)
        return value - (1 << 32) if value >> 31 else value

    def float32(self, address):
        return struct.unpack(">f", struct.pack(">HH", *self.words[address : address + 2]))[0]

    valid = property(lambda self: bool(self.words[4] & 1))
    # What the frame said, however long ago: an emulated processor's frames come late, and on a busy host some are read when they are too old.
    valid_when_taken = property(lambda self: self.valid or self.reason == REASON_TOO_OLD)
    found = property(lambda self: bool(self.words[4] & 2))
    reason = property(lambda self: self.words[5])
    heartbeat = property(lambda self: self.words[2])
    age_ms = property(lambda self: self.words[8] / 10)
    processed = property(lambda self: self.uint32(61))
    dropped = property(lambda self: self.uint32(63))
    failed = property(lambda self: self.uint32(65))
    restarts = property(lambda self: self.words[67])
    bus_errors = property(lambda self: self.uint32(75))
    head_deg = property(lambda self: [(word - 0x10000 if word & 0x8000 else word) / 100 for word in self.words[37:39]])
    uptime_s = property(lambda self: self.uint32(73))


STATUS_LIMIT, STATUS_INHIBITED, STATUS_FAULT, STATUS_HAS_HEAD = 1 << 5, 1 << 11, 1 << 12, 1 << 13
REASON_NO_FRAME_YET, REASON_NO_LANDMARK, REASON_CAMERA_LOST, REASON_TOO_OLD = 1, 2, 4, 8
REASON_POOR_FIT, REASON_CROWDED = 12, 13
# A replay has rows of landmarks that were found: of none where there is none, nothing that fits one, or too much to search in one picture.
REASONS_WITHOUT_ROW = (REASON_NO_LANDMARK, REASON_POOR_FIT, REASON_CROWDED)


def as_float32(value):
    return struct.unpack(">f", struct.pack(">f", value))[0]


def rotation_vector_deg(w, x, y, z):
    sine = math.sqrt(x * x + y * y + z * z)
    angle = 2 * math.atan2(sine, w)
    return [0.0, 0.0, 0.0] if sine == 0 else [math.degrees(angle) * v / sine for v in (x, y, z)]


def _rounded(value):
    return math.floor(value + 0.5) if value >= 0 else -math.floor(-value + 0.5)


class DifferenceFromRow:
    """Collects where registers differ from what the row's numbers would make of them. The row is rounded to its last digit
    (1e-6, quaternions 1e-9), so a register may be that of any number that rounds to what the row shows, and of no other."""

    def __init__(self, registers, row):
        self.differences = []
        self.registers = registers
        quaternion = [float(row[name]) for name in ("qw", "qx", "qy", "qz")]
        rotation_deg = rotation_vector_deg(*quaternion)
        for i, axis in enumerate("xyz"):
            position_mm = float(row[f"{axis}_mm"])
            self._float(40 + 2 * i, position_mm, 0.5e-6)
            self._integer(registers.int32(16 + 2 * i), f"{axis}_32", position_mm, 0.5e-6, 0.001)
            # Half a step of the last digit of q is 0.5e-9; that of the angle is at most four of them.
            self._integer(registers.int32(22 + 2 * i), f"rotation_{axis}_32", rotation_deg[i], math.degrees(2e-9), 0.001)
            sigma_mm = min(max(float(row[f"sigma_{axis}_mm"]), 0.01), 655.35)
            self._integer(registers.word(28 + i), f"sigma_{axis}", sigma_mm, 0.5e-6, 0.01)
        for i, value in enumerate(quaternion):
            self._float(46 + 2 * i, value, 0.5e-9)
        self._integer(registers.word(34), "ambiguity", float(row["ambiguity"]), 0.5e-6, 0.001)
        self._integer(registers.word(35), "residual", float(row["rms_px"]), 0.5e-6, 0.001)
        self._integer(registers.word(36), "dots_used", float(row["dots"]), 0, 1)
        self._integer(registers.word(6), "landmark_id", float(row["landmark_id"]), 0, 1)

    def _float(self, address, value, slack):
        got = self.registers.float32(address)
        if not as_float32(value - slack) <= got <= as_float32(value + slack):
            self.differences.append(f"register {address}: {got!r}, not {as_float32(value)!r}")

    def _integer(self, got, name, value, slack, step):
        if not _rounded((value - slack) / step - 1e-9) <= got <= _rounded((value + slack) / step + 1e-9):
            self.differences.append(f"{name}: {got}, not {value / step:.3f}")
