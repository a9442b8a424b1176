"""ninedotd and the devices that are missing, come, and go; and `ninedot check` beside it."""

import os
import shutil
import socket
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from service_harness import APPROACH, BIN, PATIENCE_S, Client, Service, config_text, free_port, int16, run, serial_line

VALID = 1 << 0


class WaitingForDevices(unittest.TestCase):
    """A device that is not there ends nothing: the service answers, says what it waits for, and takes it when it comes."""

    def test_every_kind_of_device_may_be_missing(self):
        for extra, words in (('[pan_tilt]\ndriver = "sysfs-pwm"\npan.chip = "x"\ntilt.chip = "x"', "PWM chip 'x'"),
                             ('[pan_tilt]\ndriver = "gpio"\npan.line = "x"\ntilt.line = "y"', "GPIO line 'x'"),
                             ('[pan_tilt]\ndriver = "visca"\ndevice = "/dev/x"', "/dev/x: there is no such serial port"),
                             ('[gpio]\ninhibit = "x"', "inhibit input: not there, waits for it: GPIO line 'x'"),
                             ('[gpio]\nservo_power = "x"', "servo power: not there, waits for it: GPIO line 'x'"),
                             ('[gpio]\nstatus_led = "x"', "status LED: not there, waits for it: GPIO line 'x'")):
            port = free_port()
            config = config_text(port=port, extra=extra)
            with Service(config) as service, Client(port=port) as client:
                client.wait_for(lambda registers: registers[4] & VALID)
                service.wait_for_log(words)
                checked = run("ninedot", "check", "--config", service.config)
                self.assertEqual(checked.returncode, 0, checked.stderr)
                self.assertIn("in use by a running ninedotd", checked.stdout)
                self.assertEqual(service.end()[0], 0)

    def test_a_camera_that_is_missing(self):
        port = free_port()
        config = config_text(port=port).replace('source = "recording"', 'source = "v4l2"').replace(
            f'device = "{APPROACH}"', f'device = "/dev/does-not-exist"\ncalibration = "{APPROACH}/camera.yaml"')
        with Service(config) as service, Client(port=port) as client:
            client.wait_for(lambda registers: registers[5] == 4)
            service.wait_for_log("camera: waits for it: /dev/does-not-exist: no such camera")
            time.sleep(1.5)  # a second line would have come by now
            self.assertEqual(service.end()[0], 0)
            told = [line for line in service.log_text().splitlines() if "camera" in line]
            self.assertEqual(len(told), 1, told)

    def test_a_missing_inhibit_line_keeps_the_head_where_it_is(self):
        port = free_port()
        extra = '[modbus]\nallow_writes = true\n[pan_tilt]\ndriver = "simulated"\n[gpio]\ninhibit = "x"'
        with Service(config_text(port=port, extra=extra)) as service, Client(port=port) as client:
            client.wait_for(lambda registers: registers[4] & VALID)
            client.write(105, [1000, 500])
            client.write(100, [2, 77])
            time.sleep(0.5)
            registers = client.read()
            self.assertEqual((int16(registers, 37), int16(registers, 38)), (0, 0))
            service.wait_for_log("pan/tilt: not there, waits for it: the inhibit input is active")

    def test_a_serial_line_comes_late_goes_and_comes_back_and_leaves_a_line_each(self):
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as folder:
            name = os.path.join(folder, "tty")
            with Service(config_text(rtu_device=name)) as service:
                service.wait_for_log(f"Modbus RTU: not there, waits for it: {name}: No such file or directory")
                for there in (1, 2):
                    with serial_line() as (service_end, client_end):
                        os.symlink(os.path.realpath(service_end), name)
                        with Client(device=client_end, unit=7) as client:
                            deadline = time.monotonic() + PATIENCE_S
                            while True:
                                try:
                                    self.assertEqual(client.read(count=1), [0x9D09])
                                    break
                                except Exception:
                                    if time.monotonic() > deadline:
                                        raise
                        self.wait_for_count(service, "Modbus RTU: there", there)
                        os.unlink(name)
                    self.wait_for_count(service, f"Modbus RTU: gone, waits for it: {name}", there)
                self.assertEqual(service.end()[0], 0)
                self.assertEqual(service.log_text().count("Modbus RTU:"), 5, service.log_text())

    def wait_for_count(self, service, text, count):
        deadline = time.monotonic() + PATIENCE_S
        while service.log_text().count(text) < count:
            self.assertLess(time.monotonic(), deadline, service.log_text())
            time.sleep(0.02)


class CheckBesideARunningService(unittest.TestCase):
    """The service is known by its socket: it may keep this machine's clients out."""

    def checked(self, service, program="ninedot", **options):
        result = run(program, "check", "--config", service.config, **options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_that_refuses_this_machine(self):
        for extra in ('allow = ["192.0.2.1"]\n', "max_clients = 1\n"):
            port = free_port()
            with Service(config_text(port=port) + extra) as service:
                service.wait_for_log("found at")
                with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S):
                    self.assertIn(f"note: 127.0.0.1 port {port} is in use by a running ninedotd", self.checked(service))

    @unittest.skipUnless(os.geteuid() == 0, "only root may be somebody else")
    def test_as_a_user_who_may_not_see_its_sockets(self):
        port = free_port()
        # What that user needs lies where it may read, wherever this tree lies.
        with tempfile.TemporaryDirectory(prefix="ninedot-test-") as readable:
            os.chmod(readable, 0o755)
            program = shutil.copy(BIN / "ninedot", readable)
            recording = shutil.copytree(APPROACH, os.path.join(readable, "approach"))
            with Service(config_text(recording, port=port)) as service:
                service.wait_for_log("found at")
                for path in (service.config, service.config.parent):
                    path.chmod(0o755)
                self.assertIn(f"port {port} is in use; a ninedotd is running, which may be what has it: root sees whether it is",
                              self.checked(service, program, user="nobody"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
