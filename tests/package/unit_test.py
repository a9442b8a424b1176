"""The systemd unit does what docs/service.md says of it: a service that fails is started again for ever, and a missing device fails nothing."""

import os
import pathlib
import re
import shlex
import shutil
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

    def test_it_may_use_every_kind_of_device_that_a_configuration_can_name(self):
        allowed = {value for _, key, value in self.settings if key == "DeviceAllow"}
        kinds = ["video4linux", "media", "dma_heap", "gpiochip", "i2c"]
        # Names of serial lines in Linux 6.12: dev_name of the drivers in drivers/tty/serial and drivers/usb.
        kinds += [f"tty{name}" for name in ("S", "AMA", "mxc", "SC", "STM", "THS", "LP", "RPMSG", "USB", "ACM")]
        self.assertEqual({f"char-{kind} rw" for kind in kinds} - allowed, set())
        self.assertEqual(self.value("Service", "DevicePolicy"), "closed")
        groups = self.value("Service", "SupplementaryGroups").split()
        self.assertEqual({"video", "gpio", "dialout", "i2c"} - set(groups), set())

    def test_kinds_of_devices_that_are_modules_are_known_before_anything_is_plugged_in(self):
        # systemd looks a kind's number up once, when the service starts; the other kinds are in every kernel that has their hardware.
        for module in ("videodev", "usbserial", "cdc_acm", "i2c_dev"):
            for key in ("After", "Wants"):
                self.assertIn(f"modprobe@{module}.service", " ".join(v for _, k, v in self.settings if k == key).split())

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


class PageUnit(unittest.TestCase):
    """ninedot-web.service: as strict as the service's own, and more."""

    # What the page is allowed beyond nothing, or is a matter of taste.
    OTHERWISE = {"ReadWritePaths", "DeviceAllow", "SupplementaryGroups", "User", "Group", "ExecStart", "ExecStartPre", "ExecReload", "WatchdogSec",
                 "LimitMEMLOCK", "LimitRTPRIO", "MemoryMax", "TasksMax", "OOMScoreAdjust", "RestrictAddressFamilies", "SystemCallFilter"}

    def setUp(self):
        self.page = settings((SOURCE / "systemd" / "ninedot-web.service").read_text())
        self.service = settings((SOURCE / "systemd" / "ninedotd.service").read_text())

    def values(self, of, key):
        return [value for section, k, value in of if (section, k) == ("Service", key)]

    def test_keeps_every_restriction_of_the_service(self):
        for section, key, value in self.service:
            if section == "Service" and key not in self.OTHERWISE:
                self.assertIn(value, self.values(self.page, key), f"{key}= of ninedotd.service")

    def test_may_do_less_than_the_service(self):
        self.assertEqual(self.values(self.page, "DeviceAllow") + self.values(self.page, "ReadWritePaths"), [])
        # Its recordings, and nothing else on the disk.
        self.assertEqual([self.values(self.page, f"{kind}Directory") for kind in ("State", "Cache", "Logs", "Configuration", "Runtime")], [["ninedot-web"], [], [], [], []])
        families = [set(self.values(of, "RestrictAddressFamilies")[0].split()) for of in (self.page, self.service)]
        self.assertLess(families[0], families[1])
        allowed = [[calls for calls in self.values(of, "SystemCallFilter")] for of in (self.page, self.service)]
        self.assertEqual(allowed[0], allowed[1][:2], "without the calls that real time needs")
        self.assertEqual(self.values(self.page, "SupplementaryGroups"), ["ninedot-tap"])
        self.assertEqual(self.values(self.page, "RestrictRealtime"), ["yes"])
        self.assertEqual(self.values(self.page, "PrivateUsers"), ["yes"])

    def test_is_another_user_that_nobody_but_the_tap_knows(self):
        self.assertNotEqual(self.values(self.page, "User"), self.values(self.service, "User"))
        groups = [line.split()[2] for line in (SOURCE / "systemd" / "ninedot-web.sysusers").read_text().splitlines() if line.startswith("m ninedot-web")]
        self.assertEqual(groups, ["ninedot-tap"])

    def test_is_not_enabled_by_its_package(self):
        script = (SOURCE / "systemd" / "package-web" / "postinst").read_text()
        self.assertRegex(script, r"if deb-systemd-helper --quiet was-enabled ninedot-web.service; then\s+deb-systemd-helper enable")
        self.assertEqual(script.count("deb-systemd-helper enable"), 1)
        self.assertIn("if deb-systemd-helper debian-installed ninedot-web.service; then", script)


class ApplyUnits(unittest.TestCase):
    """ninedot-apply.socket and ninedot-apply@.service: root behind a door that is shut until somebody opens it."""

    def setUp(self):
        self.socket = settings((SOURCE / "systemd" / "ninedot-apply.socket").read_text())
        self.service = settings((SOURCE / "systemd" / "ninedot-apply@.service").read_text())

    def value(self, of, key):
        values = [value for _, k, value in of if k == key]
        self.assertEqual(len(values), 1, f"{key}=")
        return values[0]

    def test_the_door_is_for_the_page_alone_and_for_one_at_a_time(self):
        wanted = {"SocketUser": "root", "SocketGroup": "ninedot-web", "SocketMode": "0660", "Accept": "yes", "MaxConnections": "1"}
        self.assertEqual({key: self.value(self.socket, key) for key in wanted}, wanted)

    def test_the_page_knocks_where_it_is(self):
        listens = self.value(self.socket, "ListenStream")
        told = subprocess.run([BIN / "ninedot-web", "--help"], capture_output=True, text=True, timeout=60).stdout
        self.assertIn(listens, told)
        self.assertIn("AF_UNIX", self.value(settings((SOURCE / "systemd" / "ninedot-web.service").read_text()), "RestrictAddressFamilies"))

    def test_all_that_is_running_is_out_of_reach_for_all_of_them(self):
        for unit in ("ninedotd.service", "ninedot-web.service", "ninedot-apply@.service"):
            self.assertEqual(self.value(settings((SOURCE / "systemd" / unit).read_text()), "ReadOnlyPaths"), "/run", unit)

    def test_it_reads_what_it_is_sent_with_the_rights_of_the_service_and_writes_one_folder(self):
        command = shlex.split(self.value(self.service, "ExecStart"))
        user = self.value(settings((SOURCE / "systemd" / "ninedotd.service").read_text()), "User")
        self.assertEqual(command, ["/usr/bin/ninedot", "apply", "--page", "--config", "/etc/ninedot/ninedot.toml", "--check-as", user])
        self.assertEqual(self.value(self.service, "ReadWritePaths"), "/etc/ninedot")
        self.assertEqual(self.value(self.service, "ProtectSystem"), "strict")
        self.assertNotIn("CAP_DAC_OVERRIDE", self.value(self.service, "CapabilityBoundingSet"))
        self.assertEqual(self.value(self.service, "StandardInput"), "socket")
        self.assertEqual(self.value(self.service, "StandardOutput"), "socket")

    def test_nothing_enables_it(self):
        for script in (SOURCE / "systemd" / "package-web").iterdir():
            self.assertNotRegex(script.read_text(), r"\benable ninedot-apply", script.name)

    def test_systemd_accepts_them_and_calls_them_tight(self):
        if not shutil.which("systemd-analyze"):
            self.skipTest("no systemd-analyze")
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            for name, instance in (("ninedot-apply.socket",) * 2, ("ninedot-apply@.service",) * 2, ("ninedot-apply@.service", "ninedot-apply-once.service")):
                text = (SOURCE / "systemd" / name).read_text().replace("/usr/bin/ninedot", "/bin/true")
                (pathlib.Path(folder) / instance).write_text(text)
            verified = subprocess.run(["systemd-analyze", "verify", f"{folder}/ninedot-apply.socket"], capture_output=True, text=True, timeout=60)
            self.assertEqual((verified.returncode, verified.stdout + verified.stderr), (0, ""))
            told = subprocess.run(["systemd-analyze", "security", "--offline=true", "--no-pager", f"{folder}/ninedot-apply-once.service"], capture_output=True, text=True, timeout=60)
        exposure = re.search(r"exposure level for \S+: ([\d.]+)", told.stdout)
        self.assertTrue(exposure, told.stdout + told.stderr)
        self.assertLessEqual(float(exposure[1]), 2.6)


if __name__ == "__main__":
    unittest.main(verbosity=2)
