"""The middle of the bundled recording, in which the landmark stays, as one file: it is played a thousand times a second, and half as many pixels each way take less of the machine."""

import struct
import zlib

LEFT, TOP, WIDTH, HEIGHT = 160, 120, 320, 240


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


def make(source, folder):
    """Writes soak.y4m and camera.yaml into the folder and returns the size of its pictures"""
    with open(folder / "soak.y4m", "wb") as file:
        file.write(f"YUV4MPEG2 W{WIDTH} H{HEIGHT} F35:1 Ip A1:1 Cmono\n".encode())
        for path in sorted((source / "frames").iterdir()):
            _, _, rows = grey_png(path)
            file.write(b"FRAME\n" + b"".join(row[LEFT:LEFT + WIDTH] for row in rows[TOP:TOP + HEIGHT]))
    text = (source / "camera.yaml").read_text()
    # The middle of what is left is half a pixel before its half width, as it was of the whole.
    for before, after in (("width: 640", f"width: {WIDTH}"), ("height: 480", f"height: {HEIGHT}"), ("319.5", str(319.5 - LEFT)), ("239.5", str(239.5 - TOP))):
        if before not in text:
            raise SystemExit(f"{source}/camera.yaml: no '{before}'")
        text = text.replace(before, after)
    (folder / "camera.yaml").write_text(text)
    return WIDTH, HEIGHT
