#!/usr/bin/python3
"""The overlays of the Raspberry Pi 5's image, laid over the device trees of that board that backports' kernel has; and what the board says of a line of
config.txt that can't be done.

    tests/board/overlays_pi5_test.py [FOLDER]     FOLDER: where the board's *.dtb are; default: those of build/image-pi5/ninedot-arm64-pi5.img

Needs device-tree-compiler, and mtools for the default. No kernel is started.
"""

import os
import sys
import unittest

import overlays_test
from overlays_test import ROOT, SENSORS, overlaid

TREES = ("bcm2712-rpi-5-b", "bcm2712-d-rpi-5-b")  # of the chip's two steppings
RP1 = "/axi/pcie@1000120000/pci@0,0/dev@0,0/pci-ep-bus@1"
GPIO = f"{RP1}/pinctrl@400d0000"
# Suffix of the overlay's name: I2C bus, its pins, receiver, line of the camera's power switch.
CONNECTORS = {
    "-pi5": (f"{RP1}/i2c@40080000", f"{GPIO}/rp1-i2c4-default-state", f"{RP1}/csi@40128000", 46),
    "-pi5-cam0": (f"{RP1}/i2c@40088000", f"{GPIO}/rp1-i2c6-default-state", f"{RP1}/csi@40110000", 34),
}


class Cameras(unittest.TestCase):
    def test_each_sensor_on_each_connector(self):
        for sensor in SENSORS:
            for suffix in CONNECTORS:
                for name in TREES:
                    with self.subTest(overlay=f"camera-{sensor}{suffix}", tree=name):
                        tree = overlaid(name, f"camera-{sensor}{suffix}")
                        self.assertIsNotNone(tree, "does not apply")
                        self.check(tree, sensor, *CONNECTORS[suffix])

    def check(self, tree, sensor, bus, pins, receiver, line):
        compatible, address, clock_hz, lanes, link_hz, supplies = SENSORS[sensor]
        node = f"{bus}/camera@{address:x}"
        here, there, switch = f"{node}/port/endpoint", f"{receiver}/port/endpoint", "/ninedot-camera-power"
        self.assertEqual((tree.text(receiver, "compatible"), tree.text(receiver, "status")), ("raspberrypi,rp1-cfe", "okay"))
        self.assertEqual((tree.text(node, "compatible"), tree.numbers(node, "reg")), (compatible, [address]))
        self.assertIsNotNone(tree.phandle(here))
        self.assertEqual(tree.numbers(here, "remote-endpoint"), [tree.phandle(there)])
        self.assertEqual(tree.numbers(there, "remote-endpoint"), [tree.phandle(here)])
        for end in (here, there):
            self.assertEqual(tree.numbers(end, "data-lanes"), lanes)
        self.assertEqual(tree.has(here, "clock-noncontinuous"), tree.has(there, "clock-noncontinuous"))
        self.assertEqual(tree.numbers(node, "clocks"), [tree.phandle("/ninedot-camera-clock")])
        self.assertEqual(tree.numbers("/ninedot-camera-clock", "clock-frequency"), [clock_hz])
        if link_hz:
            self.assertEqual(tree.numbers(here, "link-frequencies"), [link_hz >> 32, link_hz & 0xFFFFFFFF])
        for supply in supplies:
            self.assertEqual(tree.numbers(node, f"{supply}-supply"), [tree.phandle(switch)])
        self.assertEqual(tree.text(bus, "status"), "okay")
        self.assertEqual((tree.numbers(bus, "#address-cells"), tree.numbers(bus, "#size-cells")), ([1], [0]))
        self.assertEqual(tree.numbers(bus, "pinctrl-0"), [tree.phandle(pins)])
        self.assertEqual(tree.numbers(switch, "gpio"), [tree.phandle(GPIO), line, 0])
        self.assertTrue(tree.has(switch, "enable-active-high"))

    def test_without_an_overlay_nothing_is_on(self):
        for name in TREES:
            for bus, _, receiver, _ in CONNECTORS.values():
                for node in (bus, receiver):
                    self.assertEqual(overlays_test.board(name).text(node, "status"), "disabled")


class Pins(unittest.TestCase):
    def test_i2c_goes_with_a_camera(self):
        for name in TREES:
            tree = overlaid(name, "camera-ov9281-pi5", "i2c-gpio2-3")
            self.assertIsNotNone(tree, "do not apply together")
            bus, pins = f"{RP1}/i2c@40074000", f"{GPIO}/ninedot-i2c-pins"
            self.assertEqual(tree.text(bus, "status"), "okay")
            self.assertEqual(tree.numbers(bus, "pinctrl-0"), [tree.phandle(pins)])
            self.assertEqual((tree.text(pins, "function"), tree.text(pins, "groups")), ("i2c1", "i2c1_0"))
            for overlay in ("camera-ov9281-pi5", "i2c-gpio2-3"):
                self.assertTrue(tree.has("/ninedot-overlays", overlay), f"no mark of {overlay}")


class ConfigTxt(overlays_test.Said):
    MODEL = "Raspberry Pi 5 Model B Rev 1.0"

    def test_says_nothing_of_the_image_as_made(self):
        with open(os.path.join(ROOT, "systemd/image/config-pi5.txt"), encoding="ascii") as file:
            self.assertEqual(self.said(file.read()), "")

    def test_says_nothing_of_what_was_applied(self):
        for name in ("camera-ov9281-pi5", "camera-ov9281-pi5-cam0", "i2c-gpio2-3"):
            self.assertEqual(self.said(f"dtoverlay={name}\r\n", applied=(name,)), "")

    def test_tells_a_wrong_name_with_those_that_there_are(self):
        said = self.said("dtoverlay=camera-ov9281\n")
        self.assertIn("no overlay 'camera-ov9281'", said)
        for name in ("camera-ov9281-pi5", "camera-imx296-pi5-cam0", "i2c-gpio2-3"):
            self.assertIn(f" {name}", said)

    def test_tells_another_boards_overlay_with_the_right_one(self):
        said = self.said("dtoverlay=camera-ov9281-pi5-cam0\n", model="Raspberry Pi 4 Model B Rev 1.5", applied=("camera-ov9281-pi5-cam0",))
        self.assertIn("write dtoverlay=camera-ov9281\n", said)

    def test_tells_two_cameras(self):
        both = ("camera-ov9281-pi5", "camera-imx296-pi5-cam0")
        self.assertIn("one camera", self.said("".join(f"dtoverlay={name}\n" for name in both), applied=both))


if __name__ == "__main__":
    sys.exit(overlays_test.run(os.path.join(ROOT, "build/image-pi5/ninedot-arm64-pi5.img"), "pi5"))
