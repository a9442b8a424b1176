"""The bundled recording in a quarter of its size, as one file: it is played a thousand times a second and takes little of the machine."""

import pathlib
import re
import struct
import zlib

SHRINK = 4


def grey_png(path):
    """Returns width, height and rows of an 8-bit grey PNG (ISO/IEC 15948; its five filters)"""
    data = path.read_bytes()
    at, packed, width = 8, b"", 0
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack_from(">IIBB", body)
            if (depth, colour) != (8, 0):
                raise SystemExit(f"{path}: not 8-bit grey")
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, rows, above = zlib.decompress(packed), [], bytes(width)
    for y in range(height):
        kind, row = raw[y * (width + 1)], bytearray(raw[y * (width + 1) + 1:(y + 1) * (width + 1)])
        left = corner = 0
        for x in range(width) if kind else ():
            up = above[x]
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) // 2
            else:
                estimate = left + up - corner
                guess = min((abs(estimate - value), order, value) for order, value in enumerate((left, up, corner)))[2]
            left, corner = (row[x] + guess) & 0xFF, up
            row[x] = left
        rows.append(bytes(row))
        above = rows[-1]
    return width, height, rows


def shrunken(width, height, rows):
    """Returns the mean of each square of pixels"""
    picture = bytearray()
    for top in range(0, height, SHRINK):
        sums = [0] * (width // SHRINK)
        for row in rows[top:top + SHRINK]:
            for x in range(SHRINK):
                sums = [total + value for total, value in zip(sums, row[x::SHRINK])]
        picture += bytes(total // SHRINK**2 for total in sums)
    return bytes(picture)


def make(source, folder):
    """Writes soak.y4m and camera.yaml into the folder and returns the size of its pictures"""
    frames = sorted((source / "frames").iterdir())
    with open(folder / "soak.y4m", "wb") as file:
        for number, path in enumerate(frames):
            width, height, rows = grey_png(path)
            if number == 0:
                file.write(f"YUV4MPEG2 W{width // SHRINK} H{height // SHRINK} F35:1 Ip A1:1 Cmono\n".encode())
            file.write(b"FRAME\n" + shrunken(width, height, rows))
    text = (source / "camera.yaml").read_text()
    text = re.sub(r"(image_(?:width|height): )(\d+)", lambda m: f"{m[1]}{int(m[2]) // SHRINK}", text)
    focal, centre_x, centre_y = 720 / SHRINK, (319.5 + 0.5) / SHRINK - 0.5, (239.5 + 0.5) / SHRINK - 0.5
    text = re.sub(r"data: \[720, 0, 319.5, 0, 720, 239.5, 0, 0, 1\]", f"data: [{focal}, 0, {centre_x}, 0, {focal}, {centre_y}, 0, 0, 1]", text)
    text = re.sub(r"data: \[720, 0, 319.5, 0, 0, 720, 239.5, 0, 0, 0, 1, 0\]", f"data: [{focal}, 0, {centre_x}, 0, 0, {focal}, {centre_y}, 0, 0, 0, 1, 0]", text)
    (pathlib.Path(folder) / "camera.yaml").write_text(text)
    return width // SHRINK, height // SHRINK
