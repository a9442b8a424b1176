"""Reads 8-bit grey PNG files, with Python's own library alone."""

import struct
import zlib


def read_png_grey(path):
    """\\return  (width, height, bytes in rows from the top)"""
    return parse_png_grey(path.read_bytes(), path)


def parse_png_grey(data, path="picture"):
    """\\return  as read_png_grey"""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path}: no PNG file")
    header, packed, position = None, b"", 8
    while position < len(data):
        size, kind = struct.unpack_from(">I4s", data, position)
        body = data[position + 8 : position + 8 + size]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        position += size + 12
    width, height, *rest = header
    if rest != [8, 0, 0, 0, 0]:
        raise ValueError(f"{path}: not 8-bit grey without interlacing")
    return width, height, _unfilter(zlib.decompress(packed), width, height)


def _unfilter(filtered, width, height):
    """PNG specification (RFC 2083), section 6; one byte per pixel."""
    above, rows = bytes(width), []
    for start in range(0, height * (width + 1), width + 1):
        kind, row = filtered[start], bytearray(filtered[start + 1 : start + 1 + width])
        if kind == 2:
            row = bytearray((value + up) & 0xFF for value, up in zip(row, above))
        elif kind != 0:
            predict = {1: lambda left, up, corner: left, 3: lambda left, up, corner: (left + up) // 2, 4: _paeth}[kind]
            left = corner = 0
            for i, up in enumerate(above):
                left = row[i] = (row[i] + predict(left, up, corner)) & 0xFF
                corner = up
        rows.append(bytes(row))
        above = rows[-1]
    return b"".join(rows)


def _paeth(left, up, corner):
    to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if to_left <= to_up and to_left <= to_corner:
        return left
    return up if to_up <= to_corner else corner
