"""What ninedotd and its commands say when something is wrong: a line each, and the right exit status."""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import APPROACH, BIN, PATIENCE_S, Client, Service, config_text, free_port, run

VALID = 1 << 0


class StandardOutputThatIsFull(unittest.TestCase):
    def test_fails_every_command_in_one_line(self):
        port = free_port()
        head = '[modbus]\nallow_writes = true\n[pan_tilt]\ndriver = "simulated"\n'
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder, \
                Service(config_text(port=port, extra=f'{head}[tap]\nenabled = true\npath = "{folder}/tap"\n')) as service, \
                Client(port=port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            at = ("--port", str(port))
            commands = [("--help",), ("--version",), ("registers",), ("registers", "--format", "csv"),
                        ("registers", "--format", "json"), ("replay", APPROACH), ("cameras",),
                        ("record", "--config", service.config, "--out", f"{folder}/recording", "--frames", "2"),
                        ("pattern", "--out", f"{folder}/landmark.svg"), ("check", "--config", service.config),
                        ("status", *at), ("status", "--json", *at), ("status", "--watch", *at),
                        ("status", "--watch", "--json", *at), ("aim", "--follow", *at), ("aim", "--pan-deg", "5", *at),
                        ("tap", "--path", f"{folder}/tap"), ("tap", "--path", f"{folder}/tap", "--out", f"{folder}/now.png"),
                        ("tap", "--path", f"{folder}/tap", "--record", f"{folder}/tapped")]
            known = re.findall(r"^  (\w+) ", run("ninedot", "--help").stdout.split("Subcommands:")[1], re.M)
            self.assertGreater(len(known), 5)
            # These write files, and what they tell goes to standard error; what `apply` has begun it brings to its end, whoever listens.
            self.assertEqual(set(known) - {"map", "calibrate", "simulate", "apply"}, {command[0] for command in commands} - {"--help", "--version"})
            for command in commands:
                with self.subTest(command), open("/dev/full", "w") as full:
                    result = subprocess.run([BIN / "ninedot", *command], stdin=subprocess.DEVNULL, stdout=full,
                                            stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S)
                    self.assertEqual(result.returncode, 1, result.stderr)
                    self.assertRegex(result.stderr, r"\Aninedot: .*standard output.*\n\Z")


class Watching(unittest.TestCase):
    def test_outlives_a_restart_of_the_service_and_says_once_that_it_was_lost(self):
        for options in ((), ("--json",)):
            port = free_port()
            with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
                out, errors = pathlib.Path(folder) / "out", pathlib.Path(folder) / "errors"

                def wait(condition):
                    deadline = time.monotonic() + PATIENCE_S
                    while not condition():
                        self.assertIsNone(watch.poll(), errors.read_text())
                        self.assertLess(time.monotonic(), deadline, out.read_text() + errors.read_text())
                        time.sleep(0.05)

                with out.open("w") as stdout, errors.open("w") as stderr:
                    with Service(config_text(port=port)) as service:
                        service.wait_for_log("found at")
                        watch = subprocess.Popen([BIN / "ninedot", "status", "--watch", "--port", str(port), *options],
                                                 stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr)
                        wait(lambda: out.read_text().count("\n") >= 1)
                        service.end()
                    wait(lambda: "lost" in errors.read_text())
                    time.sleep(2.5)
                    lines = out.read_text().count("\n")
                    with Service(config_text(port=port)):
                        wait(lambda: out.read_text().count("\n") >= lines + 2)
                        watch.send_signal(signal.SIGINT)
                        self.assertEqual(watch.wait(PATIENCE_S), 0)
                self.assertRegex(errors.read_text(), rf"\Aninedot: 127.0.0.1 port {port}: lost the service.*\n\Z")


class LogOfTheModbusServers(unittest.TestCase):
    def test_a_flood_of_refused_clients_leaves_one_line(self):
        port = free_port()
        config = config_text(port=port) + 'allow = ["192.0.2.1"]\n'
        with Service(config) as service:
            service.wait_for_log("found at")
            for _ in range(200):
                with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as client:
                    client.settimeout(PATIENCE_S)
                    try:
                        self.assertEqual(client.recv(1), b"")
                    except ConnectionResetError:
                        pass
            service.wait_for_log("Modbus clients refused")
            service.end()
            log = service.log_text()
        self.assertEqual(log.count("Modbus clients refused"), 1, log)
        self.assertRegex(log, r"Modbus clients refused: (the last one )?127\.0\.0\.1:\d+ is not on the list `allow`")

    def test_a_client_without_a_place_and_an_unreadable_frame_leave_a_line(self):
        port = free_port()
        config = config_text(port=port) + "max_clients = 1\n"
        with Service(config) as service, Client(port=port) as client:
            client.read(count=1)
            with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as other:
                service.wait_for_log("found no place: all of `max_clients` are taken")
            client.client.close()
            time.sleep(0.2)
            with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as other:
                other.sendall(b"GET / HTTP/1.1\r\n\r\n")
                service.wait_for_log("1 unreadable Modbus frames")


class RefusingToStart(unittest.TestCase):
    def refused(self, config, status, *words):
        with Service(config) as service:
            out, _ = service.process.communicate(timeout=PATIENCE_S)
            log = service.log_text()
            self.assertEqual(service.process.returncode, status, log)
        self.assertEqual(out, "")
        last = log.splitlines()[-1]
        self.assertTrue(last.startswith("ninedotd: "), last)
        for word in words:
            self.assertIn(word, last)

    def test_a_port_in_use(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            self.refused(config_text(port=port), 1, str(port))

    def test_a_serial_device_that_is_none(self):
        self.refused(config_text(rtu_device="/dev/null"), 2, "/dev/null", "no serial line")

    def test_one_port_by_two_names(self):
        main, line = os.openpty()
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            other_name = os.path.join(folder, "by-id")
            os.symlink(os.ttyname(line), other_name)
            head = f'[pan_tilt]\ndriver = "visca"\ndevice = "{other_name}"\n'
            self.refused(config_text(rtu_device=os.ttyname(line), extra=head), 2, other_name, "are one port")
        os.close(main)
        os.close(line)

    def test_a_recording_that_does_not_exist(self):
        self.refused(config_text("/does/not/exist", port=free_port()), 1, "/does/not/exist")

    def test_a_recording_without_pictures(self):
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            (pathlib.Path(folder) / "frames").mkdir()
            shutil.copy(APPROACH / "camera.yaml", folder)
            self.refused(config_text(folder, port=free_port()), 1, folder)

    def test_a_calibration_of_another_size(self):
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            text = (APPROACH / "camera.yaml").read_text()
            other = pathlib.Path(folder) / "camera.yaml"
            other.write_text(re.sub(r"image_width: *\d+", "image_width: 1280", text))
            config = config_text(port=free_port()).replace("[pose]", f'calibration = "{other}"\n[pose]')
            self.refused(config, 2, "1280")

    def test_a_key_that_does_not_exist(self):
        self.refused(config_text(extra="speed = 3"), 2, "speed", ":")

    def test_a_configuration_that_does_not_exist(self):
        result = run("ninedotd", "--config", "/does/not/exist.toml")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_wrong_usage(self):
        for arguments in ((), ("--config",), ("--no-such-option",)):
            result = run("ninedotd", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_an_angle_that_is_no_number(self):
        for arguments in (("--pan-deg", "nan"), ("--tilt-deg", "nan"), ("--pan-deg", "inf"), ("--tilt-deg=-inf",),
                          ("--follow", "--wait-s", "nan")):
            result = run("ninedot", "aim", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn(arguments[-1].split("=")[-1], result.stderr)

    def test_status_where_nothing_listens(self):
        result = run("ninedot", "status", "--port", str(free_port()))
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
