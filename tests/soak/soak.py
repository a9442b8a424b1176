"""Weeks of the service in hours: the frames of simulated hours, played as fast as this machine can, with faults in each of them. Started by tests/soak.sh.

A simulated hour is 126,000 reports of frames, what a camera at 35 Hz gives, each as soon as the one before is out (camera.every_frame). Each hour has every fault once, in an order and at moments of its own; after it, with nothing going on, the books must balance:
memory, threads and open files are what they were, and every counter is what was done to the service.
"""

import argparse
import json
import os
import pathlib
import random
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

import recording

FRAMES_PER_HOUR = 126_000
MAX_CLIENTS = 6
# Memory may settle in the first hours: buffers of the C library grow to what the worst moment took. Afterwards it stays. [KiB]
SETTLED_AFTER_H = 2
SETTLING_KIB = 4096
SLACK_KIB = 512
PATIENCE_S = 60

MAP = "[[landmarks]]\nid = 1\nposition_mm = [{}, 0, 0]\n"


class Wrong(Exception):
    """What the soak found."""


def require(condition, what):
    if not condition:
        raise Wrong(what)


def until(condition, what, limit_s=PATIENCE_S):
    end = time.monotonic() + limit_s
    while not condition():
        require(time.monotonic() < end, f"not within {limit_s} s: {what}")
        time.sleep(0.02)


def crc(frame):
    value = 0xFFFF
    for byte in frame:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ 0xA001 if value & 1 else value >> 1
    return struct.pack("<H", value)


class Line:
    """A serial line without hardware; it can be cut and laid again."""

    def __init__(self, folder):
        self.ends = [str(folder / "service"), str(folder / "controller")]
        self.cable = None
        self.lay()

    def lay(self):
        self.cable = subprocess.Popen(["socat", *(f"pty,raw,echo=0,link={end}" for end in self.ends)], stderr=subprocess.DEVNULL)
        until(lambda: all(os.path.exists(end) for end in self.ends), "socat makes a pair of ptys")

    def cut(self):
        self.cable.terminate()
        self.cable.wait()

    def ask(self):
        """Returns what the service answers to a read of register 0, over the line"""
        port = os.open(self.ends[1], os.O_RDWR | os.O_NOCTTY)
        try:
            request = struct.pack(">BBHH", 7, 3, 0, 1)
            os.write(port, request + crc(request))
            answer, end = b"", time.monotonic() + 3
            while len(answer) < 7 and time.monotonic() < end:
                if select.select([port], [], [], 0.2)[0]:
                    answer += os.read(port, 64)
            return answer
        finally:
            os.close(port)


class Client:
    """Modbus TCP, as a controller reads it."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=20)
        self.number = 0

    def read(self, first, count):
        self.number = self.number + 1 & 0xFFFF
        self.socket.sendall(struct.pack(">HHHBBHH", self.number, 0, 6, 1, 3, first, count))
        reply = b""
        while len(reply) < 9 + 2 * count:
            chunk = self.socket.recv(512)
            require(chunk, "the service closes a connection that does nothing wrong")
            reply += chunk
        require(struct.unpack_from(">H", reply)[0] == self.number, "the answer to another request")
        return struct.unpack(f">{count}H", reply[9:9 + 2 * count])


class Counter16:
    """A 16-bit counter that is read often enough to see each of its wraps."""

    def __init__(self, value):
        self.value, self.counted, self.wraps = value, 0, 0

    def note(self, value):
        self.counted += value - self.value & 0xFFFF
        self.wraps += value < self.value
        self.value = value


class Soak:
    def __init__(self, seed):
        self.folder = tempfile.TemporaryDirectory(prefix="ninedot-soak-")
        self.random = random.Random(seed)
        self.line = self.service = self.client = None

    def begin(self, programs):
        place = pathlib.Path(self.folder.name)
        size_px = recording.make(pathlib.Path("tests/recordings/positions"), place)
        self.line = Line(place)
        self.map = place / "map.toml"
        self.map.write_text(MAP.format(0))
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        config = place / "soak.toml"
        config.write_text(f"""map = "{self.map}"
[camera]
source = "recording"
device = "{place}/soak.y4m"
calibration = "{place}/camera.yaml"
width_px = {size_px}
height_px = {size_px}
every_frame = true
stall_frames = 1000
[modbus.tcp]
listen = "127.0.0.1"
port = {self.port}
max_clients = {MAX_CLIENTS}
idle_timeout_s = 20
[modbus.rtu]
device = "{self.line.ends[0]}"
parity = "N"
unit = 7
[service]
realtime_priority = 0
""")
        self.log_path = place / "log"
        self.log = open(self.log_path, "w", encoding="utf-8")
        self.service = subprocess.Popen([programs / "ninedotd", "--config", config], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self.log)
        until(self.connects, "the service answers")
        self.map_again()  # its thread is there from the first time on
        # What was done to the service, and so what its counters have to say.
        self.expected = {"connections": 1, "refused": 0, "rtu_losses": 0, "maps": 0, "maps_kept": 0}
        self.offset = self.counters()
        self.frames_at_start = self.offset["processed"]
        until(lambda: self.counters()["serial_open"], "the serial line is open")
        self.first = self.settled = self.state()
        self.heartbeat, self.poses = Counter16(self.offset["heartbeat"]), Counter16(self.offset["poses"])
        self.before = 0, 0  # the last hour's end: frames processed, poses valid

    def connects(self):
        require(self.service.poll() is None, f"the service has ended: {self.log_text()}")
        try:
            self.client = Client(self.port)
            return True
        except OSError:
            return False

    def log_text(self):
        return self.log_path.read_text(encoding="utf-8")

    def counters(self):
        low, high = self.client.read(0, 125), self.client.read(86, 73)
        wide = lambda block, at: block[at] << 16 | block[at + 1]
        require(low[2] == wide(low, 61) & 0xFFFF, f"the heartbeat {low[2]} is not the low half of {wide(low, 61)} processed frames")
        require(low[3] == low[39], "the pose's number differs within one reply")
        return {"heartbeat": low[2], "poses": low[3], "processed": wide(low, 61), "dropped": wide(low, 63), "failed": wide(low, 65), "restarts": low[67], "uptime": wide(low, 73),
                "serial_open": low[78] >> 2 & 1, "requests": wide(high, 2), "connections": wide(high, 4), "refused": wide(high, 6), "expired": wide(high, 8), "rtu_losses": high[12]}

    # --- faults ---

    def hanging_clients(self):
        """They ask and never read the answers, until their buffers and the service's are full; then they go without a word."""
        connections = []
        for _ in range(3):
            connection = socket.create_connection(("127.0.0.1", self.port), timeout=5)
            connection.setblocking(False)
            connections.append(connection)
        self.expected["connections"] += len(connections)
        request = struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, 0, 125) * 64
        for _ in range(400):
            for connection in connections:
                try:
                    connection.send(request)
                except OSError:
                    pass  # full, or closed by the service, which may do that
        self.client.read(0, 10)
        for connection in connections:
            connection.close()

    def rubbish(self):
        """Bytes that are no Modbus, half requests, lengths that lie."""
        for data in (self.random.randbytes(300), b"\x00\x01\x00\x00\xff\xff" + self.random.randbytes(50), b"\x00\x01\x00\x00\x00\x06\x01", b"GET / HTTP/1.1\r\n\r\n", b"\x00\x01\x12\x34\x00\x06\x01\x03\x00\x00\x00\x01"):
            with socket.create_connection(("127.0.0.1", self.port), timeout=5) as connection:
                self.expected["connections"] += 1
                try:
                    connection.sendall(data)
                except OSError:
                    pass
        self.client.read(0, 10)

    def too_many(self):
        """As many as may, and one more."""
        until(lambda: self.client.read(77, 1)[0] <= 2, "the clients of before are gone")
        connections = []
        for _ in range(MAX_CLIENTS + 2):
            connections.append(socket.create_connection(("127.0.0.1", self.port), timeout=5))
            time.sleep(0.05)
        for connection in connections:
            connection.close()
        # Which of them the service lets in is its affair: all were counted as one or the other.
        self.expected["connections"] += len(connections)
        self.client.read(0, 10)

    def reload(self, text, answer):
        said = self.log_text().count(answer)
        self.map.write_text(text)
        self.service.send_signal(signal.SIGHUP)
        until(lambda: self.log_text().count(answer) > said, f"'{answer}' in the log")

    def map_again(self):
        self.reload(MAP.format(self.random.randrange(5000)), "read again")
        self.reload("[[landmarks]]\nid = 1\nplace = 3\n", "map kept")
        self.reload(MAP.format(0), "read again")

    def line_gone(self):
        self.line.cut()
        until(lambda: self.client.read(78, 1)[0] >> 2 & 1 == 0, "the service sees that the line is gone")
        self.expected["rtu_losses"] += 1
        time.sleep(self.random.uniform(0, 1))
        self.line.lay()
        until(lambda: self.client.read(78, 1)[0] >> 2 & 1 == 1, "the line is open again")
        until(lambda: self.line.ask()[:2] == b"\x07\x03", "the service answers over the line")

    def tap_reader(self):
        """A controller that comes, reads and goes, a thousand times a fault's worth."""
        for _ in range(50):
            Client(self.port).read(0, 125)
        self.expected["connections"] += 50

    # --- the books ---

    def state(self):
        folder = f"/proc/{self.service.pid}"
        with open(f"{folder}/status", encoding="ascii") as file:
            status = dict(line.split(":", 1) for line in file)
        return {"rss_kib": int(status["VmRSS"].split()[0]), "threads": int(status["Threads"]), "files": len(os.listdir(f"{folder}/fd"))}

    def watch(self, counters):
        self.heartbeat.note(counters["heartbeat"])
        self.poses.note(counters["poses"])

    def play_until(self, frame):
        while True:
            require(self.service.poll() is None, f"the service has ended: {self.log_text()[-2000:]}")
            counters = self.counters()
            self.watch(counters)
            if counters["processed"] - self.frames_at_start >= frame:
                return counters
            time.sleep(0.1)

    def check(self, hour, started):
        until(lambda: self.client.read(77, 1)[0] <= 2, "all clients but this one and the line are gone")
        counters, state = self.counters(), self.state()
        self.watch(counters)
        grown = {key: counters[key] - self.offset[key] for key in counters}
        require(grown["failed"] == 0 and grown["restarts"] == 0 and grown["dropped"] == 0, f"frames failed or were dropped: {grown}")
        came = grown["connections"] + grown["refused"] + 1
        require(came == self.expected["connections"], f"{came} connections counted, {self.expected['connections']} made")
        require(grown["rtu_losses"] == self.expected["rtu_losses"], f"{grown['rtu_losses']} losses of the line counted, {self.expected['rtu_losses']} made")
        wraps = (counters["processed"] >> 16) - (self.offset["processed"] >> 16)
        require(wraps == self.heartbeat.wraps, f"the heartbeat wrapped {self.heartbeat.wraps} times, {wraps} are due")
        processed, valid = grown["processed"] - self.before[0], self.poses.counted - self.before[1]
        due = recording.SHOWN * processed / recording.FRAMES
        require(abs(valid - due) <= recording.SHOWN, f"{valid} valid poses in the {processed} frames of hour {hour}: {due:.0f} are due")
        self.before = grown["processed"], self.poses.counted
        require(abs(counters["uptime"] - (time.monotonic() - started)) < 30, f"up {counters['uptime']} s by itself, {time.monotonic() - started:.0f} s by this clock")
        if hour <= SETTLED_AFTER_H:
            self.settled = state
        require(state["threads"] == self.first["threads"] and state["files"] == self.first["files"], f"threads or open files: {state}, at first {self.first}")
        most = min(self.first["rss_kib"] + SETTLING_KIB, self.settled["rss_kib"] + SLACK_KIB)
        require(state["rss_kib"] <= most, f"memory grows: {state['rss_kib']} KiB, {self.first['rss_kib']} at first, {most} permitted")
        lines = self.log_text().count("\n")
        require(lines < 100 * (hour + 1), f"{lines} lines of log in {hour} hours")
        return {"hour": hour, "processed": grown["processed"], "dropped": grown["dropped"], "poses": self.poses.counted, "wraps": wraps, "requests": grown["requests"], "expired": grown["expired"], "log_lines": lines, **state}

    def hour(self, number, started):
        begin = (number - 1) * FRAMES_PER_HOUR
        faults = [self.hanging_clients, self.rubbish, self.too_many, self.map_again, self.line_gone, self.tap_reader]
        self.random.shuffle(faults)
        moments = sorted(self.random.uniform(0.02, 0.8) for _ in faults)
        for moment, fault in zip(moments, faults):
            self.play_until(begin + moment * FRAMES_PER_HOUR)
            try:
                fault()
            except (Wrong, OSError) as error:
                raise Wrong(f"hour {number}, {fault.__name__}: {error}") from error
        self.play_until(number * FRAMES_PER_HOUR)
        return self.check(number, started)

    def end(self):
        self.client.socket.close()
        self.service.send_signal(signal.SIGTERM)
        status = self.service.wait(PATIENCE_S)
        self.line.cut()
        require(status == 0, f"ended with status {status}: {self.log_text()[-2000:]}")

    def abandon(self):
        if self.service and self.service.poll() is None:
            self.service.kill()
            self.service.wait()
        if self.line and self.line.cable.poll() is None:
            self.line.cut()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("hours", type=int)
    parser.add_argument("--seed", default="soak")
    parser.add_argument("--out", type=pathlib.Path, help="a line of JSON for each simulated hour")
    arguments = parser.parse_args()
    # Whoever ends the soak ends what it has started.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    started = time.monotonic()
    soak = Soak(arguments.seed)
    out = open(arguments.out, "w", encoding="utf-8") if arguments.out else None
    try:
        soak.begin(arguments.programs)
        for number in range(1, arguments.hours + 1):
            row = soak.hour(number, started)
            row["seconds"] = round(time.monotonic() - started)
            print(f"hour {number} of {arguments.hours}: {row['processed']} frames processed, {row['poses']} poses valid, {row['dropped']} dropped, {row['requests']} requests, "
                  f"{row['rss_kib']} KiB, {row['threads']} threads, {row['files']} files, {row['seconds']} s", flush=True)
            if out:
                out.write(json.dumps(row) + "\n")
                out.flush()
        soak.end()
    except (Wrong, OSError) as error:
        print(f"FAILED: {error}", file=sys.stderr)
        return 1
    finally:
        soak.abandon()
    print(f"ok: {arguments.hours} simulated hours ({arguments.hours * FRAMES_PER_HOUR} frames) in {time.monotonic() - started:.0f} s: memory, threads and open files flat, "
          f"heartbeat wrapped {soak.heartbeat.wraps} times, every counter right")
    return 0


if __name__ == "__main__":
    sys.exit(main())
