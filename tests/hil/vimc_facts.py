"""What vimc's Sensor B, as vimc_sensor.sh makes it, has to have and to give when the configuration asks for this."""

import math
import re

WIDTH, HEIGHT = 640, 480
# Lines of 640 and 890 pixels at 200 MHz.
LINE_US = 1530 / 200.0
EXPOSURE_US, GAIN, RATE_HZ = 5000, 32, 20.0
LINES = round(EXPOSURE_US / LINE_US)
BLANK = round(1e6 / RATE_HZ / LINE_US) - HEIGHT
CONTROLS = {"exposure": LINES, "analogue_gain": GAIN, "vertical_blanking": BLANK, "horizontal_blanking": 890}
# The pattern's bars: white, yellow, cyan, green, magenta, red, blue, black at 191 of 255; their luma by docs/cameras.md.
BARS = [255 * math.sqrt(191 / 255 * quarters / 4) for quarters in (4, 3, 3, 2, 2, 1, 1, 0)]


def sensors_listed(text):
    """Of `ninedot cameras`: \\return  {device: the lines below it}"""
    return dict(re.findall(r"^(sensor:[^\n]*?)  vimc, [^\n]*\n((?:  [^\n]*\n?)*)", text, re.M))


def furthest_from_middle(stamps_ns, given_ns):
    """Of recorded stamps, which lie half of the exposure before one of the driver's: the largest difference [ns]."""
    half_ns = LINES * LINE_US * 1000 / 2
    return max((min((abs(stamp + half_ns - end) for end in given_ns), default=math.inf) for stamp in stamps_ns), default=math.inf)


def lines_of_stamps(stamps_ns, given):
    """\\return  (for each stamp the exposure that it was reckoned with [lines], when the driver gave that frame away [ns])"""
    lines, at_ns = [], []
    for stamp in stamps_ns:
        frame = min(given, key=lambda frame: abs(frame.stamp_ns - stamp))
        lines.append(round(2 * (frame.stamp_ns - stamp) / 1000 / LINE_US))
        at_ns.append(frame.at_ns)
    return lines, at_ns


def is_switched_on(topology):
    """Of `media-ctl -p`: the link from Sensor B to its node."""
    return re.search(r'-> "Raw Capture 1":0 \[ENABLED\]', topology) is not None
