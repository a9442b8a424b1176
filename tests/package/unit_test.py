"""The systemd unit does what docs/service.md says of it: a service that fails is started again for ever, and a missing device fails nothing."""

import os
import pathlib
import re
import shlex
import socket
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["NINEDOT_SOURCE_DIR"])
BIN = pathlib.Path(os.environ["NINEDOT_BIN_DIR"])
CALIBRATION = SOURCE / "tests" / "recordings" / "approach" / "camera.yaml"

EVERY_DEVICE_MISSING = f"""
[camera]
source = "v4l2"
device = "/dev/video-of-tomorrow"
calibration = "{CALIBRATION}"
[pan_tilt]
driver = "visca"
device = "/dev/tty-of-tomorrow"
[gpio]
servo_power = "of-tomorrow:1"
status_led = "of-tomorrow:2"
inhibit = "of-tomorrow:3"
[modbus.rtu]
device = "/dev/tty-of-the-day-after"
"""


def settings(text):
    """[(section, key, value)], repeated keys and all."""
    section, found = None, []
    for line in text.splitlines():
        if header := re.fullmatch(r"\[(\w+)\]", line):
            section = header[1]
        elif line and not line.startswith("#"):
            key, _, value = line.partition("=")
            found.append((section, key, value))
    return found


class Unit(unittest.TestCase):
    def setUp(self):
        self.settings = settings((SOURCE / "systemd" / "ninedotd.service").read_text())

    def value(self, section, key):
        values = [value for s, k, value in self.settings if (s, k) == (section, key)]
        self.assertEqual(len(values), 1, f"{key}= of [{section}]")
        return values[0]

    def pre_start(self, config):
        command = shlex.split(self.value("Service", "ExecStartPre"))
        self.assertEqual(command[0], "/usr/bin/ninedot")
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            path = pathlib.Path(folder) / "ninedot.toml"
            path.write_text(config)
            command = [str(BIN / "ninedot")] + [str(path) if word == "/etc/ninedot/ninedot.toml" else word for word in command[1:]]
            self.assertIn(str(path), command)
            return subprocess.run(command, capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)

    def test_no_number_of_failures_ends_it_for_good(self):
        self.assertEqual(self.value("Service", "Restart"), "always")
        self.assertEqual(self.value("Unit", "StartLimitIntervalSec"), "0")
        self.assertTrue(1 <= int(self.value("Service", "RestartSec")) <= 10, "soon, and not so often that the journal fills")

    def test_debian_12_knows_all_of_it(self):
        for _, key, _ in self.settings:
            self.assertNotIn(key, ("RestartSteps", "RestartMaxDelaySec"), "systemd has it from 254 on; Debian 12 has 252")

    def test_a_reload_checks_the_file_and_then_sends_the_signal_that_reads_the_map(self):
        commands = [value for _, key, value in self.settings if key == "ExecReload"]
        self.assertEqual(commands, [self.value("Service", "ExecStartPre"), "/bin/kill -HUP $MAINPID"])

    def test_the_check_before_the_start_waits_for_no_device(self):
        checked = self.pre_start(EVERY_DEVICE_MISSING)
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_the_check_before_the_start_looks_at_the_file_alone(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            config = EVERY_DEVICE_MISSING.replace(str(CALIBRATION), "/nowhere/camera.yaml")
            checked = self.pre_start(f"{config}[modbus.tcp]\nport = {taken.getsockname()[1]}\n")
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_the_check_before_the_start_says_what_is_wrong_with_the_file(self):
        checked = self.pre_start(EVERY_DEVICE_MISSING + "bauds = 9600\n")
        self.assertEqual(checked.returncode, 2)
        self.assertRegex(checked.stderr, r"ninedot\.toml:\d+: unknown key 'bauds'")


if __name__ == "__main__":
    unittest.main(verbosity=2)
