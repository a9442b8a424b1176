"""What the soak plays: a small landmark, looked at from two places, and between them a longer look at a wall without one, as a vehicle drives from one
to the next. Lost and found twice a turn; and the pictures are so small that thousands of them are processed in a second."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "hil"))
from png_grey import read_png_grey

SIZE_PX = 48
STAYS, EMPTY = 80, 120  # frames, of each look
# Picture and the middle of what is cut out of it.
PARTS = (
    ("000000.png", (309, 238), STAYS),
    ("000000.png", (560, 60), EMPTY),
    ("000000.png", (305, 235), STAYS),
    ("000000.png", (560, 60), EMPTY),
)

SHOWN, FRAMES = 2 * STAYS, 2 * (STAYS + EMPTY)  # in one pass: frames that show it, and all


def make(source, folder):
    """Writes soak.y4m and camera.yaml into the folder and returns the width, and height, of its pictures"""
    with open(folder / "soak.y4m", "wb") as file:
        file.write(f"YUV4MPEG2 W{SIZE_PX} H{SIZE_PX} F35:1 Ip A1:1 Cmono\n".encode())
        for name, middle, times in PARTS:
            width, _, luma = read_png_grey(source / "frames" / name)
            left, top = (at - SIZE_PX // 2 for at in middle)
            rows = (luma[y * width + left:y * width + left + SIZE_PX] for y in range(top, top + SIZE_PX))
            file.write((b"FRAME\n" + b"".join(rows)) * times)
    text = (source / "camera.yaml").read_text()
    # As if each landmark hung before the middle of the camera: of such pictures it is the calibration.
    middle = (SIZE_PX - 1) / 2
    for before, after in (("width: 640", f"width: {SIZE_PX}"), ("height: 480", f"height: {SIZE_PX}"), ("319.5", str(middle)), ("239.5", str(middle))):
        if before not in text:
            raise SystemExit(f"{source}/camera.yaml: no '{before}'")
        text = text.replace(before, after)
    (folder / "camera.yaml").write_text(text)
    return SIZE_PX
