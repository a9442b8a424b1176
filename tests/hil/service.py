"""ninedotd in the guest, read from the host through the emulated network."""

import csv
import io
import time

from registers import Registers
from service_harness import Client

PATIENCE_S = 60.0


def csv_rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def replay(guest, recording, *options):
    """Rows of `ninedot replay`, every frame by itself: those that the service publishes."""
    guest.write("/tmp/replay.toml", "[pose]\ntracking = false")
    command = " ".join(("ninedot replay", recording, "--config /tmp/replay.toml --out /tmp/replay.csv", *options))
    text = guest.check(f"{command} > /tmp/replay.log 2>&1 || {{ cat /tmp/replay.log; exit 1; }}; cat /tmp/replay.csv", 180)
    return [row for row in csv_rows(text) if row["valid"] == "1"]


def nearest_row(rows, registers):
    position = [registers.int32(16 + 2 * i) / 1000 for i in range(3)]
    return min(rows, key=lambda row: max(abs(position[i] - float(row[f"{axis}_mm"])) for i, axis in enumerate("xyz")))


def checksums(guest, folder):
    """Number of a frame -> checksum of its picture file. Files that `ninedot record` wrote are equal where their pictures are."""
    lines = guest.check(f"cd {folder}/frames && md5sum *.png", 60).splitlines()
    return {int(name.split(".")[0]): digest for digest, name in (line.split() for line in lines)}


def camera_config(*, pixel_format="GREY", tracking=False, stall_frames=60, rate_hz=59.94, camera="", extra=""):
    """Without tracking a frame's pose depends on that frame alone, so that a live service and a replay agree exactly."""
    return f"""[camera]
source = "v4l2"
device = "/dev/video0"
rate_hz = {rate_hz}
pixel_format = "{pixel_format}"
stall_frames = {stall_frames}
calibration = "/media/scenes/camera.yaml"
{camera}
[pose]
tracking = {str(tracking).lower()}
[modbus.tcp]
listen = "0.0.0.0"
port = 1502
{extra}"""


class GuestService:
    """Context manager: started on entry; on exit it has to be running still, and to end politely."""

    def __init__(self, guest, config):
        self.guest = guest
        self.config = config
        self.exit_status = None

    def __enter__(self):
        self.guest.write("/tmp/ninedotd.toml", self.config)
        self.guest.check(
            """sh -c 'ninedotd --config /tmp/ninedotd.toml; echo $? > /tmp/ninedotd.status' > /tmp/ninedotd.log 2>&1 &
            rm -f /tmp/ninedotd.status"""
        )
        self.client = None
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                # The emulated network accepts a connection before the service listens: what counts is a reply.
                self.client = Client(port=self.guest.modbus_port).__enter__()
                self.read()
                return self
            except Exception as error:
                if self.client:
                    self.client.__exit__()
                if self.ended() or time.monotonic() > deadline:
                    raise AssertionError(f"ninedotd does not answer: {error!r}; its log:\n{self.log()}") from error
                time.sleep(0.1)

    def __exit__(self, *exception):
        if self.client:
            self.client.__exit__()
        self.guest.check(
            """killall -INT ninedotd 2> /dev/null
            for _ in $(seq 100); do [ -s /tmp/ninedotd.status ] && break; sleep 0.1; done"""
        )
        self.exit_status = self.guest.check("cat /tmp/ninedotd.status 2> /dev/null || echo none")
        if not self.exit_status == "0" and exception[0] is None:
            raise AssertionError(f"ninedotd ended with status {self.exit_status}; its log:\n{self.log()}")

    def ended(self):
        return self.guest.run("test -s /tmp/ninedotd.status")[0] == 0

    def log(self):
        return self.guest.check("cat /tmp/ninedotd.log")

    def read(self):
        return Registers(self.client.read(0, 86))

    def wait_for(self, condition, what, within_s=PATIENCE_S):
        """\\return  (registers for which it holds, seconds until then)"""
        started = time.monotonic()
        while True:
            registers = self.read()
            if condition(registers):
                return registers, time.monotonic() - started
            if time.monotonic() - started > within_s:
                raise AssertionError(
                    f"not within {within_s:.0f} s: {what}; valid {registers.valid}, reason {registers.reason}, "
                    f"processed {registers.processed}; log:\n{self.log()}"
                )
            time.sleep(0.01)

    def wait_for_frames(self, count):
        """Registers of a frame that was processed `count` frames after this call at the earliest."""
        first = self.read().processed
        return self.wait_for(lambda registers: registers.processed >= first + count, f"{count} more frames")[0]
