"""The packages as apt installs them, under systemd and udev: the service in its sandbox on devices that come late, what the sandbox
keeps from it, and the page (installed_page.py). As root; elsewhere it is left out."""

import os
import pathlib
import subprocess
import time

import installed_page
from cable import Cable
from guest import Guest
from installed_page import BACK_WITHIN_S, CONFIG, PageOfInstalled
from registers import REASON_CAMERA_LOST, STATUS_FAULT, STATUS_HAS_HEAD, Registers
from serial_stage import Master
from service_harness import Client
from servo_stage import i2c_steps_of, outputs_of
from vimc_facts import CONTROLS, EXPOSURE_US, GAIN, RATE_HZ
from vivid import Vivid

SMOKE_CHECKS = ("out-of-the-box", "as-its-user", "real-time")
CHECKS = SMOKE_CHECKS + (
    "absent-at-start",
    "devices-come",
    "never-restarted",
    "one-line-each",
    "check-beside",
    "check-lists-all",
    "udev-pwm",
    "udev-postinst",
    "sandbox-devices",
    "sandbox-files",
    "sandbox-sensor",
    "sandbox-i2c",
    "wrong-file",
    *installed_page.CHECKS,
)

SOURCE = pathlib.Path(__file__).resolve().parents[2]
NODE = "/dev/ttyUSB0"
STILL = "/media/stills/10.raw"
ROUNDS = int(os.environ.get("NINEDOT_HIL_ROUNDS", "2"))  # of devices that are absent at the start
ABSENT_S = 60
PAN, TILT, POWER = 0, 5, 0
FREE_CHANNEL = 3

LATE = f"""[camera]
source = "v4l2"
device = "/dev/video0"
rate_hz = 59.94
pixel_format = "GREY"
calibration = "/media/scenes/camera.yaml"
[modbus]
allow_writes = true
[modbus.tcp]
listen = "0.0.0.0"
[modbus.rtu]
device = "{NODE}"
baud = 115200
parity = "E"
unit = 7
[pan_tilt]
driver = "sysfs-pwm"
follow = false
[pan_tilt.pan]
chip = "CHIP"
channel = {PAN}
[pan_tilt.tilt]
chip = "CHIP"
channel = {TILT}
[gpio]
servo_power = "servo-power"
"""
# The same camera and head down to the sensor and the chip: what a ribbon cable and a servo board ask of the sandbox.
DIRECT = (
    LATE.replace("rate_hz = 59.94", f"rate_hz = {RATE_HZ}\nexposure_us = {EXPOSURE_US}\ngain = {GAIN}")
    .replace('"/dev/video0"', '"sensor:Sensor B"')
    .replace('driver = "sysfs-pwm"', 'driver = "pca9685"\ndevice = "I2C"')
    .replace('chip = "CHIP"\n', "")
)
START_LIMIT = 5  # so many starts systemd permits a unit that says nothing of it


class Installed:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        self.chip = None
        self.client = None

    def show(self, what, unit="ninedotd"):
        return self.guest.check(f"systemctl show -P {what} {unit}")

    def journal(self, unit="ninedotd"):
        """Of this start."""
        return self.guest.check(f"journalctl -q -o cat -u {unit} _SYSTEMD_INVOCATION_ID=$(systemctl show -P InvocationID {unit}) --no-pager", 60)

    def configure(self, text):
        self.guest.write(CONFIG, text)

    def restart(self):
        """systemctl itself waits until the service is ready. \\return  seconds"""
        started = time.monotonic()
        self.guest.check("systemctl reset-failed ninedotd; systemctl restart ninedotd", 120)
        return time.monotonic() - started

    def read(self):
        """A new connection where the last one's service is gone."""
        deadline = time.monotonic() + BACK_WITHIN_S
        while True:
            try:
                self.client = self.client or Client(port=self.guest.modbus_port).__enter__()
                return Registers(self.client.read(0, 86))
            except Exception:
                if self.client:
                    self.client.__exit__()
                self.client = None
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.2)

    def wait_for(self, condition, what, within_s=BACK_WITHIN_S):
        """\\return  seconds"""
        started = time.monotonic()
        while True:
            registers = self.read()
            if condition(registers):
                return time.monotonic() - started
            if time.monotonic() - started > within_s:
                raise AssertionError(
                    f"not within {within_s} s: {what}; valid {registers.valid}, reason {registers.reason}, status {registers.word(4):#06x}; journal:\n{self.journal()}"
                )
            time.sleep(0.05)

    # As it comes.

    def out_of_the_box(self):
        failed = self.guest.check("systemctl list-units --failed --plain --no-legend")
        # As installed it listens on the machine itself alone.
        poses = self.guest.run("for _ in $(seq 30); do ninedot status | grep '^pose  *valid' && exit 0; sleep 1; done; exit 1", 120)
        self.stage.ok(
            "out-of-the-box",
            not failed and poses[0] == 0 and self.show("ActiveState") == "active" and self.show("NRestarts") == "0",
            f"enabled by the installation, it serves valid poses after the boot; failed units: {failed or 'none'}; {poses[1][:120]}",
        )
        owner = self.guest.check("stat -c %U /proc/$(systemctl show -P MainPID ninedotd)")
        rights = self.guest.check("grep -E '^(CapEff|NoNewPrivs|Seccomp):' /proc/$(systemctl show -P MainPID ninedotd)/status").split()
        self.stage.ok(
            "as-its-user",
            owner == "ninedot" and int(rights[1], 16) == 0 and rights[3] == "1" and rights[5] == "2",
            f"user {owner}, {' '.join(rights)}",
        )
        threads = self.guest.check("for t in /proc/$(systemctl show -P MainPID ninedotd)/task/*; do cut -d' ' -f 40-41 $t/stat; done").splitlines()
        locked = self.guest.check("sed -n 's/^VmLck: *//p' /proc/$(systemctl show -P MainPID ninedotd)/status")
        fifo = [line for line in threads if line.endswith(" 1")]
        self.stage.ok(
            "real-time",
            fifo and not locked.startswith("0 "),
            f"{len(fifo)} of {len(threads)} threads SCHED_FIFO (priority {', '.join(line.split()[0] for line in fifo)}), {locked} locked",
        )

    # Devices that come late.

    def add_chip(self):
        bus = self.bus
        self.guest.check(f"echo pca9685 0x40 > /sys/bus/i2c/devices/i2c-{bus}/new_device && udevadm settle")

    def remove_chip(self):
        self.guest.run(f"echo 0x40 > /sys/bus/i2c/devices/i2c-{self.bus}/delete_device")

    def add_lines(self):
        self.guest.check("echo 1 > /sys/kernel/config/gpio-sim/hil/live && udevadm settle")

    def power(self):
        chip = self.guest.check("cat /sys/kernel/config/gpio-sim/hil/dev_name /sys/kernel/config/gpio-sim/hil/bank/chip_name").split()
        return int(self.guest.check(f"cat /sys/devices/platform/{chip[0]}/{chip[1]}/sim_gpio{POWER}/value"))

    def prepare(self):
        self.guest.check("modprobe i2c-stub chip_addr=0x40 && modprobe pwm-pca9685 && modprobe gpio-sim")
        self.bus = self.guest.check("grep -l stub /sys/bus/i2c/devices/i2c-*/name | sed 's/.*i2c-\\([0-9]*\\).*/\\1/'")
        self.guest.check(
            "mountpoint -q /sys/kernel/config || mount -t configfs configfs /sys/kernel/config\n"
            f"cd /sys/kernel/config/gpio-sim && mkdir hil hil/bank hil/bank/line{POWER} && echo 8 > hil/bank/num_lines &&\n"
            f"echo hil-lines > hil/bank/label && echo servo-power > hil/bank/line{POWER}/name"
        )

    def round(self, cable):
        """\\return  (seconds until it is ready, what was seen without, seconds until camera, line, head work)"""
        self.guest.check("systemctl stop ninedotd")
        self.remove_chip()
        # Unloaded, too: whose driver was never there systemd has never heard of.
        self.guest.run("echo 0 > /sys/kernel/config/gpio-sim/hil/live; kill $(cat /tmp/player.pid /tmp/player.child); rm -f /tmp/player.pid; sleep 1; modprobe -r vivid")
        cable.unplug()
        self.guest.run("sleep 1; modprobe -r ftdi_sio i2c-dev")
        absent = self.guest.check(f"ls -d /dev/video* {NODE} /dev/gpiochip* /sys/class/pwm/pwmchip* 2> /dev/null; true")
        if absent:
            raise AssertionError(f"still there: {absent}")
        ready_s = self.restart()
        time.sleep(ABSENT_S)
        registers = self.read()
        without = (self.show("ActiveState"), registers.valid, registers.reason, bool(registers.word(4) & STATUS_FAULT))
        plugged = time.monotonic()
        vivid = Vivid(self.guest)
        vivid.play(STILL)
        self.wait_for(lambda registers: registers.valid, "a pose of the camera that came")
        camera_s = time.monotonic() - plugged
        cable.plug()
        plugged = time.monotonic()
        with Master(cable.device, timeout_s=1.0) as master:
            while True:
                try:
                    line = Registers(master.read(0, 86))
                    break
                except Exception:
                    if time.monotonic() - plugged > BACK_WITHIN_S:
                        raise
                    master.client.close()
                    master.client.connect()
        line_s = time.monotonic() - plugged
        self.add_lines()
        self.add_chip()
        plugged = time.monotonic()
        self.wait_for(lambda registers: not registers.word(4) & STATUS_FAULT and registers.word(4) & STATUS_HAS_HEAD, "the head that came")
        head_s = time.monotonic() - plugged
        status, text = self.guest.run("ninedot aim --pan-deg 20 --tilt-deg -10", 60)
        good = line.valid and status == 0 and self.power() == 1
        return ready_s, without, (camera_s, line_s, head_s), good, text

    def late_devices(self, cable):
        self.prepare()
        self.configure(LATE.replace("CHIP", f"{self.bus}-0040"))
        rows, absent, came, restarts, lines = [], True, True, [], []
        for turn in range(1, ROUNDS + 1):
            ready_s, without, seconds, good, text = self.round(cable)
            absent &= without == ("active", False, REASON_CAMERA_LOST, True)
            came &= good
            restarts.append(self.show("NRestarts"))
            lines.append(self.journal().splitlines())
            rows.append((turn, f"{ready_s:.1f} s", *(f"{value:.1f} s" for value in seconds), text))
        self.stage.ok(
            "absent-at-start",
            absent,
            f"{ROUNDS} times without camera, RTU adapter, GPIO chip and PWM chip for {ABSENT_S} s: ready {rows[-1][1]} after the start, then {without}",
        )
        self.stage.ok("devices-come", came, f"camera, RTU and head work after {', '.join(rows[-1][2:5])} in the last of {ROUNDS} rounds: {text}")
        self.stage.table("Absent at the start, plugged after 60 s", ("round", "ready", "pose", "RTU", "head", "`ninedot aim`"), rows)
        self.stage.ok("never-restarted", set(restarts) == {"0"}, f"NRestarts {restarts}")
        # Of each device that it is missed, and that it is there; of the camera the latter is said with what it sees.
        said = ("camera: waits for it:", "Modbus RTU: not there, waits for it:", "pan/tilt: not there, waits for it:", "Modbus RTU: there", "pan/tilt: sysfs-pwm", "landmark 0 found")
        counts = [[sum(f"ninedotd: {words}" in line for line in of) for words in said] for of in lines]
        wrong = [of for of, count in zip(lines, counts) if count != [1] * len(said) or len(set(of)) != len(of)]
        self.stage.ok(
            "one-line-each",
            not wrong,
            f"{max(map(len, lines))} lines at most in the journal of one round; {', '.join(said)}: {counts[-1]} times" + "".join(f"\n  {line}" for of in wrong for line in of),
        )
        status, text = self.guest.run(f"ninedot check --config {CONFIG}", 60)
        # Of the serial line nothing: it is looked at and not opened, which would disturb it.
        said = ("1502 is in use by a running ninedotd", "/dev/video0: busy", "'servo-power' is in use by 'ninedot'")
        notes = [line for line in text.splitlines() if ": note: " in line]
        told = [sum(words in note for note in notes) for words in said]
        self.stage.ok(
            "check-beside",
            status == 0 and told == [1] * len(said) == [1] * len(notes),
            f"status {status}: {' | '.join(text.splitlines())}",
        )
        self.guest.write("/tmp/wrong.toml", LATE.replace("CHIP", "9-0040").replace("unit = 7", "unit = 700").replace("GREY", "GRAY") + "[web]\nport = 0\n")
        status, text = self.guest.run("ninedot check --file-only --config /tmp/wrong.toml")
        named = [word for word in ("unit", "pixel_format", "port") if word in text]
        self.stage.ok("check-lists-all", status == 2 and len(named) == 3, f"status {status}: {' | '.join(text.splitlines())}")

    def udev(self):
        files = "$(ls -d /sys/class/pwm/pwmchip*)/export"
        group = self.guest.check(f"stat -c '%G %a' {files}")
        channel = self.guest.check(f"stat -c '%G %a' $(ls -d /sys/class/pwm/pwmchip*)/pwm{PAN}/duty_cycle")
        self.stage.ok("udev-pwm", group == "gpio 260" and channel == "gpio 664", f"export: {group}; the channel that the service exported: {channel}")
        # A machine on which the chip was there before the package: nothing is reported again by itself.
        self.guest.check(f"systemctl stop ninedotd; chgrp root {files} && chmod 200 {files}")
        self.guest.check("dpkg -i /root/ninedot_*.deb > /tmp/dpkg.log 2>&1 || { cat /tmp/dpkg.log; exit 1; }; udevadm settle", 120)
        group = self.guest.check(f"stat -c '%G %a' {files}")
        # What the group is for: a channel of its own, by a program that is nothing but this user.
        status, text = self.as_the_service(
            f"""cd $(ls -d /sys/class/pwm/pwmchip*) && echo {FREE_CHANNEL} > export || exit 1
            for _ in $(seq 100); do [ -w pwm{FREE_CHANNEL}/duty_cycle ] && break; sleep 0.1; done
            cd pwm{FREE_CHANNEL} && echo 20000000 > period && echo 1500000 > duty_cycle && echo 1 > enable && cat duty_cycle enable &&
            echo 0 > enable && echo {FREE_CHANNEL} > ../unexport"""
        )
        self.stage.ok(
            "udev-postinst",
            group == "gpio 260" and status == 0 and text.split() == ["1500000", "1"],
            f"after an installation beside the chip: {group}; exported, set and started as user ninedot: {' '.join(text.split()) or status}",
        )

    def as_the_service(self, command):
        """As its user with its groups, outside the sandbox. \\return  (exit status, what it wrote)"""
        self.guest.write("/tmp/as-the-service.sh", command)
        return self.guest.run("setpriv --reuid=ninedot --regid=ninedot --init-groups /bin/sh /tmp/as-the-service.sh", 60)

    # What the sandbox keeps from it.

    def in_sandbox(self, command):
        """With the unit's own lines, but for what it starts. \\return  what it wrote"""
        self.guest.check(
            "sed -e '/^Exec/d; s/^Type=.*/Type=oneshot/; /^Watchdog/d; /^Restart/d; /^NotifyAccess/d' /lib/systemd/system/ninedotd.service > /run/systemd/system/probe.service"
        )
        self.guest.write("/tmp/probe.sh", f"echo probe begins\n{command}")
        self.guest.check(
            "mkdir -p /opt && cp /tmp/probe.sh /opt/probe.sh && chmod 755 /opt/probe.sh &&"
            " sed -i 's|^\\[Service\\]|[Service]\\nExecStart=/bin/sh /opt/probe.sh|' /run/systemd/system/probe.service && systemctl daemon-reload"
        )
        self.guest.check("systemctl start probe", 60)
        lines = self.guest.check("journalctl --sync; journalctl -q -o cat -u probe --no-pager", 60)
        return lines.rpartition("probe begins\n")[2]

    def sandbox(self):
        self.guest.check("modprobe vimc && modprobe i2c-dev && udevadm settle")
        needed = {"/dev/video0", "/dev/ttyUSB0", "/dev/gpiochip0", "/dev/media0", "/dev/v4l-subdev0", f"/dev/i2c-{self.bus}"}
        others = {"/dev/vda", "/dev/mem", "/dev/hvc0", "/dev/kmsg"}
        # By their modes anybody might: what keeps it out is the unit alone.
        self.guest.check(f"chmod 666 {' '.join(others)}")
        nodes = " ".join(sorted(needed | others))
        text = self.in_sandbox(f'for n in {nodes}; do if ( : <> $n ) 2> /tmp/why; then echo "open $n"; else echo "closed $n"; fi; done')
        opened = [line.split()[1] for line in text.splitlines() if line.startswith("open ")]
        closed = [line.split()[1] for line in text.splitlines() if line.startswith("closed ")]
        self.stage.ok(
            "sandbox-devices",
            set(opened) == needed and set(closed) == others,
            f"opened: {' '.join(opened)}; not: {' '.join(closed)}",
        )
        files = "/etc/ninedot/open /etc/open /var/open /run/open /home/open /usr/bin/open"
        self.guest.check(f"for f in {files}; do : > $f; chmod 666 $f; done")
        text = self.in_sandbox(
            f"for f in {files}; do if ( : >> $f ) 2> /dev/null; then echo open $f; else echo closed $f; fi; done\n"
            "cp /bin/true /tmp/true; if chmod u+s /tmp/true 2> /dev/null; then echo open suid; else echo closed suid; fi\n"
            "if unshare -U true 2> /dev/null; then echo open namespace; else echo closed namespace; fi"
        )
        opened = [line for line in text.splitlines() if line.startswith("open ")]
        closed = [line for line in text.splitlines() if line.startswith("closed ")]
        self.stage.ok("sandbox-files", not opened and len(closed) == 8, f"written, or more: {opened or 'nothing'}; of {len(closed)} tries")

    def direct(self):
        """A sensor behind a media graph and a PWM chip on I2C, by the installed service in its sandbox."""
        self.guest.check("systemctl stop ninedotd")
        self.remove_chip()
        self.guest.check("modprobe vimc && modprobe i2c-dev && udevadm settle")
        self.configure(DIRECT.replace("I2C", f"/dev/i2c-{self.bus}"))
        self.restart()
        first = self.read().processed
        frames_s = self.wait_for(lambda registers: registers.processed > first + 5, "frames of the sensor")
        owner = self.guest.check("stat -c %U /proc/$(systemctl show -P MainPID ninedotd)")
        node = self.guest.check("grep -lx 'Sensor B' /sys/class/video4linux/*/name").split("/")[4]
        text = self.guest.check(f"v4l2-ctl -d /dev/{node} --get-ctrl {','.join(CONTROLS)}")
        controls = {name: int(value) for name, value in (line.split(":") for line in text.splitlines())}
        nodes = self.guest.check(f"cd /dev && stat -c '%n %G %a' media* {node} i2c-{self.bus}").replace("\n", ", ")
        self.stage.ok(
            "sandbox-sensor",
            controls == CONTROLS and owner == "ninedot" and self.show("NRestarts") == "0",
            f"user {owner} ({nodes}): link, formats and controls set, {controls}; 5 frames in {frames_s:.1f} s",
        )
        self.wait_for(lambda registers: registers.word(4) & STATUS_HAS_HEAD and not registers.word(4) & STATUS_FAULT, "the head on I2C")
        status, text = self.guest.run("ninedot aim --pan-deg 20 --tilt-deg -10", 60)
        seen = outputs_of(self.guest, self.bus, "busybox i2cget")
        wanted = (i2c_steps_of(1700), i2c_steps_of(1400))
        self.stage.ok(
            "sandbox-i2c",
            status == 0 and seen == wanted and self.power() == 1,
            f"`ninedot aim`: {text}; the chip's outputs {seen}, {wanted} expected; {self.said_of('ninedotd: pan/tilt')}",
        )

    def said_of(self, words):
        return " | ".join(line for line in self.journal().splitlines() if words in line)

    def wrong_file(self):
        """Where systemd gives up by itself: after more starts than it permits in a time that the slowest guest keeps to."""
        limit, often = "/run/systemd/system.conf.d/limit.conf", "/run/systemd/system/ninedotd.service.d/often.conf"
        self.guest.write(limit, f"[Manager]\nDefaultStartLimitBurst={START_LIMIT}\nDefaultStartLimitIntervalSec=600")
        self.guest.write(often, "[Service]\nRestartSec=100ms")
        self.guest.check("systemctl daemon-reexec", 60)
        self.configure("[camera]\nsource = 'nothing'\n")
        self.guest.run("systemctl restart ninedotd", 60)
        started = time.monotonic()
        restarts, state = 0, ""
        while restarts <= START_LIMIT + 1 and state != "failed" and time.monotonic() - started < 2 * BACK_WITHIN_S:
            time.sleep(1)
            restarts, state = int(self.show("NRestarts")), self.show("ActiveState")
        took_s = time.monotonic() - started
        said = self.guest.check("journalctl -q -o cat -u ninedotd -n 20 --no-pager | grep 'source' | tail -n 1")
        self.configure(installed_page.PAGE)
        self.guest.check(f"rm {limit} {often} && systemctl daemon-reexec", 60)
        back_s = self.restart()
        self.stage.ok(
            "wrong-file",
            restarts > START_LIMIT + 1 and state != "failed" and f"{CONFIG}:2" in said,
            f"started again {restarts} times in {took_s:.0f} s, where systemd permits {START_LIMIT} by itself, and is {state} still; it says why: {said}; "
            f"right again {back_s:.1f} s after the file is",
        )


def run(stage):
    if os.geteuid() != 0:
        stage.leave_out("needs root, to make a Debian with the packages: sudo ./dev hil installed")
        return
    image = stage.out / "installed"
    made = subprocess.run([SOURCE / "tests" / "hil" / "installed_image.sh", SOURCE / "build/release/package", stage.out / "media", image])
    if made.returncode != 0:
        raise AssertionError("the image could not be made")
    extra = [
        "-drive", f"file={image / 'disk'},format=raw,if=virtio,snapshot=on",
        "-chardev", "socket,id=usb,path={folder}/usb,server=on,wait=off",
        "-device", "qemu-xhci",
        "-device", "usb-serial,chardev=usb",
    ]  # fmt: skip
    with Guest(image, stage.out / "console-installed.log", extra) as guest, Cable(guest.folder / "usb") as cable:
        test = Installed(stage, guest)
        test.out_of_the_box()
        if stage.smoke:
            return
        test.late_devices(cable)
        test.udev()
        test.sandbox()
        test.direct()
        test.wrong_file()
        page = PageOfInstalled(stage, guest, test)
        page.is_there()
        page.calibrates()
        page.applies()
