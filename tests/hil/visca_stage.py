"""A pan/tilt camera that speaks VISCA at the end of a USB adapter: orders, read-back, silence, a pulled adapter."""

import select
import socket
import threading
import time

from cable import connect_to
from service import GuestService

SMOKE_CHECKS = ("check", "zoom", "angles", "limit", "ends")
CHECKS = SMOKE_CHECKS + ("silent", "unplugged")

NODE = "/dev/ttyUSB0"
ADDRESS, ZOOM = 1, 512
PAN_STEPS_PER_DEG, TILT_STEPS_PER_DEG = 880 / 100, 300 / 25  # Sony EVI-D30/D31 command list; pan counts to the right
STATUS_LIMIT, STATUS_FAULT = 1 << 5, 1 << 12
SCENE = 22
SETTLES_S = 1.0


class ViscaCamera:
    """Context manager. Turns at once; answers as Sony's command list says, with the address that it was given."""

    def __init__(self, path):
        self.path = path
        self.pan = self.tilt = self.zoom = 0
        self.orders, self.unknown = 0, []
        self.answers = True
        self.thread = None

    def __enter__(self):
        self.plug()
        return self

    def __exit__(self, *_):
        self.unplug()

    def plug(self):
        self.line, self.ends = connect_to(self.path), socket.socketpair()
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def unplug(self):
        if self.thread:
            self.ends[0].close()
            self.thread.join()
            self.ends[1].close()
            self.line.close()
            self.thread = None

    def _serve(self):
        packet = b""
        while True:
            ready = select.select([self.ends[1], self.line], [], [])[0]
            data = self.line.recv(256) if self.line in ready else b""
            if self.ends[1] in ready or not data:
                return
            for byte in data:
                packet += bytes([byte])
                if byte == 0xFF:
                    for reply in self._answer(packet) if self.answers else ():
                        self.line.sendall(reply)
                    packet = b""

    def _answer(self, packet):
        if packet == bytes.fromhex("883001ff"):  # addresses: the next one would be 2
            return [bytes.fromhex("883002ff")]
        if packet == bytes.fromhex("88010001ff"):  # everybody: forget what runs
            return [packet]
        if packet[0] != 0x80 | ADDRESS:
            self.unknown.append(packet.hex(" "))
            return []
        body, me = packet[1:-1], 0x80 + 16 * ADDRESS
        done = [bytes([me, 0x41, 0xFF]), bytes([me, 0x51, 0xFF])]
        if body[:3] == b"\x01\x06\x02" and len(body) == 13:
            self.pan, self.tilt = nibbles(body[5:9]), nibbles(body[9:13])
            self.orders += 1
            return done
        if body[:3] == b"\x01\x06\x01":  # stop
            return done
        if body[:3] == b"\x01\x04\x47" and len(body) == 7:
            self.zoom = nibbles(body[3:7])
            return done
        if body == b"\x09\x06\x12":
            return [bytes([me, 0x50, *as_nibbles(self.pan), *as_nibbles(self.tilt), 0xFF])]
        if body == b"\x09\x04\x47":
            return [bytes([me, 0x50, *as_nibbles(self.zoom), 0xFF])]
        if body == b"\x01\x00\x01":
            return done[1:]
        self.unknown.append(packet.hex(" "))
        return [bytes([me, 0x60, 0x02, 0xFF])]  # syntax error


def nibbles(data):
    value = 0
    for byte in data:
        value = value << 4 | byte & 0x0F
    return value - 0x10000 if value & 0x8000 else value


def as_nibbles(value):
    return [value >> shift & 0x0F for shift in (12, 8, 4, 0)]


CONFIG = f"""[camera]
source = "recording"
device = "/tmp/scene{SCENE}"
rate_hz = 10.0
[modbus]
allow_writes = true
[modbus.tcp]
listen = "0.0.0.0"
[pan_tilt]
driver = "visca"
device = "{NODE}"
address = {ADDRESS}
zoom = {ZOOM}
follow = false
[pan_tilt.pan]
min_deg = -90
max_deg = 90
[pan_tilt.tilt]
min_deg = -25
max_deg = 25
"""


class ViscaStage:
    def __init__(self, stage, guest, camera):
        self.stage, self.guest, self.camera = stage, guest, camera
        guest.check("modprobe ftdi_sio; modprobe xhci_pci")
        guest.check(f"for _ in $(seq 100); do [ -e {NODE} ] && break; sleep 0.1; done; ls {NODE}")
        guest.write("/tmp/ninedotd.toml", CONFIG)
        guest.check(
            f"""mkdir -p /tmp/scene{SCENE}/frames && cd /tmp/scene{SCENE} && cp /media/scenes/camera.yaml . &&
            cp /media/scenes/frames/{SCENE:06}.png frames/000000.png &&
            printf 'frame,timestamp_ns,pan_deg,tilt_deg\\n0,0,0,0\\n' > frames.csv"""
        )

    def aim(self, pan_deg, tilt_deg):
        return self.guest.run(f"ninedot aim --pan-deg {pan_deg} --tilt-deg {tilt_deg}", 40)

    def stands_at(self, pan_deg, tilt_deg):
        steps = -pan_deg * PAN_STEPS_PER_DEG, tilt_deg * TILT_STEPS_PER_DEG
        return abs(self.camera.pan - steps[0]) <= 0.5 and abs(self.camera.tilt - steps[1]) <= 0.5

    def angles(self, service):
        rows, good = [], True
        for pan, tilt in ((0, 0), (30, 10), (-45, -20), (12.5, -7.25), (90, 25)):
            status, text = self.aim(pan, tilt)
            # `aim` is content a little beside the target; the head goes on to it.
            time.sleep(SETTLES_S)
            told = service.read().head_deg
            half_steps = [0.5 / PAN_STEPS_PER_DEG + 0.005, 0.5 / TILT_STEPS_PER_DEG + 0.005]
            reads_back = all(abs(told[i] - angle) <= half_steps[i] for i, angle in enumerate((pan, tilt)))
            good &= status == 0 and self.stands_at(pan, tilt) and reads_back
            rows.append((f"{pan} / {tilt}", f"{self.camera.pan} / {self.camera.tilt}", f"{told[0]:.2f} / {told[1]:.2f}"))
        header = ("asked for [deg]", "the camera's position [steps]", "registers 37, 38 [deg]")
        self.stage.table("`ninedot aim` and a VISCA camera (pan / tilt)", header, rows)
        self.stage.ok("angles", good, f"{len(rows)} positions, right to the camera's own step, and read back")
        self.stage.begin("limit")
        self.aim(120, -60)
        service.wait_for(lambda registers: registers.word(4) & STATUS_LIMIT, "the status bit servo_limit", 10)
        time.sleep(SETTLES_S)
        self.stage.ok("limit", self.stands_at(90, -25), "120 and -60 deg: stays at 90 and -25, servo_limit is set")

    def lost_and_back(self, service, check, what, lose, bring_back):
        """The camera is somewhere else when it comes back, as after a power cut: the last target is set again."""
        self.stage.begin(check)
        self.aim(20, 5)
        lost_at = time.monotonic()
        lose()
        service.wait_for(lambda registers: registers.word(4) & STATUS_FAULT, "the status bit servo_fault", 10)
        fault_s = time.monotonic() - lost_at
        valid = service.wait_for_frames(5).valid_when_taken
        self.camera.pan = self.camera.tilt = self.camera.zoom = 0
        bring_back()
        back_at = time.monotonic()
        service.wait_for(lambda registers: not registers.word(4) & STATUS_FAULT, "servo_fault is over", 20)
        service.wait_for(lambda _: self.stands_at(20, 5), "the last target is set again", 10)
        self.stage.ok(
            check,
            valid and self.camera.zoom == ZOOM,
            f"{what}: servo_fault after {fault_s:.1f} s, poses go on; "
            f"back at its target and zoom after {time.monotonic() - back_at:.1f} s",
        )

    def losses(self, service):
        silence = (lambda: setattr(self.camera, "answers", False)), (lambda: setattr(self.camera, "answers", True))
        self.lost_and_back(service, "silent", "a camera that does not answer", *silence)
        self.lost_and_back(service, "unplugged", "the adapter pulled", self.camera.unplug, self.camera.plug)

    def run(self):
        status, text = self.guest.run("ninedot check --config /tmp/ninedotd.toml")
        self.stage.ok("check", status == 0, "`ninedot check` opens the port" if status == 0 else text)
        service = GuestService(self.guest, CONFIG)
        with service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            self.stage.begin("zoom")
            service.wait_for(lambda _: self.camera.zoom == ZOOM, "the zoom is set", 10)
            self.stage.ok("zoom", True, f"set to {self.camera.zoom} at the start")
            self.angles(service)
            if not self.stage.smoke:
                self.losses(service)
        unknown = "" if not self.camera.unknown else f"; packets that no such camera knows: {self.camera.unknown[:3]}"
        self.stage.ok("ends", service.exit_status == "0" and not unknown, f"exit status {service.exit_status} on SIGINT{unknown}")


def run(stage):
    adapter = ["-chardev", "socket,id=usb,path={folder}/usb,server=on,wait=off", "-device", "qemu-xhci"]
    with stage.guest(*adapter, "-device", "usb-serial,chardev=usb") as guest:
        with ViscaCamera(guest.folder / "usb") as camera:
            ViscaStage(stage, guest, camera).run()
