#!/usr/bin/python3
"""The table of latencies without and with load, from bins as `ninedot tap --latencies` prints them."""

import unittest

from latencies import read_histogram, side_by_side

SAID = """latency of 104 frames since the start (104 processed)
up to   60.89 ms         60  57.69 % ##################################################
up to   72.41 ms          0   0.00 %\x20
up to   86.11 ms         44  42.31 % #####################################
"""
SLOW = "latency of 4 frames since the start (5 processed)\nup to   86.11 ms          3  75.00 % ###\nabove   86.11 ms          1  25.00 % #\n"


class Latencies(unittest.TestCase):
    def test_reads_each_bin_and_both_sums(self):
        self.assertEqual(read_histogram(SAID), (104, 104, {"up to   60.89 ms": 60, "up to   72.41 ms": 0, "up to   86.11 ms": 44}))
        self.assertEqual(read_histogram(SLOW), (4, 5, {"up to   86.11 ms": 3, "above   86.11 ms": 1}))

    def test_takes_nothing_else_for_a_histogram(self):
        self.assertIsNone(read_histogram("ninedot: /run/ninedot-tap/tap: no tap"))

    def test_has_a_line_for_each_bin_of_either(self):
        lines = side_by_side({"idle": read_histogram(SAID)[2], "under load": read_histogram(SLOW)[2]})
        self.assertEqual(
            lines,
            [
                "exposure to report                    idle              under load",
                "up to   60.89 ms              60   57.69 %             0    0.00 %",
                "up to   72.41 ms               0    0.00 %             0    0.00 %",
                "up to   86.11 ms              44   42.31 %             3   75.00 %",
                "above   86.11 ms               0    0.00 %             1   25.00 %",
                "all                          104                       4",
            ],
        )

    def test_sorts_by_size_and_not_by_letters(self):
        edges = [line[:16] for line in side_by_side({"one": {"up to  115.85 ms": 1, "above  115.85 ms": 1}, "two": {"up to   97.42 ms": 1}})[1:-1]]
        self.assertEqual(edges, ["up to   97.42 ms", "up to  115.85 ms", "above  115.85 ms"])

    def test_an_empty_one_is_no_mistake(self):
        self.assertEqual(side_by_side({"idle": {}, "under load": {}})[1:], ["all                            0                       0"])


if __name__ == "__main__":
    unittest.main()
