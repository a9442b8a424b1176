"""Recorded frames into vivid's output node, out of its capture node, through ninedotd: the poses are those of the replay."""

import re
import time

from media import PIXEL_FORMATS, SCENE_OF_FORMATS
from mosaic import BAYER_FORMATS, camera_keys, expected_luma, furthest_off, samples_of
from png_grey import parse_png_grey, read_png_grey
from registers import REASONS_WITHOUT_ROW, DifferenceFromRow
from service import PATIENCE_S, GuestService, camera_config, checksums, csv_rows, nearest_row, replay
from tracing import Trace, frames_of
from vivid import Vivid

SMOKE_CHECKS = (
    "cameras",
    "check",
    "pictures",
    "formats",
    "mosaics",
    "replay-of-capture",
    "stills",
    "free-running",
    "stamps",
    "ends",
)
CHECKS = SMOKE_CHECKS + ("calibrate-live", "calibrate-busy")

FRAMES_IN_FLIGHT = 6  # more than the driver's buffers: a frame processed so much later is of the new picture
RECORDED = 60
CLOCKS_DIFFER_NS = 20_000  # the trace is read to the microsecond, a little before or after the product reads its clock
ARRIVES_NS = 10_000_000  # from the driver giving a buffer away until the product reads its clock, on an emulated processor
FREE_RUNNING_S = 8.0  # at least
JUDGED = 6  # of the pictures of each format
SMOKE_FORMATS = ("YUYV", "NV12")
SMOKE_MOSAICS = ("BGGR10",)
MOSAIC_ROWS = (0, 1, 2, 121, 240, 333, 478, 479)  # both kinds of row, and the borders
ROUNDING = 1.0  # [LSB]: to whole numbers, twice
SMOKE_STEP = 4  # of the stills
LENS_STEP = 3  # of the stills: places far enough apart to be different views
STANDS_STILL_S = 2.0  # some pictures in a row, on an emulated processor
ROW_OF_ITS_OWN = ("frame", "timestamp_ns", "process_us")


def same_pose(row, other):
    return all(row[name] == other[name] for name in row if name not in ROW_OF_ITS_OWN)


def record(guest, out, frames, pixel_format, camera=""):
    guest.write("/tmp/record.toml", camera_config(pixel_format=pixel_format, camera=camera))
    return guest.check(f"rm -rf {out}; ninedot record --grey --config /tmp/record.toml --out {out} --frames {frames}", 120)


class CameraStage:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        self.vivid = Vivid(guest)
        self.trace = Trace(guest)
        # All of the scenes once more through our own encoder, to compare with what is captured.
        guest.write("/tmp/scenes.toml", '[camera]\nsource = "recording"\ndevice = "/media/scenes"\nloop = false')
        guest.check("ninedot record --grey --config /tmp/scenes.toml --out /tmp/scenes", 120)
        self.sums = checksums(guest, "/tmp/scenes")
        self.scene_of = {digest: number for number, digest in self.sums.items()}
        self.rows = {int(row["frame"]): row for row in replay(guest, "/media/scenes")}
        guest.check("cat /media/stills/*.raw > /tmp/scenes.raw")

    def listing(self):
        text = self.guest.check("ninedot cameras")
        self.stage.ok(
            "cameras",
            "/dev/video0" in text and "GREY" in text and "/dev/video1" not in text,
            "`ninedot cameras` lists the capture node and its formats",
        )
        self.guest.write("/tmp/check.toml", camera_config())
        status, text = self.guest.run("ninedot check --config /tmp/check.toml")
        self.stage.ok("check", status == 0, "`ninedot check` opens the camera" if status == 0 else text)

    def pictures(self):
        self.vivid.play("/tmp/scenes.raw")
        self.trace.start("v4l2/v4l2_dqbuf")
        said = record(self.guest, "/tmp/captured", RECORDED, "GREY")
        self.given = frames_of(self.trace.stop())
        captured = checksums(self.guest, "/tmp/captured")
        scenes = [self.scene_of.get(digest) for _, digest in sorted(captured.items())]
        foreign = scenes.count(None)
        self.stage.ok(
            "pictures",
            len(scenes) == RECORDED and foreign == 0,
            f"{len(scenes)} pictures captured, {len(set(scenes))} of {len(self.sums)} scenes, "
            f"{foreign} not equal to what was played ({said})",
        )
        rows = replay(self.guest, "/tmp/captured", "--camera /media/scenes/camera.yaml")
        by_number = dict(zip(sorted(captured), scenes))
        wrong = [row["frame"] for row in rows if not same_pose(row, self.rows[by_number[int(row["frame"])]])]
        expected = sum(scene in self.rows for scene in scenes)
        self.stage.ok(
            "replay-of-capture",
            not wrong and len(rows) == expected,
            f"{len(rows)} rows of the captured pictures, {len(wrong)} differ from those of the originals",
        )

    def formats(self):
        table, good = [], True
        names = SMOKE_FORMATS if self.stage.smoke else PIXEL_FORMATS
        for name in names:
            self.vivid.stop()
            self.vivid.set_up(name)
            self.vivid.play(f"/media/formats/{name}.raw")
            # The first pictures may still be those of the queue.
            record(self.guest, "/tmp/format", 2 * JUDGED, name)
            scenes = [self.scene_of.get(digest) for _, digest in sorted(checksums(self.guest, "/tmp/format").items())]
            equal = scenes[JUDGED:] == [SCENE_OF_FORMATS] * JUDGED
            good &= equal
            table.append((name, "equal, pixel for pixel" if equal else f"differ: {scenes}"))
        self.stage.table("Pixel formats", ("format", "captured luma and the picture played"), table)
        self.stage.ok("formats", good, f"{sum('equal' in result for _, result in table)} of {len(table)}: {' '.join(names)}")
        self.vivid.stop()
        self.vivid.set_up()

    def mosaics(self):
        """A colour sensor's own numbers: the luma is the one that docs/cameras.md promises."""
        width, height, scene = read_png_grey(self.stage.out / "media" / "scenes" / "frames" / f"{SCENE_OF_FORMATS:06}.png")
        table, good = [], True
        names = SMOKE_MOSAICS if self.stage.smoke else tuple(BAYER_FORMATS)
        for name in names:
            self.vivid.stop()
            self.vivid.set_up(BAYER_FORMATS[name][0])
            self.vivid.play(f"/media/formats/{name}.raw")
            record(self.guest, "/tmp/mosaic", 2 * JUDGED, name, camera_keys(name))
            last = self.guest.check("ls /tmp/mosaic/frames").split()[-1]
            *_, luma = parse_png_grey(self.guest.fetch(f"/tmp/mosaic/frames/{last}"))
            off = furthest_off(expected_luma(name, width, height, samples_of(name, width, scene), MOSAIC_ROWS), width, luma)
            good &= off <= ROUNDING
            table.append((name, f"{off:.2f} LSB at most"))
        self.stage.table("Colour sensors without an image processor", ("format", "luma off by"), table)
        self.stage.ok("mosaics", good, "; ".join(f"{name}: {text}" for name, text in table))
        self.vivid.stop()
        self.vivid.set_up()

    def calibrate_live(self):
        """As somebody who holds the sheet still in one place after another and soon gives up: what was seen is kept."""
        self.guest.write("/tmp/lens.toml", camera_config())
        self.guest.check(
            """rm -rf /tmp/lens; mkdir /tmp/lens
            (ninedot calibrate camera --config /tmp/lens.toml --out /tmp/lens/camera.yaml > /tmp/lens.log 2>&1 & echo $! > /tmp/lens.pid
            wait $!; echo $? > /tmp/lens.status) > /dev/null 2>&1 &"""
        )
        for number in sorted(self.rows)[::LENS_STEP]:
            self.vivid.play(f"/media/stills/{number:02}.raw")
            time.sleep(STANDS_STILL_S)
            if int(self.guest.check("ls /tmp/lens/camera-views/frames 2> /dev/null | wc -l")) >= 3:
                break
        status, text = self.guest.run(
            """kill -TERM $(cat /tmp/lens.pid)
            for _ in $(seq 200); do [ -s /tmp/lens.status ] && break; sleep 0.05; done
            cat /tmp/lens.log; exit $(cat /tmp/lens.status)"""
        )
        kept = self.guest.check("ls /tmp/lens /tmp/lens/camera-views/frames").split()
        views = sum(name.endswith((".ppm", ".png", ".pgm")) for name in kept)
        said = text.splitlines()[-1] if text else ""
        self.stage.ok(
            "calibrate-live",
            status == 1 and views >= 3 and "camera.yaml" not in kept and "kept in /tmp/lens/camera-views" in said,
            f"{views} views, status {status}: {said}",
        )

    def calibrate_busy(self):
        """While the service has the camera."""
        status, text = self.guest.run("ninedot calibrate camera --config /tmp/lens.toml --out /tmp/busy.yaml")
        self.stage.ok(
            "calibrate-busy",
            status == 2 and re.fullmatch(r"ninedot: /dev/video0: busy: .*systemctl stop ninedotd.*", text) is not None,
            f"status {status}: {text}",
        )

    def stills(self, service):
        """Each scene held until the service shows it: the registers must be those of its row."""
        wrong, shown = [], 0
        scenes = sorted(self.sums)[:: SMOKE_STEP if self.stage.smoke else 1]
        for number in scenes:
            self.vivid.play(f"/media/stills/{number:02}.raw")
            registers = service.wait_for_frames(FRAMES_IN_FLIGHT)
            row = self.rows.get(number)
            if row is None:
                if registers.valid_when_taken or registers.reason not in REASONS_WITHOUT_ROW:
                    wrong.append(f"scene {number}: no row, but valid {int(registers.valid_when_taken)}, reason {registers.reason}")
            elif not registers.valid_when_taken:
                wrong.append(f"scene {number}: not valid, reason {registers.reason}")
            else:
                shown += 1
                wrong += [f"scene {number}: {text}" for text in DifferenceFromRow(registers, row).differences]
        self.stage.ok(
            "stills",
            not wrong and shown == sum(number in self.rows for number in scenes),
            "; ".join(wrong[:3])
            or f"{len(scenes)} scenes: {shown} poses equal the replay's bit for bit, "
            f"{len(scenes) - shown} without landmark give none",
        )

    def free_running(self, service):
        self.vivid.play("/tmp/scenes.raw")
        service.wait_for_frames(FRAMES_IN_FLIGHT)
        reads, seen, wrong, ages = 0, set(), [], []
        started = time.monotonic()
        while (took_s := time.monotonic() - started) < (PATIENCE_S if len(seen) <= len(self.rows) // 3 else FREE_RUNNING_S):
            registers = service.read()
            if not registers.valid_when_taken:
                continue
            reads += 1
            ages.append(registers.age_ms)
            row = nearest_row(self.rows.values(), registers)
            seen.add(row["frame"])
            wrong += DifferenceFromRow(registers, row).differences[:1]
        self.stage.ok(
            "free-running",
            not wrong and len(seen) > len(self.rows) // 3,
            "; ".join(wrong[:3])
            or f"{reads} reads in {took_s:.0f} s show {len(seen)} different poses, each equal to one of the replay's",
        )
        # vivid has no exposure, so a frame's time is its driver's stamp, to the microsecond. Its stamps go by its nominal rate: one in twenty
        # to nine in ten, by how busy the host is, lie some milliseconds ahead of the clock when the buffer is given away, which is not
        # believed: such a frame has the time of its arrival, just after that. The age goes by the same clock: of a wrong one it would be 0 or
        # saturated.
        stamps_ns = [int(row["timestamp_ns"]) for row in csv_rows(self.guest.check("cat /tmp/captured/frames.csv"))]
        own = {frame.stamp_ns for frame in self.given if frame.stamp_ns <= frame.at_ns + CLOCKS_DIFFER_NS}
        ahead = [frame.at_ns for frame in self.given if frame.stamp_ns >= frame.at_ns - CLOCKS_DIFFER_NS]
        replaced = [stamp for stamp in stamps_ns if stamp not in own]
        wrong = [stamp for stamp in replaced if not any(at - CLOCKS_DIFFER_NS <= stamp < at + ARRIVES_NS for at in ahead)]
        ages.sort()
        self.stage.ok(
            "stamps",
            bool(ages) and 0 < ages[0] and ages[-1] < 2000 and len(replaced) < len(stamps_ns) == RECORDED and not wrong,
            f"{len(stamps_ns)} recorded stamps, {len(replaced)} of them times of arrival in place of a stamp ahead of the clock, {len(wrong)} neither; "
            + (f"age of the poses {ages[0]:.1f} to {ages[-1]:.1f} ms" if ages else "no poses"),
        )


def run(stage):
    with stage.guest() as guest:
        test = CameraStage(stage, guest)
        test.listing()
        test.pictures()
        test.formats()
        test.mosaics()
        if not stage.smoke:
            test.calibrate_live()
        test.vivid.play("/tmp/scenes.raw")
        service = GuestService(guest, camera_config())
        with service:
            if not stage.smoke:
                test.calibrate_busy()
            test.stills(service)
            test.free_running(service)
        stage.ok("ends", service.exit_status == "0", f"exit status {service.exit_status} on SIGINT")
