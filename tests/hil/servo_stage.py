"""The pan/tilt head on the kernel's own drivers: PWM registers, GPIO lines, the inhibit input, servo power after a crash."""

import math
import re
import statistics
import time

from service import GuestService

CHECKS = SMOKE_CHECKS = (
    "check",
    "pwm-neutral",
    "pwm-angles",
    "pwm-limit",
    "pwm-calibration",
    "power-on",
    "line-in-use",
    "inhibit",
    "inhibit-released",
    "led-tracking",
    "led-no-landmark",
    "led-no-camera",
    "power-off-at-exit",
    "pwm-off-at-exit",
    "power-off-after-kill",
    "restart-after-kill",
    "follows",
    "rests-without-landmark",
    "gpio-pulses",
    "absent",
)

# The chip counts 4096 steps in a period; its driver rounds a pulse up to the next.
PERIOD_US, STEPS = 20000, 4096
CHIP = "0-0040"
LED0_ON, BYTES_PER_CHANNEL, FULL_OFF = 0x06, 4, 0x1000  # NXP PCA9685 data sheet, 7.3.3
PAN, TILT = 0, 5
POWER, LED, INHIBIT, PAN_LINE, TILT_LINE = range(5)
NAMES = ("servo-power", "status-led", "inhibit", "pan-pulse", "tilt-pulse")
LANDMARK, NO_LANDMARK = 22, 33  # scenes: near the middle of the picture, and without one
STATUS_LIMIT, STATUS_INHIBITED, STATUS_FAULT, STATUS_HAS_HEAD = 1 << 5, 1 << 11, 1 << 12, 1 << 13
CALIBRATION = ((-30, 1900), (0, 1480), (30, 1150))
# Under emulation every edge costs a tenth of a millisecond or two: this is about the right pulses, not about their accuracy.
SHORTER_US, LONGER_US = 100, 600


def steps_of(pulse_us):
    return math.ceil(pulse_us * STEPS / PERIOD_US - 1e-9)


def config(*, scene, driver="sysfs-pwm", follow=False, tilt="", slew=360, camera=None):
    recording = f'source = "recording"\ndevice = "/tmp/scene{scene}"\nrate_hz = 10.0'
    return f"""[camera]
{camera or recording}
[modbus]
allow_writes = true
[modbus.tcp]
listen = "0.0.0.0"
[pan_tilt]
driver = "{driver}"
follow = {str(follow).lower()}
[pan_tilt.pan]
chip = "{CHIP}"
channel = {PAN}
line = "pan-pulse"
slew_deg_per_s = {slew}
neutral_deg = 5
[pan_tilt.tilt]
chip = "{CHIP}"
channel = {TILT}
line = "hil-lines:{TILT_LINE}"
slew_deg_per_s = {slew}
{tilt}
[gpio]
servo_power = "servo-power"
status_led = "hil-lines:{LED}"
inhibit = "inhibit"
"""


class ServoStage:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        guest.check("modprobe i2c-stub chip_addr=0x40 && modprobe pwm-pca9685 && modprobe i2c-dev && modprobe gpio-sim")
        self.bus = guest.check("grep -l stub /sys/bus/i2c/devices/i2c-*/name | sed 's/.*i2c-\\([0-9]*\\).*/\\1/'")
        # The chip of the tests is the one on this bus, whatever its number.
        self.chip = f"{self.bus}-0040"
        guest.check(f"echo pca9685 0x40 > /sys/bus/i2c/devices/i2c-{self.bus}/new_device")
        lines = "".join(f"mkdir bank/line{i} && echo {name} > bank/line{i}/name && " for i, name in enumerate(NAMES))
        guest.check(
            f"""mount -t configfs configfs /sys/kernel/config
            mkdir /sys/kernel/config/gpio-sim/hil && cd /sys/kernel/config/gpio-sim/hil && mkdir bank && echo 8 > bank/num_lines && echo hil-lines > bank/label && {lines} echo 1 > live"""
        )
        chip = guest.check("cat /sys/kernel/config/gpio-sim/hil/dev_name /sys/kernel/config/gpio-sim/hil/bank/chip_name").split()
        self.lines = f"/sys/devices/platform/{chip[0]}/{chip[1]}"
        guest.check("mkdir -p /sys/kernel/tracing; mount -t tracefs tracefs /sys/kernel/tracing")
        for scene in (LANDMARK, NO_LANDMARK):
            guest.check(
                f"""mkdir -p /tmp/scene{scene}/frames && cd /tmp/scene{scene} && cp /media/scenes/camera.yaml . &&
                cp /media/scenes/frames/{scene:06}.png frames/000000.png &&
                printf 'frame,timestamp_ns,pan_deg,tilt_deg\\n0,0,0,0\\n' > frames.csv"""
            )

    def config(self, **options):
        return config(**options).replace(CHIP, self.chip)

    def value(self, line):
        return int(self.guest.check(f"cat {self.lines}/sim_gpio{line}/value"))

    def pull(self, line, up):
        self.guest.check(f"echo pull-{'up' if up else 'down'} > {self.lines}/sim_gpio{line}/pull")

    def pulses(self):
        """\\return  for pan and tilt: steps that the chip's registers keep the output high, 0 when it is off"""
        found = []
        for channel in (PAN, TILT):
            first = LED0_ON + BYTES_PER_CHANNEL * channel
            text = self.guest.check(
                f"for r in {' '.join(hex(first + i) for i in range(4))}; do i2cget -f -y {self.bus} 0x40 $r; done"
            )
            on_low, on_high, off_low, off_high = (int(word, 16) for word in text.split())
            on, off = on_high << 8 | on_low, off_high << 8 | off_low
            found.append(0 if off & FULL_OFF else (off - on) % STEPS)
        return tuple(found)

    def aim(self, pan_deg, tilt_deg):
        return self.guest.run(f"ninedot aim --pan-deg {pan_deg} --tilt-deg {tilt_deg}")

    def head_of(self, service):
        registers = service.read()
        return *registers.head_deg, registers.word(4)

    def by_hand(self):
        service = GuestService(self.guest, self.config(scene=LANDMARK))
        with service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            neutral, expected = self.pulses(), (steps_of(1550), steps_of(1500))
            self.stage.ok(
                "pwm-neutral",
                neutral == expected and self.head_of(service)[2] & STATUS_HAS_HEAD,
                f"at the start: pan {neutral[0]}, tilt {neutral[1]} of {STEPS} steps for 1550 and 1500 us",
            )
            self.stage.ok("power-on", self.value(POWER) == 1, "the servo power line is active")
            rows, good = [], True
            for pan, tilt in ((0, 0), (-30, 20), (12.5, -7.25), (45, -45), (-45, 45)):
                status, text = self.aim(pan, tilt)
                seen, wanted = self.pulses(), tuple(steps_of(1500 + 10 * angle) for angle in (pan, tilt))
                stands = self.head_of(service)
                good &= status == 0 and seen == wanted and abs(stands[0] - pan) < 0.011 and abs(stands[1] - tilt) < 0.011
                rows.append(
                    (
                        f"{pan} / {tilt}",
                        f"{stands[0]:.2f} / {stands[1]:.2f}",
                        f"{seen[0]} / {seen[1]}",
                        f"{wanted[0]} / {wanted[1]}",
                    )
                )
            self.stage.table(
                "`ninedot aim` and the PWM chip's registers (pan / tilt)",
                ("asked for [deg]", "registers 37, 38 [deg]", "chip [steps of 4096]", "expected"),
                rows,
            )
            self.stage.ok(
                "pwm-angles", good, f"{len(rows)} positions: the chip's registers hold the pulses to one step of 4.9 us"
            )
            self.aim(80, -80)
            service.wait_for(lambda registers: registers.word(4) & STATUS_LIMIT, "the status bit servo_limit", 10)
            seen = self.pulses()
            self.stage.ok(
                "pwm-limit",
                seen == (steps_of(1950), steps_of(1050)),
                f"80 and -80 deg: stays at 45 and -45 ({seen[0]}, {seen[1]} steps), servo_limit is set",
            )
            self.aim(0, 0)
            status, text = self.guest.run("ninedot check --config /tmp/ninedotd.toml")
            self.stage.ok(
                "line-in-use",
                status == 2 and "servo-power" in text and "ninedot" in text.split("servo-power", 1)[1],
                f"status {status}: {text.splitlines()[0] if text else ''}",
            )
            self.led("led-tracking", service, 1.0, "the landmark is in sight: lit")
        self.stage.ok("power-off-at-exit", self.value(POWER) == 0, "the line is inactive after SIGINT")
        off = self.pulses()
        exported = self.guest.run("ls -d /sys/class/pwm/pwmchip*/pwm[0-9]*")[0] == 0
        self.stage.ok("pwm-off-at-exit", off == (0, 0) and not exported, "both outputs are off, the channels given back")

    def led(self, check, service, share, what):
        """Looks at the line for two of its patterns' two seconds."""
        text = self.guest.check(
            f"""seconds() {{ cut -d. -f1 /proc/uptime; }}
            end=$(($(seconds) + 5)); while [ $(seconds) -lt $end ]; do cat {self.lines}/sim_gpio{LED}/value; usleep 20000; done"""
        )
        values = [int(word) for word in text.split()]
        lit = sum(values) / len(values)
        self.stage.ok(
            check,
            abs(lit - share) < min(0.1, 0.7 * share) and len(values) > 50,
            f"{what}; lit for {100 * lit:.0f} % of the time, {100 * share:.0f} % expected",
        )

    def calibrated(self):
        table = ", ".join(f"[{angle}, {pulse}]" for angle, pulse in CALIBRATION)
        with GuestService(self.guest, self.config(scene=LANDMARK, tilt=f"calibration = [{table}]")) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            good, seen = True, []
            for angle, pulse in (*CALIBRATION, (15, (1480 + 1150) / 2), (-15, (1900 + 1480) / 2)):
                self.aim(0, angle)
                seen.append(self.pulses()[1])
                good &= seen[-1] == steps_of(pulse)
            self.stage.ok("pwm-calibration", good, f"the points of a calibration table and between them: {seen} steps")

    def inhibited(self):
        """A slow turn is interrupted."""
        with GuestService(self.guest, self.config(scene=LANDMARK, slew=10)) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            for first, values in ((105, [4000, 0]), (100, [2, 1])):  # set-points, then the order to go there
                reply = service.client.client.write_registers(first, values, **service.client.unit)
                if reply.isError():
                    raise AssertionError(f"refused: {reply}")
            service.wait_for(lambda registers: self.head_of(service)[0] > 10, "on its way to 40 deg", 20)
            self.pull(INHIBIT, True)
            service.wait_for_frames(2)
            stopped, (angle, _, status) = self.pulses(), self.head_of(service)
            valid = service.wait_for_frames(15).valid
            later = self.pulses()
            self.stage.ok(
                "inhibit",
                stopped == later and 10 < angle < 40 and status & STATUS_INHIBITED and valid,
                f"on its way from 5 to 40 deg: stands at {angle:.1f} deg two frames after the edge and 15 frames later, "
                "status bit set, poses go on",
            )
            self.pull(INHIBIT, False)
            service.wait_for(lambda registers: self.head_of(service)[0] >= 39.9, "goes on to 40 deg", 30)
            self.stage.ok(
                "inhibit-released",
                self.pulses()[0] == steps_of(1900) and not self.head_of(service)[2] & STATUS_INHIBITED,
                "released: goes on to 40 deg",
            )

    def killed(self):
        service = GuestService(self.guest, self.config(scene=LANDMARK))
        try:
            with service:
                service.wait_for(lambda registers: registers.valid, "a valid pose")
                active = self.value(POWER)
                text = self.guest.check(
                    f"""before=$(cut -d' ' -f1 /proc/uptime); killall -KILL ninedotd
                    for _ in $(seq 200); do [ $(cat {self.lines}/sim_gpio{POWER}/value) = 0 ] && break; usleep 5000; done
                    cat {self.lines}/sim_gpio{POWER}/value; echo $before $(cut -d' ' -f1 /proc/uptime)"""
                ).split()
        except AssertionError:
            if service.exit_status != "137":  # 128 + SIGKILL, which is what this is about
                raise
        took = float(text[2]) - float(text[1])
        self.stage.ok(
            "power-off-after-kill",
            active == 1 and text[0] == "0" and took < 1,
            f"the line is inactive {took:.2f} s after SIGKILL (resolution 0.01 s)",
        )
        with GuestService(self.guest, self.config(scene=LANDMARK)) as again:
            again.wait_for(lambda registers: registers.valid, "a valid pose")
            self.aim(-20, 10)
            self.stage.ok(
                "restart-after-kill",
                self.pulses() == (steps_of(1300), steps_of(1600)) and self.value(POWER) == 1,
                "starts although the killed one left its PWM channels behind, and moves the head",
            )

    def following(self):
        """The picture does not turn with the head here, so it goes on until its limit."""
        with GuestService(self.guest, self.config(scene=LANDMARK, follow=True)) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            registers, seconds = service.wait_for(
                lambda registers: registers.word(4) & STATUS_LIMIT, "the head reaches its limit", 30
            )
            self.stage.ok(
                "follows",
                self.pulses() != (steps_of(1550), steps_of(1500)),
                f"a landmark beside the middle: the head moves, PWM {self.pulses()}",
            )
        with GuestService(self.guest, self.config(scene=NO_LANDMARK, follow=True)) as service:
            service.wait_for_frames(10)
            self.stage.ok(
                "rests-without-landmark", self.pulses() == (steps_of(1550), steps_of(1500)), "no landmark: stands at neutral"
            )
            self.led("led-no-landmark", service, 0.5, "no landmark: blinks")
        camera = 'source = "v4l2"\ndevice = "/dev/video9"\nwait_for_device = true\ncalibration = "/media/scenes/camera.yaml"'
        with GuestService(self.guest, self.config(scene=LANDMARK, camera=camera)) as service:
            self.led("led-no-camera", service, 0.1, "no camera: two flashes in two seconds")

    def pulses_by_software(self):
        """Their widths as the kernel's trace of line changes shows them."""
        with GuestService(self.guest, self.config(scene=LANDMARK, driver="gpio")) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            rows, good, medians = [], True, {}
            for pan, tilt in ((0, 0), (30, -30), (-30, 30)):
                self.aim(pan, tilt)
                self.guest.check(
                    """cd /sys/kernel/tracing && echo > trace && echo 1 > events/gpio/gpio_value/enable && sleep 2 &&
                    echo 0 > events/gpio/gpio_value/enable && cp trace /tmp/trace"""
                )
                widths = self.traced_widths(self.guest.fetch("/tmp/trace").decode())
                for axis, angle in ((PAN_LINE, pan), (TILT_LINE, tilt)):
                    wanted = 1500 + 10 * angle
                    median = medians[axis, angle] = statistics.median(widths[axis]) if widths[axis] else 0
                    good &= len(widths[axis]) > 50 and wanted - SHORTER_US < median < wanted + LONGER_US
                    rows.append((NAMES[axis], angle, len(widths[axis]), f"{median:.0f}", wanted))
            spans = [medians[axis, 30] - medians[axis, -30] for axis in (PAN_LINE, TILT_LINE)]
            good &= all(300 < span < 1000 for span in spans)
            words = service.client.read(86, 2)
            self.stage.table(
                "Software-made pulses, traced in the kernel for 2 s",
                ("line", "angle [deg]", "pulses", "median width [us]", "wanted [us]"),
                rows,
            )
            self.stage.ok(
                "gpio-pulses",
                good,
                f"{sum(row[2] for row in rows)} pulses on two lines; from -30 to 30 deg they grow by {spans[0]:.0f} and {spans[1]:.0f} us "
                f"(600 wanted); the service's own measure: p99 {words[0]} us, largest {words[1]}",
            )

    def traced_widths(self, trace):
        """Lines are numbered across all chips in the trace: the two that change are the pulses, pan's number is the lower one."""
        changes = {}
        for seconds, line, value in re.findall(r"(\d+\.\d+): gpio_value: (\d+) set (\d)", trace):
            changes.setdefault(int(line), []).append((float(seconds) * 1e6, int(value)))
        pulsing = sorted(line for line in changes if len(changes[line]) > 100)
        widths = {PAN_LINE: [], TILT_LINE: []}
        for axis, line in zip((PAN_LINE, TILT_LINE), pulsing):
            for (rise, high), (fall, low) in zip(changes[line], changes[line][1:]):
                if high and not low:
                    widths[axis].append(fall - rise)
        return widths

    def absent(self):
        notes = []
        for present, missing in ((f'"{self.chip}"', '"fe20c000.pwm"'), ('"inhibit"', '"no-such-line"')):
            self.guest.write("/tmp/absent.toml", self.config(scene=LANDMARK).replace(present, missing))
            status, text = self.guest.run("ninedot check --config /tmp/absent.toml")
            found = [line for line in text.splitlines() if "note: waits for it: " in line and missing.strip('"') in line]
            notes.append(status == 0 and bool(found) and found[0])
        self.stage.ok("absent", all(notes) and self.chip in notes[0], "; ".join(str(note) for note in notes))

    def run(self):
        self.guest.write("/tmp/check.toml", self.config(scene=LANDMARK))
        status, text = self.guest.run("ninedot check --config /tmp/check.toml")
        self.stage.ok("check", status == 0, "`ninedot check` finds chip and lines" if status == 0 else text)
        self.absent()
        self.by_hand()
        self.calibrated()
        self.inhibited()
        self.killed()
        self.following()
        self.pulses_by_software()


def run(stage):
    with stage.guest() as guest:
        ServoStage(stage, guest).run()
