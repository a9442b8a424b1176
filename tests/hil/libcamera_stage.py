"""Recorded frames through libcamera's virtual camera: the poses are those of the JPEG files that it shows."""

import math
import pathlib
import time

from registers import DifferenceFromRow
from service import GuestService, camera_config, checksums, nearest_row, replay

CHECKS = SMOKE_CHECKS = ("cameras", "check", "pictures", "poses", "live", "ends")

RECORDED = 160  # the camera shows each picture four times
LIVE_S = 10.0
# What quality 95 may do to a pose, in units of the pose's own 1-sigma.
MAX_JPEG_ERROR_SIGMA = 3.0
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
    return any(b"virtual.yaml" in path.read_bytes() for path in libraries)


def errors_in_sigma(row, other):
    return [abs(float(row[f"{axis}_mm"]) - float(other[f"{axis}_mm"])) / math.hypot(float(row[f"sigma_{axis}_mm"]), float(other[f"sigma_{axis}_mm"]))
            for axis in "xyz"]


def run(stage):
    if not host_has_virtual_pipeline():
        stage.leave_out("this machine's libcamera has no virtual camera (0.4 of Debian 13 has): tests/fresh_debian.sh trixie ./dev hil libcamera")
        return
    with stage.guest() as guest:
        guest.write("/usr/share/libcamera/pipeline/virtual/virtual.yaml", VIRTUAL_YAML)
        guest.run("modprobe udmabuf")
        text = guest.check("ninedot cameras 2>&1")
        stage.ok("cameras", "Virtual0" in text and "Paper" in text and "NV12" in text, "`ninedot cameras` lists the camera, its model and its format")
        config = camera_config(pixel_format="auto", rate_hz=30.0).replace('"v4l2"', '"libcamera"').replace('"/dev/video0"', '"Paper"')
        guest.write("/tmp/ninedotd.toml", config)
        status, text = guest.run("ninedot check --config /tmp/ninedotd.toml")
        stage.ok("check", status == 0, text.splitlines()[-1] if text else "`ninedot check` opens the camera")
        jpegs, frames = pictures(stage, guest)
        poses(stage, guest, jpegs, frames)
        service = GuestService(guest, config)
        with service:
            live(stage, service, jpegs)
        stage.ok("ends", service.exit_status == "0", f"exit status {service.exit_status} on SIGINT")


def pictures(stage, guest):
    """\\return  (rows of the JPEG files, scene of each captured frame)"""
    guest.write("/tmp/jpegs.toml", '[camera]\nsource = "recording"\ndevice = "/media/jpegs"\nloop = false')
    guest.check("ninedot record --config /tmp/jpegs.toml --out /tmp/jpegs", 120)
    scene_of = {digest: number for number, digest in checksums(guest, "/tmp/jpegs").items()}
    said = guest.check(f"ninedot record --config /tmp/ninedotd.toml --out /tmp/captured --frames {RECORDED}", 180).splitlines()[-1]
    frames = {number: scene_of.get(digest) for number, digest in checksums(guest, "/tmp/captured").items()}
    foreign = list(frames.values()).count(None)
    stage.ok("pictures", len(frames) == RECORDED and foreign == 0,
             f"{len(frames)} captured, {len(set(frames.values()))} of {len(scene_of)} scenes, {foreign} differ from the decoded JPEG files ({said})")
    return replay(guest, "/media/jpegs"), frames


def poses(stage, guest, jpegs, frames):
    captured = replay(guest, "/tmp/captured", "--camera /media/scenes/camera.yaml")
    by_scene = {int(row["frame"]): row for row in jpegs}
    originals = {int(row["frame"]): row for row in replay(guest, "/media/scenes")}
    equal, worst_sigma, worst_mm = 0, 0.0, 0.0
    for row in captured:
        scene = frames[int(row["frame"])]
        own = by_scene.get(scene)
        equal += own is not None and all(row[name] == own[name] for name in row if name not in ("frame", "timestamp_ns", "process_us"))
        if scene in originals:
            worst_sigma = max(worst_sigma, *errors_in_sigma(row, originals[scene]))
            worst_mm = max(worst_mm, *(abs(float(row[f"{axis}_mm"]) - float(originals[scene][f"{axis}_mm"])) for axis in "xyz"))
    stage.ok("poses", captured and equal == len(captured) and worst_sigma <= MAX_JPEG_ERROR_SIGMA,
             f"{equal} of {len(captured)} poses equal those of the JPEG files bit for bit; these differ from the originals' by {worst_mm:.3f} mm, {worst_sigma:.2f} sigma at most")


def live(stage, service, jpegs):
    service.wait_for(lambda registers: registers.valid, "a valid pose")
    reads, seen, wrong = 0, set(), []
    ends = time.monotonic() + LIVE_S
    while time.monotonic() < ends:
        registers = service.read()
        if not registers.valid:
            continue
        reads += 1
        row = nearest_row(jpegs, registers)
        seen.add(row["frame"])
        wrong += DifferenceFromRow(registers, row).differences[:1]
    stage.ok("live", not wrong and len(seen) > len(jpegs) // 3,
             "; ".join(wrong[:3]) or f"{reads} reads in {LIVE_S:.0f} s show {len(seen)} different poses, each equal to one of the JPEG files'")
