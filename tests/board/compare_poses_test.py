"""The comparison of two machines' poses knows each column that `ninedot replay` writes, and calls what differs.

usage: compare_poses_test.py    with NINEDOT_SOURCE_DIR and NINEDOT_BIN_DIR in the environment
"""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["NINEDOT_SOURCE_DIR"])
BINARIES = pathlib.Path(os.environ["NINEDOT_BIN_DIR"])


class ComparePoses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.poses = pathlib.Path(cls.folder.name) / "poses.csv"
        subprocess.run([BINARIES / "ninedot", "replay", SOURCE / "tests/recordings/approach", "--out", cls.poses], check=True, capture_output=True)

    def compared(self, **changed):
        """What the comparison says of the table and one with these values in its third row, or with these columns more"""
        with open(self.poses, newline="", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        if new := changed.keys() - rows[0].keys():
            rows = [row | dict.fromkeys(new, "0") for row in rows]
        before = self.poses.with_name("before.csv")
        after = self.poses.with_name("after.csv")
        for path in (before, after):
            with open(path, "w", newline="", encoding="ascii") as file:
                table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
                table.writeheader()
                table.writerows(rows)
            rows[2] = {name: str(changed[name](value) if name in changed else value) for name, value in rows[2].items()}
        result = subprocess.run([sys.executable, SOURCE / "tests/board/compare_poses.py", before, after], capture_output=True, text=True, check=False)
        return result.returncode, result.stdout + result.stderr

    def test_the_same_table_passes(self):
        self.assertEqual(self.compared()[0], 0)

    def test_the_time_that_it_took_may_differ(self):
        self.assertEqual(self.compared(process_us=lambda _: "1")[0], 0)

    def test_a_difference_far_below_the_noise_passes_and_is_told(self):
        status, said = self.compared(x_mm=lambda value: float(value) + 0.001)
        self.assertEqual(status, 0, said)
        self.assertIn("x_mm", said)

    def test_each_kind_of_difference_is_called(self):
        for name, change in {"x_mm": lambda value: float(value) + 0.1, "qw": lambda value: float(value) + 1e-4, "psi_deg": lambda value: float(value) + 0.01,
                             "sigma_y_mm": lambda value: 1.01 * float(value), "rival_z_mm": lambda value: float(value) - 0.1, "rms_px": lambda _: "nan",
                             "dots": lambda _: "8", "solver": lambda _: "ellipse", "valid": lambda _: "0"}.items():
            status, said = self.compared(**{name: change})
            self.assertEqual(status, 1, f"{name}: {said}")
            self.assertIn(name, said)

    def test_a_column_that_nobody_judges_is_called(self):
        status, said = self.compared(a_new_one=lambda value: value)
        self.assertEqual(status, 1, said)
        self.assertIn("a_new_one", said)

    def test_a_value_that_is_missing_is_called(self):
        status, said = self.compared(x_mm=lambda _: "")
        self.assertEqual(status, 1, said)


if __name__ == "__main__":
    unittest.main()
