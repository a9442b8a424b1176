"""Sensors behind a media graph, on vimc: found by name, links, formats, exposure, gain and rate set through the sensor, and what breaks of it."""

import re
import statistics

from png_grey import parse_png_grey
from registers import REASON_CAMERA_LOST
from service import GuestService, camera_config, csv_rows
from tracing import Trace, frames_of
from vimc_facts import (
    BARS,
    CONTROLS,
    EXPOSURE_US,
    GAIN,
    HEIGHT,
    LINE_US,
    LINES,
    RATE_HZ,
    WIDTH,
    furthest_from_middle,
    is_switched_on,
    lines_of_stamps,
    sensors_listed,
)

SMOKE_CHECKS = ("listed", "check", "obeyed", "pictures")
CHECKS = SMOKE_CHECKS + (
    "as-the-kernel-has-it",
    "rate",
    "stamps",
    "by-node",
    "ambiguous",
    "format-refused",
    "link-refused",
    "busy",
    "link-broken",
    "changed-live",
    "sensor-gone",
    "ends",
)

UNBIND, BIND = "/sys/bus/platform/drivers/vimc/unbind", "/sys/bus/platform/drivers/vimc/bind"
LINK = "'\"Sensor B\":0 -> \"Raw Capture 1\":0 [{}]'"
TAP = "/tmp/tap"
CHANGED_LINES, NOTICED_WITHIN_S = 100, 1.0  # docs/cameras.md says 0.25 s; an emulated processor is late
ASKED = f"exposure_us = {EXPOSURE_US}\ngain = {GAIN}"


class SensorsStage:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        self.trace = Trace(guest)
        guest.check("modprobe vimc; for _ in $(seq 50); do [ -e /dev/media0 ] && break; sleep 0.1; done; [ -e /dev/media0 ]")

    def node(self, name):
        """Numbers change with every binding."""
        return "/dev/" + self.guest.check(f"grep -lx '{name}' /sys/class/video4linux/*/name").split("/")[4]

    def controls(self):
        text = self.guest.check(f"v4l2-ctl -d {self.node('Sensor B')} --get-ctrl {','.join(CONTROLS)}")
        return {name: int(value) for name, value in (line.split(":") for line in text.splitlines())}

    def config(self, device, pixel_format="GREY", camera=ASKED, rate_hz=RATE_HZ, **more):
        text = camera_config(pixel_format=pixel_format, camera=camera, rate_hz=rate_hz, **more)
        return text.replace('"/dev/video0"', f'"{device}"')

    def check(self, device, **keys):
        """`ninedot check`: \\return (exit status, what it said)"""
        self.guest.write("/tmp/check.toml", self.config(device, **keys))
        return self.guest.run("ninedot check --config /tmp/check.toml", 60)

    def record(self, device, frames, **keys):
        self.guest.write("/tmp/record.toml", self.config(device, **keys))
        status, text = self.guest.run(
            f"rm -rf /tmp/out; ninedot record --grey --config /tmp/record.toml --out /tmp/out --frames {frames}", 120
        )
        assert status == 0, text

    def picture(self):
        last = self.guest.check("ls /tmp/out/frames").split()[-1]
        return parse_png_grey(self.guest.fetch(f"/tmp/out/frames/{last}"))[2]

    def foreign_picture(self, node, name):
        """What v4l2-ctl gets of the same node, as it was left."""
        self.guest.check(f"v4l2-ctl -d {node} --stream-mmap 3 --stream-skip 2 --stream-count 1 --stream-to=/tmp/{name}.raw", 60)
        return self.guest.fetch(f"/tmp/{name}.raw")

    def listing(self):
        text = self.guest.check("ninedot cameras")
        entries = sensors_listed(text)
        mono = entries.get("sensor:Sensor B", "")
        wanted = (
            'device = "sensor:Sensor B"',
            f"path       Sensor B -> {self.node('Raw Capture 1')}",
            "camera_id  vimc@platform:",
            "GREY",
            "Exposure: 1 to 1477 step 1, now 642",
            "Analogue Gain: 16 to 255",
            "line time 7.65 us",
        )
        missing = [part for part in wanted if part not in mono]
        self.stage.ok(
            "listed",
            not missing and "sensor:Sensor A" in entries and not re.search(r"^/dev/video", text, re.M),
            f"{len(entries)} sensors with way, formats, controls and camera_id; no node a second time"
            if not missing
            else f"missing {missing} in:\n{text}",
        )

    def obeyed(self):
        before = self.guest.check("media-ctl -p")
        status, text = self.check("sensor:sensor b")
        agreed = next((line for line in text.splitlines() if line.startswith("  agreed")), text)
        parts = ("GREY 640x480, 20 Hz", "exposure 5003.1 us", f"gain {GAIN}", "Sensor B -> ", "line time 7.65 us")
        self.stage.ok("check", status == 0 and all(part in agreed for part in parts), f"`ninedot check` says: {agreed.strip()}")
        after = self.guest.check("media-ctl -p")
        is_on = [is_switched_on(graph) for graph in (before, after)]
        got = self.controls()
        self.stage.ok(
            "obeyed",
            got == CONTROLS and is_on == [False, True],
            f"link on: {is_on[0]}, then {is_on[1]}; the sensor has {got}",
        )

    def as_the_kernel_has_it(self):
        """Sensor A, whose driver is unchanged: a mosaic, and a link that can't be switched."""
        self.guest.check(f"v4l2-ctl -d {self.node('Sensor A')} -c show_information=2")
        self.stage.begin("as-the-kernel-has-it")
        good = []
        for name, code in (("RGGB", "RGGB"), ("GBRG10", "GB10")):
            self.record("sensor:Sensor A", 4, pixel_format=name, camera="", rate_hz=60)
            shown = self.guest.check(f"v4l2-ctl -d {self.node('Raw Capture 0')} --get-fmt-video; media-ctl -p")
            good.append(f"'{code}'" in shown and len(self.guest.check("ls /tmp/out/frames").split()) == 4)
        luma = self.picture()
        bars = [luma[200 * WIDTH + WIDTH * (2 * i + 1) // 16] for i in range(8)]
        self.stage.ok(
            "as-the-kernel-has-it",
            all(good) and all(abs(bar - wanted) <= 1 for bar, wanted in zip(bars, BARS)),
            f"two mosaics recorded through Sensor A; luma of the pattern's bars {bars}",
        )

    def pictures(self):
        self.guest.check(f"v4l2-ctl -d {self.node('Sensor B')} -c show_information=2")
        results = []
        for name, as_luma in (("GREY", bytes), ("Y10", lambda raw: bytes(min(w >> 2, 255) for w in memoryview(raw).cast("H")))):
            self.record("sensor:Sensor B", 3, pixel_format=name, rate_hz=60)
            theirs = as_luma(self.foreign_picture(self.node("Raw Capture 1"), name))
            luma = bytes(self.picture())
            results.append((name, len(theirs) == WIDTH * HEIGHT and luma == theirs, len(set(luma))))
        self.stage.ok(
            "pictures",
            all(equal and levels > 3 for _, equal, levels in results),
            "; ".join(f"{name}: {'pixel for pixel' if equal else 'not'} v4l2-ctl's, {levels} levels" for name, equal, levels in results),
        )

    def stamps(self):
        self.trace.start("v4l2/v4l2_dqbuf")
        self.record("sensor:Sensor B", 20)
        node = int(self.node("Raw Capture 1")[len("/dev/video") :])
        given = [frame.stamp_ns for frame in frames_of(self.trace.stop(), node)]
        stamps = [int(row["timestamp_ns"]) for row in csv_rows(self.guest.check("cat /tmp/out/frames.csv"))]
        off_ns = furthest_from_middle(stamps, given)
        self.stage.ok(
            "stamps",
            len(stamps) == 20 and off_ns <= 1000,
            f"{len(stamps)} frames lie half of the exposure, {LINES * LINE_US / 2:.1f} us, before the driver's stamp, to {off_ns / 1000:.1f} us",
        )
        apart_ms = statistics.median(b - a for a, b in zip(given, given[1:])) / 1e6
        self.record("sensor:Sensor B", 20, rate_hz=5.0)
        slow = [int(row["timestamp_ns"]) for row in csv_rows(self.guest.check("cat /tmp/out/frames.csv"))]
        slow_ms = statistics.median(b - a for a, b in zip(slow, slow[1:])) / 1e6
        # The driver sleeps in steps of 4 ms beside drawing, and an emulated processor draws slowly.
        self.stage.ok(
            "rate",
            50 <= apart_ms <= 80 and 200 <= slow_ms <= 230,
            f"blanking for 20 Hz and 5 Hz: frames {apart_ms:.1f} and {slow_ms:.1f} ms apart in the median",
        )

    def refusals(self):
        node = self.node("Raw Capture 1")
        status, text = self.check(node)
        self.stage.ok("by-node", status == 0 and "exposure 5003.1 us" in text, f"device = \"{node}\": the sensor in front of it is set")
        status, text = self.check("sensor:Sensor")
        self.stage.ok(
            "ambiguous",
            status == 2 and "'sensor:Sensor A', 'sensor:Sensor B'" in text and "\n" not in text.strip(),
            f"status {status}: {text}",
        )
        lines = []
        for device, keys, part in (
            ("sensor:Sensor B", dict(pixel_format="Y12"), "the camera has no Y12 640x480; it offers "),
            # Sensor A feeds a debayer as well, which takes no grey: the kernel starts neither.
            ("sensor:Sensor A", dict(camera=""), "don't fit, or one of its links is off"),
            ("sensor:Sensor A", dict(pixel_format="RGGB"), "remove camera.exposure_us"),
            (self.node("RGB/YUV Capture"), dict(pixel_format="RGGB", camera=""), "'Debayer A' makes "),
        ):
            status, text = self.check(device, **keys)
            lines.append((status == 2 and part in text and "\n" not in text.strip(), text))
        self.stage.ok("format-refused", all(good for good, _ in lines), " | ".join(text for _, text in lines))

    def in_the_way(self):
        device, mono = "sensor:Sensor B", self.node("Raw Capture 1")
        self.guest.check(
            f"v4l2-ctl -d {mono} --stream-mmap 3 > /dev/null 2> /tmp/other.log & echo $! > /tmp/other.pid; "
            "for _ in $(seq 100); do grep -q '<' /tmp/other.log && break; sleep 0.1; done"
        )
        before = self.controls()
        status, text = self.check(device, camera="exposure_us = 1000\ngain = 200", rate_hz=10.0)
        self.stage.ok(
            "busy",
            "busy: stop the program" in text and self.controls() == before,
            f"the sensor is left as it is; status {status}: {text.splitlines()[-1]}",
        )
        self.guest.check("kill $(cat /tmp/other.pid); sleep 0.3")
        # Somebody has Sensor B's pictures through the debayer: the kernel then switches none of its links.
        bayer = "[fmt:SRGGB8_1X8/640x480]"
        self.guest.check(
            f"""media-ctl -l {LINK.format(0)}
            media-ctl -l '"Debayer A":1 -> "Scaler":0 [0], "Sensor B":0 -> "Debayer B":0 [1], "Debayer B":1 -> "Scaler":0 [1]' || exit 1
            media-ctl -V '"Sensor B":0 {bayer}, "Debayer B":0 {bayer}' || exit 1
            v4l2-ctl -d {self.node('RGB/YUV Capture')} -v width=640,height=480,pixelformat=RGB3 --stream-mmap 3 > /dev/null 2> /tmp/other.log & echo $! > /tmp/other.pid
            for _ in $(seq 100); do grep -q '<' /tmp/other.log && exit 0; sleep 0.1; done; cat /tmp/other.log; exit 1"""
        )
        status, text = self.check(device, pixel_format="RGGB")
        self.guest.check("kill $(cat /tmp/other.pid); sleep 0.3")
        self.guest.check(
            """media-ctl -l '"Debayer B":1 -> "Scaler":0 [0], "Sensor B":0 -> "Debayer B":0 [0], "Debayer A":1 -> "Scaler":0 [1]'"""
        )
        self.stage.ok(
            "link-refused",
            "the link from 'Sensor B' to 'Raw Capture 1' can't be switched on" in text,
            f"status {status}: {text.splitlines()[-1]}",
        )

    def changed_live(self):
        """Another program changes the exposure under way: the stamps, which lie half of it before the driver's, follow."""
        self.trace.start("v4l2/v4l2_dqbuf")
        self.guest.check(
            f"""rm -rf /tmp/live; ninedot tap --path {TAP} --record /tmp/live --frames 60 > /tmp/live.log 2>&1 &
            for _ in $(seq 300); do [ $(ls /tmp/live/frames 2> /dev/null | wc -l) -ge 10 ] && break; sleep 0.1; done
            echo changed > /sys/kernel/tracing/trace_marker
            v4l2-ctl -d {self.node('Sensor B')} --set-ctrl exposure={CHANGED_LINES}; wait""",
            120,
        )
        trace = self.trace.stop()
        changed_ns = round(float(re.search(r" (\d+\.\d+): tracing_mark_write: changed", trace)[1]) * 1e9)
        given = frames_of(trace, int(self.node("Raw Capture 1")[len("/dev/video") :]))
        stamps = [int(row["timestamp_ns"]) for row in csv_rows(self.guest.check("cat /tmp/live/frames.csv"))]
        lines, seen_ns = lines_of_stamps(stamps, given)
        before = [at for at, count in zip(seen_ns, lines) if count == LINES]
        late_s = (max(before, default=0) - changed_ns) / 1e9
        self.stage.ok(
            "changed-live",
            set(lines) == {LINES, CHANGED_LINES}
            and lines == sorted(lines, reverse=True)
            and late_s < NOTICED_WITHIN_S
            and self.controls()["exposure"] == CHANGED_LINES,
            f"exposure of {LINES} lines changed to {CHANGED_LINES} under way: {len(before)} of {len(lines)} stamps by the old one, "
            f"the last of them {late_s:.2f} s after the change",
        )

    def service(self):
        service = GuestService(self.guest, self.config("sensor:Sensor B", extra=f'[tap]\nenabled = true\npath = "{TAP}"'))
        self.guest.check(f"media-ctl -l {LINK.format(0)}")
        self.guest.check(f"v4l2-ctl -d {self.node('Sensor B')} -c vertical_blanking=22,exposure=100,analogue_gain=16")
        with service:
            service.wait_for_frames(5)
            got = self.controls()
            graph = self.guest.check("media-ctl -p")
            self.stage.ok(
                "link-broken",
                got == CONTROLS and is_switched_on(graph),
                f"link off and controls changed before the start: on again, {got}",
            )
            self.changed_live()
            before = service.read()
            self.guest.check(f"echo vimc.0 > {UNBIND}", 60)
            _, lost_s = service.wait_for(lambda registers: registers.reason == REASON_CAMERA_LOST, "unbound: camera lost")
            self.guest.check("sleep 3")
            said = service.log()
            self.guest.check(f"echo vimc.0 > {BIND}", 60)
            after, back_s = service.wait_for(
                lambda registers: registers.processed > before.processed + 3 and registers.restarts > before.restarts,
                "bound again: frames",
            )
            service.wait_for_frames(3)
            got = self.controls()
            self.stage.ok(
                "sensor-gone",
                got == CONTROLS and after.restarts == before.restarts + 1 and "No such device" in said,
                f"driver unbound: camera lost after {lost_s:.2f} s; bound again: frames after {back_s:.1f} s, its link switched on "
                f"again, {got}; log: {said.splitlines()[-1]}",
            )
        self.stage.ok("ends", service.exit_status == "0", f"exit status {service.exit_status} on SIGINT")


def run(stage):
    with stage.guest() as guest:
        test = SensorsStage(stage, guest)
        test.listing()
        test.obeyed()
        test.pictures()
        if stage.smoke:
            return
        test.as_the_kernel_has_it()
        test.stamps()
        test.refusals()
        test.in_the_way()
        test.service()
