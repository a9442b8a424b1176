"""Servos that speak Robotis Dynamixel protocol 2.0 at the far end of a serial line, with single faults of their answers on request.

Addresses, packets and their check sum as in Robotis' e-Manual: XL430-W250, "Control Table", and "DYNAMIXEL Protocol 2.0"."""

import os
import select
import threading
import time
import tty
from collections import namedtuple

MODE, TORQUE, GOAL, LOAD, POSITION, SUPPLY, TEMPERATURE = 11, 64, 116, 126, 132, 144, 146
READ, WRITE, STATUS, SYNC_READ, SYNC_WRITE = 0x02, 0x03, 0x55, 0x82, 0x83
HEADER = b"\xff\xff\xfd\x00"
STEPS_PER_S = 4000  # of both; faster than they are told to go

Fault = namedtuple("Fault", "kind instruction address id")


def crc(data):
    rest = 0
    for byte in data:
        rest ^= byte << 8
        for _ in range(8):
            rest = (rest << 1 ^ (0x8005 if rest & 0x8000 else 0)) & 0xFFFF
    return rest.to_bytes(2, "little")


class DynamixelBus:
    """Faults: `lost`; `twice`; `late`: comes when the next packet has been heard, before what that one is answered."""

    def __init__(self, *ids):
        self.line, self.other = os.openpty()  # the other end is held open, so that a service that goes is no hang-up
        tty.setraw(self.other)
        self.device = os.ttyname(self.other)
        self.lock = threading.Lock()
        self.memory = {servo: bytearray(256) for servo in ids}
        self.at = dict.fromkeys(ids, 2048.0)
        self.goals, self.torques, self.unknown = [], [], []
        self.faults, self.held, self.holds_until = [], [], None
        for memory in self.memory.values():
            memory[MODE] = 3
            memory[SUPPLY], memory[TEMPERATURE] = 120, 31
            memory[GOAL:GOAL + 4] = (2048).to_bytes(4, "little")
        self.ends, self.slowest_s = False, 0.0
        self.thread = threading.Thread(target=self.serve)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *exception):
        self.ends = True
        self.thread.join()
        os.close(self.line)
        os.close(self.other)

    def has_torque(self):
        """\\return  of each servo, in the order of their IDs"""
        with self.lock:
            return [self.memory[servo][TORQUE] == 1 for servo in sorted(self.memory)]

    def positions(self):
        with self.lock:
            return [self.at[servo] for servo in sorted(self.at)]

    def number(self, servo, address, size):
        return int.from_bytes(self.memory[servo][address:address + size], "little")

    def spoil(self, *fault):
        """The next such answer, once."""
        with self.lock:
            self.faults.append(Fault(*fault))

    def stall(self, fault, until):
        """From such an answer on all stay on the way, until somebody asks for the address `until`; then they come, one by one."""
        with self.lock:
            self.faults.append(Fault("stall", *fault))
            self.holds_until = until

    def was_quick(self):
        """Whether no answer waited for this machine so long that the service may have asked three times in vain."""
        return self.slowest_s < 0.06

    def is_spoilt(self):
        """Whether every fault that was asked for has happened, and all that came late is through."""
        with self.lock:
            return not self.faults and not self.held

    def serve(self):
        received, before = b"", time.monotonic()
        while not self.ends:
            if select.select([self.line], [], [], 0.001)[0]:
                received += os.read(self.line, 4096)
            with self.lock:
                now = time.monotonic()
                self.slowest_s = max(self.slowest_s, now - before)
                self.move(now - before)
                before = now
                while len(received) >= 7 and len(received) >= 7 + int.from_bytes(received[5:7], "little"):
                    size = 7 + int.from_bytes(received[5:7], "little")
                    self.hear(received[:size])
                    received = received[size:]

    def move(self, seconds):
        for servo, memory in self.memory.items():
            way = self.number(servo, GOAL, 4) - self.at[servo]
            if memory[TORQUE] == 1:
                self.at[servo] += max(-STEPS_PER_S * seconds, min(STEPS_PER_S * seconds, way))
            memory[POSITION:POSITION + 4] = round(self.at[servo]).to_bytes(4, "little", signed=True)

    def hear(self, packet):
        instruction, parameters = packet[7], packet[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        if packet[:4] != HEADER or packet[-2:] != crc(packet[:-2]):
            self.unknown.append(packet)
            return
        address = int.from_bytes(parameters[:2], "little")
        self.let_through(address)
        if instruction == READ:
            self.answer(instruction, packet[4], address, int.from_bytes(parameters[2:4], "little"))
        elif instruction == SYNC_READ:
            for servo in parameters[4:]:
                self.answer(instruction, servo, address, int.from_bytes(parameters[2:4], "little"))
        elif instruction == WRITE:
            self.write(packet[4], address, parameters[2:])
            self.answer(instruction, packet[4], address, 0)
        elif instruction == SYNC_WRITE:
            size = int.from_bytes(parameters[2:4], "little")
            for first in range(4, len(parameters), size + 1):
                self.write(parameters[first], address, parameters[first + 1:first + 1 + size])
        else:
            self.unknown.append(packet)

    def write(self, servo, address, data):
        if servo not in self.memory:
            return
        self.memory[servo][address:address + len(data)] = data
        if address == GOAL:
            self.goals.append((servo, int.from_bytes(data, "little")))
        if address == TORQUE:
            self.torques.append((servo, data[0]))

    def let_through(self, address):
        if not self.held or self.holds_until not in (None, address):
            return
        self.holds_until = None
        for answer in self.held:
            os.write(self.line, answer)
            time.sleep(0.003)  # so that it is read before what comes next
        self.held.clear()

    def answer(self, instruction, servo, address, size):
        if servo not in self.memory:
            return
        body = HEADER + bytes([servo, 0, 0, STATUS, 0])
        body += self.memory[servo][address:address + size].replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        body = body[:5] + (len(body) - 5).to_bytes(2, "little") + body[7:]
        answer = body + crc(body)
        fault = next((fault for fault in self.faults if fault[1:] == (instruction, address, servo)), None)
        if fault:
            self.faults.remove(fault)
        kind = fault and fault.kind
        if kind in ("late", "stall") or (self.held and self.holds_until is not None):
            self.held.append(answer)
        elif kind != "lost":
            os.write(self.line, answer * (2 if kind == "twice" else 1))
