"""ninedotd with a head of two smart servos: it aims them, lets go of them, and nobody notices what happens to single answers."""

import os
import signal
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from dynamixel_bus import GOAL, LOAD, MODE, READ, SUPPLY, SYNC_READ, TEMPERATURE, TORQUE, WRITE, DynamixelBus
from service_harness import PATIENCE_S, Client, Service, config_text, free_port, int16, run

PAN, TILT = 3, 7
STEPS_PER_DEG = 4096 / 360
SERVO_FAULT = 1 << 12
HEAD_LOSSES, SERVO_SUPPLY = 99, 159
DONE = 2


def steps_of(pan_deg, tilt_deg):
    """The middle is straight ahead; tilt is the other way round."""
    return [2048 + pan_deg * STEPS_PER_DEG, 2048 - tilt_deg * STEPS_PER_DEG]


class ServiceServos(unittest.TestCase):
    def setUp(self):
        self.bus = self.enterContext(DynamixelBus(PAN, TILT))
        self.port = free_port()
        self.orders = 0

    def service(self, *, when_stopped="release", slew=300, gpio=""):
        head = f"""[modbus]
allow_writes = true
[pan_tilt]
driver = "dynamixel"
device = "{self.bus.device}"
baud = 1000000
when_stopped = "{when_stopped}"
follow = false
[pan_tilt.pan]
id = {PAN}
slew_deg_per_s = {slew}
[pan_tilt.tilt]
id = {TILT}
slew_deg_per_s = {slew}
direction = "reversed"
{gpio}
"""
        return Service(config_text(port=self.port, extra=head))

    def wait_until(self, condition, what):
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), deadline, what)
            time.sleep(0.01)

    def aim(self, client, pan_deg, tilt_deg):
        """Over Modbus; the head stands there at the end, in its registers and in truth."""
        self.orders += 1
        client.write(105, [round(100 * angle) & 0xFFFF for angle in (pan_deg, tilt_deg)])
        client.write(100, [2, self.orders])
        registers = client.wait_for(lambda registers: registers[102] == self.orders)
        self.unless_busy(lambda: self.assertEqual(registers[103], DONE))
        self.stands_at(client, pan_deg, tilt_deg)

    def unless_busy(self, check):
        """On a machine that kept an answer waiting, the service may have lost the head with good reason."""
        try:
            check()
        except AssertionError:
            if self.bus.was_quick():
                raise
            self.skipTest(f"too busy: an answer may have waited for {self.bus.slowest_s:.2f} s")

    def stands_at(self, client, pan_deg, tilt_deg):
        wanted = [round(steps) for steps in steps_of(pan_deg, tilt_deg)]
        self.wait_until(lambda: [round(at) for at in self.bus.positions()] == wanted, f"{self.bus.positions()}, not {wanted}")
        client.wait_for(lambda registers: all(abs(int16(registers, 37 + i) - 100 * angle) < 10
                                              for i, angle in enumerate((pan_deg, tilt_deg))))

    def test_it_aims_them_and_lets_go_at_the_end(self):
        with self.service() as service, Client(port=self.port) as client:
            service.wait_for_log("12.0 V, 31 degC, load 0 %")
            self.wait_until(lambda: client.read(SERVO_SUPPLY, 2) == [1200, 310], "servo_supply, servo_temperature")  # of the next frame
            with self.bus.lock:
                self.bus.memory[TILT][SUPPLY], self.bus.memory[PAN][TEMPERATURE] = 113, 57
                self.bus.memory[TILT][LOAD:LOAD + 2] = (-430).to_bytes(2, "little", signed=True)
            self.wait_until(lambda: client.read(SERVO_SUPPLY, 3) == [1130, 570, 430], "servo_supply, servo_temperature, servo_load")
            self.assertRegex(run("ninedot", "status", "--port", str(self.port)).stdout, r"servos +11\.3 V, 57 degC, load 43 %\n")
            self.wait_until(lambda: self.bus.has_torque() == [True, True], "no torque")
            self.aim(client, 10, -5)
            self.aim(client, -30.5, 20)
            aimed = run("ninedot", "aim", "--port", str(self.port), "--pan-deg", "15", "--tilt-deg", "7.5")
            self.assertEqual(aimed.returncode, 0, aimed.stderr)
            self.stands_at(client, 15, 7.5)
            self.assertEqual(self.bus.has_torque(), [True, True])
            self.assertEqual(service.end(signal.SIGTERM)[0], 0)
        self.assertEqual(self.bus.has_torque(), [False, False])
        self.assertEqual(dict(self.bus.goals), dict(zip((PAN, TILT), map(round, steps_of(15, 7.5)))))
        self.assertEqual(self.bus.unknown, [])

    def test_it_holds_them_at_the_end_where_it_shall(self):
        with self.service(when_stopped="hold") as service, Client(port=self.port) as client:
            self.aim(client, 10, -5)
            self.assertEqual(service.end(signal.SIGTERM)[0], 0)
        self.assertEqual(self.bus.has_torque(), [True, True])

    def test_it_takes_them_over_where_a_kill_left_them(self):
        with self.service() as service, Client(port=self.port) as client:
            self.aim(client, 20, 10)
            service.process.kill()
            service.process.wait()
        self.assertEqual(self.bus.has_torque(), [True, True])
        self.bus.goals.clear()
        with self.service(slew=10) as service, Client(port=self.port) as client:
            self.stands_at(client, 0, 0)
            self.assertEqual(service.end(signal.SIGTERM)[0], 0)
        first = [next(goal for servo, goal in self.bus.goals if servo == asked) for asked in (PAN, TILT)]
        for goal, left_at in zip(first, steps_of(20, 10)):
            self.assertLess(abs(goal - left_at), 5 * STEPS_PER_DEG, "a ramp begins there, half a second late at most")

    def test_an_inhibit_input_that_is_not_there_keeps_them_without_force(self):
        with self.service(gpio='[gpio]\ninhibit = "x"') as service, Client(port=self.port) as client:
            service.wait_for_log("the inhibit input is active")
            client.write(105, [1000, 500])
            client.write(100, [2, 1])
            client.wait_for(lambda registers: registers[102] == 1)
            time.sleep(0.5)
            self.assertEqual(service.end()[0], 0)
        self.assertEqual((self.bus.has_torque(), self.bus.goals), ([False, False], []))

    def test_a_single_answer_that_is_lost_comes_twice_or_late_is_let_pass(self):
        with self.service() as service, Client(port=self.port) as client:
            self.aim(client, 0, 0)
            told = service.log_text()
            for number, (kind, (instruction, address)) in enumerate(
                    (kind, what) for kind in ("lost", "twice", "late") for what in ((SYNC_READ, GOAL), (READ, TORQUE))):
                for servo in (PAN, TILT):
                    with self.subTest(kind=kind, address=address, servo=servo):
                        self.bus.spoil(kind, instruction, address, servo)
                        self.wait_until(self.bus.is_spoilt, "such an answer is never given")
                        self.aim(client, 5 + number, servo)
            registers = client.read()
            self.unless_busy(lambda: self.assertEqual((registers[4] & SERVO_FAULT, registers[HEAD_LOSSES]), (0, 0)))
            self.assertEqual(service.log_text(), told)
            self.assertEqual(self.bus.has_torque(), [True, True])
            # Of what ends the force as well.
            for fault in (("lost", WRITE, TORQUE, PAN), ("late", READ, TORQUE, PAN),
                          ("late", WRITE, TORQUE, TILT), ("lost", READ, TORQUE, TILT)):
                self.bus.spoil(*fault)
            self.assertEqual(service.end(signal.SIGTERM)[0], 0)
        self.assertEqual((self.bus.has_torque(), self.bus.faults, self.bus.unknown), ([False, False], [], []))

    def test_answers_that_come_when_their_port_was_opened_anew_are_not_believed(self):
        with self.service() as service, Client(port=self.port) as client:
            self.aim(client, 12, -8)
            self.bus.torques.clear()
            self.bus.stall((READ, TORQUE, PAN), until=MODE)
            client.wait_for(lambda registers: registers[HEAD_LOSSES] >= 1)
            client.wait_for(lambda registers: not registers[4] & SERVO_FAULT)
            self.assertTrue(self.bus.is_spoilt())
            self.stands_at(client, 12, -8)
            self.aim(client, -12, 8)
            self.assertNotIn("operating mode", service.log_text())
            losses, torques = client.read()[HEAD_LOSSES], [torque for _, torque in self.bus.torques]
            self.unless_busy(lambda: self.assertEqual((losses, torques.count(0)), (1, 0), "it was under force all the time"))
            self.assertEqual(service.end()[0], 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
