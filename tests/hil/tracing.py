"""The kernel's own record of what happened, in its order: the witness that a fault was there, and of what a device was told."""

import re
from collections import namedtuple

Frame = namedtuple("Frame", "stamp_ns sequence at_ns")


class Trace:
    def __init__(self, guest):
        self.guest = guest
        guest.check("mkdir -p /sys/kernel/tracing; mount -t tracefs tracefs /sys/kernel/tracing 2> /dev/null; true")
        # By CLOCK_MONOTONIC, as the driver's stamps.
        guest.check("cd /sys/kernel/tracing && echo 4096 > buffer_size_kb && echo mono > trace_clock")

    def start(self, *events):
        self.guest.check(
            "cd /sys/kernel/tracing && echo 0 > events/enable && echo > trace && "
            + " && ".join(f"echo 1 > events/{event}/enable" for event in events)
        )

    def stop(self):
        self.guest.check("cd /sys/kernel/tracing && echo 0 > events/enable && cp trace /tmp/trace", 60)
        return self.guest.fetch("/tmp/trace").decode()


def frames_of(trace, minor=0):
    """Of start("v4l2/v4l2_dqbuf"): the buffers that /dev/videoMINOR gave away, as its driver had stamped and numbered them, and when it gave
    them (to the microsecond)."""
    return [
        Frame(int(stamp), int(sequence), int(seconds) * 1_000_000_000 + int(fraction.ljust(9, "0")))
        for seconds, fraction, stamp, sequence in re.findall(
            rf" (\d+)\.(\d+): v4l2_dqbuf: minor = {minor}, .*timestamp = (-?\d+), .*sequence = (\d+)", trace
        )
    ]
