"""A colour sensor's own numbers of a picture, and the luma that has to come of them, worked out from what docs/cameras.md promises."""

import math

# Name in the configuration -> (V4L2's code, bits of a sample, which colour stands where in a cell: its upper row, its lower one)
BAYER_FORMATS = {
    "RGGB": ("RGGB", 8, "RGGB"),
    "GBRG": ("GBRG", 8, "GBRG"),
    "BGGR10": ("BG10", 10, "BGGR"),
    "GRBG12": ("BA12", 12, "GRBG"),
}
GAINS = {"R": 1.6, "G": 1.0, "B": 2.2}


def black_level(bits):
    return 16 << (bits - 8)


def camera_keys(name):
    """Of [camera]."""
    _, bits, _ = BAYER_FORMATS[name]
    return f"black_level = {black_level(bits)}\nred_gain = {GAINS['R']}\nblue_gain = {GAINS['B']}"


def samples_of(name, width, luma):
    """The sensor's number at each pixel [LSB]. Light goes with the luma's square; red and blue get less of it than green."""
    _, bits, cell = BAYER_FORMATS[name]
    black, white = black_level(bits), (1 << bits) - 1
    tables = [[round(black + (white - black) * (value / 255) ** 2 / GAINS[colour]) for value in range(256)] for colour in cell]
    return [tables[2 * (i // width % 2) + i % width % 2][value] for i, value in enumerate(luma)]


def as_bytes(name, samples):
    _, bits, _ = BAYER_FORMATS[name]
    return bytes(samples) if bits == 8 else b"".join(sample.to_bytes(2, "little") for sample in samples)


def expected_luma(name, width, height, samples, rows):
    """Of some rows: the tone of the light by 1 2 1 / 2 4 2 / 1 2 1, the borders mirrored. \\return  {row: [luma as a float]}"""
    _, bits, cell = BAYER_FORMATS[name]
    black, white = black_level(bits), (1 << bits) - 1

    def light(x, y):
        x, y = (abs(x) if x < width else 2 * width - 2 - x), (abs(y) if y < height else 2 * height - 2 - y)
        colour = cell[2 * (y % 2) + x % 2]
        return min(max(GAINS[colour] * (samples[y * width + x] - black) / (white - black), 0.0), 1.0)

    wanted = {}
    for y in rows:
        columns = [light(x, y - 1) + 2 * light(x, y) + light(x, y + 1) for x in range(-1, width + 1)]
        wanted[y] = [255 * math.sqrt((columns[x] + 2 * columns[x + 1] + columns[x + 2]) / 16) for x in range(width)]
    return wanted


def furthest_off(wanted, width, luma):
    """Largest difference of a picture from those rows [LSB]."""
    return max(abs(luma[y * width + x] - value) for y, row in wanted.items() for x, value in enumerate(row))
