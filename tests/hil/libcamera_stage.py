"""Recorded frames through libcamera's virtual camera: the poses are the replay's within the error of its JPEG files."""

import csv
import math
import pathlib
import subprocess
import time

from png_grey import read_png_grey
from registers import DifferenceFromRow
from service import GuestService, camera_config, checksums, nearest_row, replay

CHECKS = SMOKE_CHECKS = ("cameras", "check", "pictures", "poses", "live", "ends")

RECORDED = 200  # the camera shows each picture four times, and does not wait
LIVE_S = 10.0
# JPEG at quality 95, and libcamera's way from there to NV12 by way of RGB: measured 1.6 and 14 grey levels at most.
MAX_MEAN_DIFFERENCE, MAX_DIFFERENCE = 2.5, 24
# What that may do to a pose, in units of its own 1-sigma.
MAX_POSE_ERROR_SIGMA = 3.0
NINEDOT = pathlib.Path(__file__).resolve().parents[2] / "build" / "release" / "bin" / "ninedot"  # as it is in the guest
WIDTH, HEIGHT = 640, 480
COARSE, FINE = 307, 7  # every so-manieth pixel tells which scene it is, and how well it is kept
VIRTUAL_YAML = """"Virtual0":
  supported_formats:
  - width: 640
    height: 480
    frame_rates:
    - 30
    - 60
  frames:
    path: "/media/jpeg/"
  location: "CameraLocationFront"
  model: "Paper"
"""


def host_has_virtual_pipeline():
    libraries = [path for folder in pathlib.Path("/usr/lib").glob("*-linux-gnu") for path in folder.glob("libcamera.so.*")]
    return any(b"VirtualCameraData" in path.read_bytes() for path in libraries)


def difference(picture, other, step):
    """\\return  (mean, largest) of the absolute differences"""
    values = [abs(a - b) for a, b in zip(picture[::step], other[::step])]
    return sum(values) / len(values), max(values)


class LibcameraStage:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        guest.write("/usr/share/libcamera/pipeline/virtual/virtual.yaml", VIRTUAL_YAML)
        guest.run("modprobe udmabuf")
        self.config = (
            camera_config(pixel_format="auto", rate_hz=30.0).replace('"v4l2"', '"libcamera"').replace('"/dev/video0"', '"Paper"')
        )
        guest.write("/tmp/ninedotd.toml", self.config)
        self.originals = {int(row["frame"]): row for row in replay(guest, "/media/scenes")}
        self.captured = []

    def listing(self):
        text = self.guest.check("ninedot cameras 2>&1")
        self.stage.ok(
            "cameras",
            "Virtual0" in text and "Paper" in text and "NV12" in text,
            "`ninedot cameras` lists the camera, its model and its format",
        )
        status, text = self.guest.run("ninedot check --config /tmp/ninedotd.toml")
        self.stage.ok("check", status == 0, "`ninedot check` opens the camera" if status == 0 else text)

    def pictures(self):
        """Which scene each captured frame shows."""
        said = self.guest.check(
            f"ninedot record --grey --config /tmp/ninedotd.toml --out /tmp/captured --frames {RECORDED}", 180
        ).splitlines()[-1]
        sums = checksums(self.guest, "/tmp/captured")
        scenes = [path.read_bytes() for path in sorted((self.stage.out / "media" / "stills").glob("*.raw"))]
        self.scene_of, self.luma, means, largest = {}, [], [], []
        for digest in set(sums.values()):
            number = next(number for number, other in sums.items() if other == digest)
            copy = self.stage.out / "captured.png"
            copy.write_bytes(self.guest.fetch(f"/tmp/captured/frames/{number:06}.png"))
            picture = read_png_grey(copy)[2]
            self.luma.append(picture)
            self.scene_of[digest] = min(range(len(scenes)), key=lambda i: difference(picture, scenes[i], COARSE)[0])
            mean, most = difference(picture, scenes[self.scene_of[digest]], FINE)
            means.append(mean)
            largest.append(most)
        self.scenes = {number: self.scene_of[digest] for number, digest in sums.items()}
        seen = set(self.scenes.values())
        self.missing = len(scenes) - len(seen)
        self.stage.ok(
            "pictures",
            len(sums) == RECORDED
            and len(seen) > len(scenes) // 2
            and len(self.scene_of) == len(seen)
            and max(means) < MAX_MEAN_DIFFERENCE
            and max(largest) < MAX_DIFFERENCE,
            f"{len(seen)} of {len(scenes)} scenes captured, each always the same; grey levels differ from the originals' "
            f"by {max(means):.2f} in the mean, {max(largest)} at most ({said})",
        )

    def poses(self):
        self.captured = replay(self.guest, "/tmp/captured", "--camera /media/scenes/camera.yaml")
        worst_sigma, worst_mm, unexpected = 0.0, 0.0, 0
        for row in self.captured:
            original = self.originals.get(self.scenes[int(row["frame"])])
            if original is None:
                unexpected += 1
                continue
            errors_mm = [abs(float(row[f"{axis}_mm"]) - float(original[f"{axis}_mm"])) for axis in "xyz"]
            sigmas_mm = [math.hypot(*(float(r[f"sigma_{axis}_mm"]) for r in (row, original))) for axis in "xyz"]
            worst_mm = max(worst_mm, *errors_mm)
            worst_sigma = max(worst_sigma, *(error / sigma for error, sigma in zip(errors_mm, sigmas_mm)))
        expected = sum(scene in self.originals for scene in self.scenes.values())
        self.stage.ok(
            "poses",
            unexpected == 0 and len(self.captured) == expected and worst_sigma <= MAX_POSE_ERROR_SIGMA,
            f"{len(self.captured)} poses of {expected} frames with a landmark; x, y and z differ from the originals' "
            f"by {worst_mm:.2f} mm, {worst_sigma:.2f} sigma at most",
        )

    def coloured(self):
        """Rows of `ninedot replay` of the captured luma with neutral colour: pictures of a colour camera are fitted with a pattern's unknowns."""
        video = self.stage.out / "captured.y4m"
        neutral = bytes([128]) * (WIDTH * HEIGHT // 2)
        with open(video, "wb") as file:
            file.write(f"YUV4MPEG2 W{WIDTH} H{HEIGHT} F30:1 Ip A1:1 C420jpeg\n".encode())
            for picture in self.luma:
                file.write(b"FRAME\n" + bytes(picture) + neutral)
        config, poses = self.stage.out / "replay.toml", self.stage.out / "replay.csv"
        config.write_text("[pose]\ntracking = false\n")
        camera = self.stage.out / "media" / "scenes" / "camera.yaml"
        subprocess.run([NINEDOT, "replay", video, "--camera", camera, "--config", config, "--out", poses], check=True, capture_output=True)
        with open(poses, newline="", encoding="ascii") as file:
            return [row for row in csv.DictReader(file) if row["valid"] == "1"]

    def live(self, service):
        service.wait_for(lambda registers: registers.valid, "a valid pose")
        coloured = self.coloured()
        reads, seen, wrong = 0, set(), []
        ends = time.monotonic() + LIVE_S
        while time.monotonic() < ends:
            registers = service.read()
            if not registers.valid_when_taken:
                continue
            reads += 1
            row = nearest_row(coloured, registers)
            differences = DifferenceFromRow(registers, row).differences
            if not differences:
                seen.add(int(row["frame"]))
            elif not self.missing:  # else it may be one that was not recorded
                wrong += differences[:1]
        self.stage.ok(
            "live",
            not wrong and len(seen) > len(self.originals) // 3,
            f"{len(wrong)} of {reads} reads differ: {'; '.join(wrong[:3])}"
            if wrong
            else f"{reads} reads in {LIVE_S:.0f} s show the poses of {len(seen)} scenes, bit for bit those of the recorded frames",
        )

    def run(self):
        self.listing()
        self.pictures()
        self.poses()
        service = GuestService(self.guest, self.config)
        with service:
            self.live(service)
        self.stage.ok("ends", service.exit_status == "0", f"exit status {service.exit_status} on SIGINT")


def run(stage):
    if not host_has_virtual_pipeline():
        stage.leave_out(
            "this machine's libcamera has no virtual camera (0.4 of Debian 13 has): "
            "tests/fresh_debian.sh trixie ./dev hil libcamera"
        )
        return
    with stage.guest() as guest:
        LibcameraStage(stage, guest).run()
