"""What the boot script and fw_setenv keep on the disk: which system starts, in two copies before the first partition."""

import struct
import zlib

SIZE, PLACES = 0x4000, (0x100000, 0x200000)


def pack(count, values):
    """Returns one copy: CRC of the text, how often it was written (one byte), the text"""
    text = b"".join(f"{name}={value}".encode() + b"\0" for name, value in values.items()) + b"\0"
    text = text.ljust(SIZE - 5, b"\0")
    return struct.pack("<IB", zlib.crc32(text), count & 0xFF) + text


def unpack(copy):
    """Returns count and values, or None if the CRC is wrong"""
    crc, count = struct.unpack_from("<IB", copy)
    if crc != zlib.crc32(copy[5:]):
        return None
    lines = copy[5:].split(b"\0\0", 1)[0].split(b"\0")
    return count, dict(line.decode().split("=", 1) for line in lines if b"=" in line)


def read_copies(image):
    """Returns both copies of a disk image as they stand there"""
    with open(image, "rb") as file:
        copies = []
        for place in PLACES:
            file.seek(place)
            copies.append(file.read(SIZE))
    return copies


def write_copy(image, number, data):
    with open(image, "r+b") as file:
        file.seek(PLACES[number])
        file.write(data)


def newest(image):
    """Returns number and values of the copy that counts, by fw_printenv's rule; None if neither is whole"""
    first, second = (unpack(copy) for copy in read_copies(image))
    if first is None or second is None:
        return (0, first[1]) if first else (1, second[1]) if second else None
    is_second = second[0] > first[0]
    if {first[0], second[0]} == {0, 0xFF}:
        is_second = second[0] == 0
    return (1, second[1]) if is_second else (0, first[1])
