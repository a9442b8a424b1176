"""What the guest's cameras show: the recorded frames as one recording, and as the raw bytes that go into a V4L2 output node."""

import pathlib
import shutil
import subprocess

from mosaic import BAYER_FORMATS, as_bytes, samples_of
from png_grey import read_png_grey

# All of one camera; the negatives show no landmark, and the service has to say so.
RECORDINGS = ("approach", "positions", "tilt", "occlusion", "lowlight", "negative")
FRAME_PERIOD_NS = 1_000_000_000 // 35


def with_chroma(luma, *, luma_first):
    """YUYV or UYVY with grey chroma."""
    packed = bytearray(b"\x80" * (2 * len(luma)))
    packed[0 if luma_first else 1 :: 2] = luma
    return bytes(packed)


def widened(luma, shift):
    """16-bit little-endian words with the luma `shift` bits up."""
    return b"".join((value << shift).to_bytes(2, "little") for value in luma)


# How the 8-bit luma is written in each format from which the service must get it back unchanged.
PIXEL_FORMATS = {
    "GREY": lambda luma: luma,
    "YUYV": lambda luma: with_chroma(luma, luma_first=True),
    "UYVY": lambda luma: with_chroma(luma, luma_first=False),
    "NV12": lambda luma: luma + b"\x80" * (len(luma) // 2),
    "NV21": lambda luma: luma + b"\x80" * (len(luma) // 2),
    "YU12": lambda luma: luma + b"\x80" * (len(luma) // 2),
    "Y10": lambda luma: widened(luma, 2),
    "Y12": lambda luma: widened(luma, 4),
    "Y16": lambda luma: widened(luma, 8),
}
SCENE_OF_FORMATS = 3
JPEG_QUALITY = 95


def as_jpeg(width, height, luma):
    return subprocess.run(
        ["cjpeg", "-grayscale", "-quality", str(JPEG_QUALITY)],
        input=f"P5 {width} {height} 255\n".encode() + luma,
        capture_output=True,
        check=True,
    ).stdout


def source_pictures(recordings):
    return [(name, picture) for name in RECORDINGS for picture in sorted((recordings / name / "frames").glob("*.png"))]


def make_media(recordings, folder):
    """FOLDER/scenes: a recording, numbered from 0; FOLDER/stills/NN.raw: its pictures; FOLDER/formats/F.raw: one of them in each
    format; FOLDER/jpeg/N.jpg: all of them as JPEG. Made once; a newer source makes it anew."""
    pictures = source_pictures(recordings)
    stamp = folder / "complete"
    sources = [picture for _, picture in pictures] + [pathlib.Path(__file__), pathlib.Path(__file__).with_name("mosaic.py")]
    if stamp.exists() and stamp.stat().st_mtime > max(source.stat().st_mtime for source in sources):
        return
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("scenes/frames", "stills", "formats", "jpeg"):
        (folder / name).mkdir(parents=True)
    shutil.copyfile(recordings / RECORDINGS[0] / "camera.yaml", folder / "scenes" / "camera.yaml")
    rows = ["frame,timestamp_ns,pan_deg,tilt_deg\n"]
    for number, (_, picture) in enumerate(pictures):
        shutil.copyfile(picture, folder / "scenes" / "frames" / f"{number:06}.png")
        rows.append(f"{number},{number * FRAME_PERIOD_NS},0,0\n")
        width, height, luma = read_png_grey(picture)
        (folder / "jpeg" / f"{number}.jpg").write_bytes(as_jpeg(width, height, luma))
        (folder / "stills" / f"{number:02}.raw").write_bytes(luma)
        if number == SCENE_OF_FORMATS:
            for name, written in PIXEL_FORMATS.items():
                (folder / "formats" / f"{name}.raw").write_bytes(written(luma))
            for name in BAYER_FORMATS:
                (folder / "formats" / f"{name}.raw").write_bytes(as_bytes(name, samples_of(name, width, luma)))
    (folder / "scenes" / "frames.csv").write_text("".join(rows))
    stamp.touch()
