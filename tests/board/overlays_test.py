#!/usr/bin/python3
"""The board image's device-tree overlays, laid over the device trees that Debian's kernel has for Raspberry Pis; and what the board says of a
line of config.txt that can't be done.

    tests/board/overlays_test.py [FOLDER]     FOLDER: where the boards' *.dtb are; default: those of build/image/ninedot-arm64.img

Needs device-tree-compiler, and mtools for the default. No kernel is started: what the drivers make of the nodes is raspberry_test.sh's to try.
"""

import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
BOARD_PROGRAMS = os.path.join(ROOT, "systemd/image/root/usr/lib/ninedot")
CHECK = os.path.join(BOARD_PROGRAMS, "check-overlays")
RECEIVER = "/soc/csi@7e801000"
SERIAL, SMALL_SERIAL, PWM = "/soc/serial@7e201000", "/soc/serial@7e215040", "/soc/pwm@7e20c000"

# Suffix of the overlay's name: device trees, I2C bus, GPIO controller and line of the camera's power switch.
BOARDS = {
    "": (["bcm2711-rpi-4-b"], "/i2c-mux0/i2c@1", "/soc/firmware/gpio", 5),
    "-pi3": (["bcm2837-rpi-3-b", "bcm2837-rpi-3-b-plus"], "/soc/i2c@7e205000", "/soc/firmware/gpio", 5),
    "-zero2": (["bcm2837-rpi-zero-2-w"], "/soc/i2c@7e205000", "/soc/gpio@7e200000", 40),
}
# What each driver asks for (drivers/media/i2c in the kernel's source): compatible, I2C address, clock [Hz], lanes, link frequency [Hz] or None, supplies.
SENSORS = {
    "ov9281": ("ovti,ov9281", 0x60, 24_000_000, [1, 2], 400_000_000, ["avdd", "dovdd", "dvdd"]),
    "imx296": ("sony,imx296", 0x1A, 54_000_000, [1], None, ["avdd", "dvdd", "ovdd"]),
    "imx219": ("sony,imx219", 0x10, 24_000_000, [1, 2], 456_000_000, ["VANA", "VDIG", "VDDL"]),
    "ov5647": ("ovti,ov5647", 0x36, 25_000_000, [1, 2], None, []),
}
EVERY_BOARD = [name for trees, *_ in BOARDS.values() for name in trees]

trees = sys.argv[1] if len(sys.argv) > 1 else None
work = None


class Tree:
    """One flattened device tree, asked by fdtget."""

    def __init__(self, path):
        self.path = path

    def _ask(self, *arguments):
        done = subprocess.run(["fdtget", *arguments], capture_output=True, text=True, check=False)
        return done.stdout.strip() if done.returncode == 0 else None

    def text(self, node, name):
        return self._ask("-t", "s", self.path, node, name)

    def numbers(self, node, name):
        found = self._ask("-t", "u", self.path, node, name)
        return None if found is None else [int(word) for word in found.split()]

    def has(self, node, name):
        return name in (self._ask("-p", self.path, node) or "").split("\n")

    def phandle(self, node):
        found = self.numbers(node, "phandle")
        return found[0] if found else None


def board(name):
    return Tree(os.path.join(trees, name + ".dtb"))


def overlaid(name, *overlays):
    """Returns the board's tree with the overlays laid over it, as the board's firmware would"""
    path = os.path.join(work, "+".join((name,) + overlays) + ".dtb")
    files = [os.path.join(work, "overlays", overlay + ".dtbo") for overlay in overlays]
    done = subprocess.run(["fdtoverlay", "-i", board(name).path, "-o", path, *files], capture_output=True, text=True, check=False)
    return Tree(path) if done.returncode == 0 else None


def on_every_camera(check):
    """Makes a test of a check of one tree with one camera's overlay: sensor, its node, GPIO controller and line of the power switch"""
    def test(self):
        for sensor in SENSORS:
            for suffix, (names, bus, gpio, line) in BOARDS.items():
                for name in names:
                    with self.subTest(overlay=f"camera-{sensor}{suffix}", board=name):
                        tree = overlaid(name, f"camera-{sensor}{suffix}")
                        self.assertIsNotNone(tree, "does not apply")
                        check(self, tree, sensor, f"{bus}/camera@{SENSORS[sensor][1]:x}", (gpio, line))
    return test


class Cameras(unittest.TestCase):
    @on_every_camera
    def test_sensor_and_receiver_are_linked_both_ways(self, tree, sensor, node, power):
        here, there = f"{node}/port/endpoint", f"{RECEIVER}/port/endpoint"
        self.assertIsNotNone(tree.phandle(here))
        self.assertEqual(tree.numbers(here, "remote-endpoint"), [tree.phandle(there)])
        self.assertEqual(tree.numbers(there, "remote-endpoint"), [tree.phandle(here)])

    @on_every_camera
    def test_receiver_is_on_with_the_lanes_of_the_sensor(self, tree, sensor, node, power):
        lanes = SENSORS[sensor][3]
        self.assertEqual(tree.text(RECEIVER, "status"), "okay")
        self.assertEqual(tree.numbers(f"{RECEIVER}/port/endpoint", "bus-type"), [4])
        for end in (f"{node}/port/endpoint", f"{RECEIVER}/port/endpoint"):
            self.assertEqual(tree.numbers(end, "data-lanes"), lanes)
        # One end that turns its clock off between lines and one that waits for it would see nothing.
        self.assertEqual(tree.has(f"{node}/port/endpoint", "clock-noncontinuous"), tree.has(f"{RECEIVER}/port/endpoint", "clock-noncontinuous"))
        self.assertLessEqual(len(lanes), tree.numbers(RECEIVER, "brcm,num-data-lanes")[0])

    @on_every_camera
    def test_sensor_has_what_its_driver_asks_for(self, tree, sensor, node, power):
        compatible, address, clock_hz, _, link_hz, supplies = SENSORS[sensor]
        self.assertEqual(tree.text(node, "compatible"), compatible)
        self.assertEqual(tree.numbers(node, "reg"), [address])
        self.assertEqual(tree.numbers(node, "clocks"), [tree.phandle("/ninedot-camera-clock")])
        self.assertEqual(tree.numbers("/ninedot-camera-clock", "clock-frequency"), [clock_hz])
        if link_hz:
            self.assertEqual(tree.numbers(f"{node}/port/endpoint", "link-frequencies"), [link_hz >> 32, link_hz & 0xFFFFFFFF])
        for supply in supplies:
            self.assertEqual(tree.numbers(node, f"{supply}-supply"), [tree.phandle("/ninedot-camera-power")])
        if not supplies:
            self.assertTrue(tree.has("/ninedot-camera-power", "regulator-always-on"))

    @on_every_camera
    def test_bus_is_the_connectors_and_on(self, tree, sensor, node, power):
        bus = os.path.dirname(node)
        self.assertIn(tree.text(bus, "status"), (None, "okay"))
        self.assertEqual((tree.numbers(bus, "#address-cells"), tree.numbers(bus, "#size-cells")), ([1], [0]))
        pins, switch = "/soc/gpio@7e200000/i2c0-gpio44", os.path.dirname(bus)
        if switch == "/i2c-mux0":
            self.assertEqual(tree.numbers(switch, "pinctrl-1"), [tree.phandle(pins)])
        else:
            self.assertEqual(tree.numbers(bus, "pinctrl-0"), [tree.phandle(pins)])
        self.assertEqual(tree.numbers(pins, "brcm,pins"), [44, 45])

    @on_every_camera
    def test_power_is_switched_by_the_boards_line(self, tree, sensor, node, power):
        switch = "/ninedot-camera-power"
        parent = tree.numbers(switch, "vin-supply")
        if parent:  # the board's tree has the switch itself
            switch = "/regulator-cam1"
            self.assertEqual(parent, [tree.phandle(switch)])
        self.assertEqual(tree.text(switch, "compatible"), "regulator-fixed")
        self.assertEqual(tree.numbers(switch, "gpio"), [tree.phandle(power[0]), power[1], 0])
        self.assertTrue(tree.has(switch, "enable-active-high"))

    def test_without_an_overlay_nothing_is_on(self):
        for name in EVERY_BOARD:
            self.assertEqual(board(name).text(RECEIVER, "status"), "disabled")


class Pins(unittest.TestCase):
    def test_pwm_comes_out_of_the_pins_of_its_name(self):
        for overlay, pins, function in (("pwm-gpio12-13", [12, 13], 4), ("pwm-gpio18-19", [18, 19], 2)):
            for name in EVERY_BOARD:
                with self.subTest(overlay=overlay, board=name):
                    tree = overlaid(name, overlay)
                    self.assertIsNotNone(tree, "does not apply")
                    self.assertEqual(tree.text(PWM, "status"), "okay")
                    state = "/soc/gpio@7e200000/ninedot-pwm-pins"
                    self.assertEqual(tree.numbers(PWM, "pinctrl-0"), [tree.phandle(state)])
                    self.assertEqual(tree.text(PWM, "pinctrl-names"), "default")
                    self.assertEqual(tree.numbers(state, "brcm,pins"), pins)
                    self.assertEqual(tree.numbers(state, "brcm,function"), [function])
                    # What the kernel's own tree calls these pins' PWM has the same number.
                    for pin, channel in zip(pins, (0, 1)):
                        theirs = tree.numbers(f"/soc/gpio@7e200000/pwm{channel}-gpio{pin}", "brcm,function")
                        self.assertIn(theirs, (None, [function]))

    def test_serial_port_is_on_the_connector_and_nobody_elses(self):
        for name in EVERY_BOARD:
            with self.subTest(board=name):
                tree = overlaid(name, "uart-ttyAMA0")
                self.assertIsNotNone(tree, "does not apply")
                self.assertEqual(tree.text(SERIAL, "status"), "okay")
                self.assertEqual(tree.numbers(SERIAL, "pinctrl-0"), [tree.phandle("/soc/gpio@7e200000/uart0-gpio14")])
                self.assertEqual(tree.numbers("/soc/gpio@7e200000/uart0-gpio14", "brcm,pins"), [14, 15])
                # The kernel makes a tty of a port only where nothing is said to hang on it.
                self.assertEqual(tree.text(f"{SERIAL}/bluetooth", "status"), "disabled")
                self.assertEqual(tree.text(SMALL_SERIAL, "status"), "disabled")
                self.assertIn(tree.text("/aliases", "serial0"), (None, SERIAL))

    def test_all_go_together(self):
        for suffix, (names, *_) in BOARDS.items():
            for name in names:
                asked = (f"camera-ov9281{suffix}", "pwm-gpio12-13", "uart-ttyAMA0")
                tree = overlaid(name, *asked)
                self.assertIsNotNone(tree, f"{name}: do not apply together")
                for overlay in asked:
                    self.assertTrue(tree.has("/ninedot-overlays", overlay), f"{name}: no mark of {overlay}")


class Said(unittest.TestCase):
    """What the board says at its start of lines that it can't do."""

    MODEL = "Raspberry Pi 4 Model B Rev 1.5"

    def said(self, lines, model=None, applied=()):
        model = model or self.MODEL
        with tempfile.TemporaryDirectory(dir=work) as place:
            fat, tree = os.path.join(place, "fat"), os.path.join(place, "tree")
            os.makedirs(fat)
            os.symlink(os.path.join(work, "overlays"), os.path.join(fat, "overlays"))
            os.makedirs(os.path.join(tree, "ninedot-overlays"))
            with open(os.path.join(fat, "config.txt"), "w", encoding="ascii", newline="") as file:
                file.write(lines)
            with open(os.path.join(tree, "model"), "w", encoding="ascii") as file:
                file.write(model + "\0")
            for name in applied:
                with open(os.path.join(tree, "ninedot-overlays", name), "w", encoding="ascii"):
                    pass
            done = subprocess.run(["sh", CHECK, fat, tree], capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, "")
            return done.stdout


class ConfigTxt(Said):
    def test_says_nothing_of_what_was_applied(self):
        self.assertEqual(self.said("dtoverlay=camera-ov9281\r\n dtoverlay=uart-ttyAMA0 \n", applied=("camera-ov9281", "uart-ttyAMA0")), "")
        self.assertEqual(self.said("#dtoverlay=camera-ov9821\narm_64bit=1\n"), "")

    def test_says_nothing_of_the_image_as_made(self):
        with open(os.path.join(ROOT, "systemd/image/config.txt"), encoding="ascii") as file:
            self.assertEqual(self.said(file.read()), "")

    def test_tells_a_wrong_name_with_those_that_there_are(self):
        said = self.said("dtoverlay=camera-ov9821\n")
        self.assertEqual(said.count("\n"), 1)
        self.assertIn("no overlay 'camera-ov9821'", said)
        for name in ("camera-ov9281", "pwm-gpio12-13", "uart-ttyAMA0"):
            self.assertIn(f" {name}", said)
        self.assertNotIn("-pi3", said)
        self.assertIn(" camera-ov9281-pi3", self.said("dtoverlay=camera-ov9821\n", model="Raspberry Pi 3 Model B Plus Rev 1.3"))

    def test_tells_another_boards_overlay_with_the_right_one(self):
        said = self.said("dtoverlay=camera-imx296-pi3\n", applied=("camera-imx296-pi3",))
        self.assertIn("'camera-imx296-pi3' is for another board", said)
        self.assertIn("dtoverlay=camera-imx296\n", said)
        self.assertIn("dtoverlay=camera-imx296-zero2\n", self.said("dtoverlay=camera-imx296\n", model="Raspberry Pi Zero 2 W Rev 1.0"))

    def test_tells_what_the_firmware_did_not_apply(self):
        self.assertIn("'camera-ov9281' was not applied", self.said("dtoverlay=camera-ov9281\n"))
        self.assertIn("'pwm-gpio12-13' was not applied", self.said("dtoverlay=pwm-gpio12-13,x=1\n", model="Raspberry Pi 3 Model B Rev 1.2"))

    def test_tells_two_that_exclude_each_other(self):
        both = ("camera-ov9281", "camera-imx296")
        self.assertIn("one camera", self.said("".join(f"dtoverlay={name}\n" for name in both), applied=both))
        both = ("pwm-gpio12-13", "pwm-gpio18-19")
        self.assertIn("one pwm", self.said("".join(f"dtoverlay={name}\n" for name in both), applied=both))

    def test_leaves_sections_of_other_boards_alone(self):
        self.assertEqual(self.said("[pi3]\ndtoverlay=camera-ov9281-pi3\n[all]\n"), "")
        self.assertIn("camera-ov9281-pi3", self.said("[pi3]\r\n[all]\r\ndtoverlay=camera-ov9281-pi3\r\n"))


def run(image, *which):
    """All tests of the program that asks for it, on the trees of the folder that it was given or of an image; which: as overlays.sh has it"""
    global trees, work
    with tempfile.TemporaryDirectory() as place:
        work = place
        subprocess.run([os.path.join(ROOT, "toolchains/overlays.sh"), os.path.join(work, "overlays"), *which], check=True)
        if trees is None:
            trees = os.path.join(work, "trees")
            os.mkdir(trees)
            subprocess.run(["mcopy", "-i", f"{image}@@4M", "::*.dtb", trees], check=True)
        return 0 if unittest.main(argv=sys.argv[:1], exit=False, verbosity=1).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(run(os.path.join(ROOT, "build/image/ninedot-arm64.img")))
