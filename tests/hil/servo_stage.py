"""The pan/tilt head on the kernel's own drivers: PWM registers, GPIO lines, the inhibit input, servo power after a crash."""

import math
import re
import time

from registers import STATUS_FAULT, STATUS_HAS_HEAD, STATUS_INHIBITED, STATUS_LIMIT
from service import GuestService
from tracing import Trace

SMOKE_CHECKS = (
    "check",
    "pwm-neutral",
    "pwm-angles",
    "power-on",
    "line-in-use",
    "led-tracking",
    "power-off-at-exit",
    "pwm-off-at-exit",
)
CHECKS = SMOKE_CHECKS + (
    "pwm-limit",
    "pwm-calibration",
    "inhibit",
    "inhibit-released",
    "led-no-landmark",
    "led-no-camera",
    "power-off-after-kill",
    "pwm-after-kill",
    "ramp-after-kill",
    "restart-after-kill",
    "follows",
    "rests-without-landmark",
    "gpio-pulses",
    "gpio-jitter",
    "absent",
    "i2c-registers",
    "i2c-angles",
    "i2c-inhibit",
    "i2c-off-at-exit",
    "i2c-after-kill",
    "i2c-goes-on",
    "i2c-restart",
    "i2c-supply",
    "i2c-in-use",
)

# The chip counts 4096 steps in a period; its driver rounds a pulse up to the next.
PERIOD_US, STEPS = 20000, 4096
CHIP = "0-0040"
LED0_ON, BYTES_PER_CHANNEL, FULL_OFF = 0x06, 4, 0x1000  # NXP PCA9685 data sheet, 7.3.3
SLEEP = 0x10  # 7.3.1
MODE1, MODE2, PRE_SCALE = 0x00, 0x01, 0xFE
PAN, TILT = 0, 5
POWER, LED, INHIBIT, PAN_LINE, TILT_LINE, OUTPUT_ENABLE = range(6)
NAMES = ("servo-power", "status-led", "inhibit", "pan-pulse", "tilt-pulse", "output-enable")
LANDMARK, NO_LANDMARK = 22, 33  # scenes: near the middle of the picture, and without one
LEFT_AT_DEG = (30, -20)  # where the service is killed
# Slow enough for a jump of 20 degrees to stand out, in spite of wake-ups that come a quarter of a second late.
RAMP_DEG_PER_S, RAMP_AHEAD_DEG = 20, 5
CALIBRATION = ((-30, 1900), (0, 1480), (30, 1150))
# Under emulation an edge costs a tenth of a millisecond, and late wake-ups come on top of most pulses: the shortest one tells what
# width was meant. Measured: 80 to 110 us too long on a host with eight other things to do on two processors.
SHORTER_US, LONGER_US = 20, 250
# Of a head that turns by 10 deg/s, so by 20 steps in a second: what comes half a second late. A jump to neutral is 51 and 20 steps.
SLOW_STEPS = 10


def steps_of(pulse_us):
    return math.ceil(pulse_us * STEPS / PERIOD_US - 1e-9)


def quantiles(values, *shares):
    ordered = sorted(values) or [math.nan]
    return [ordered[min(int(share * len(ordered)), len(ordered) - 1)] for share in shares]


def i2c_steps_of(pulse_us):
    """Of our own driver, which takes the nearest: 25 MHz, divided by 122 for 20 ms."""
    return math.floor(pulse_us * 25 / 122 + 0.5)


def registers_of(guest, bus, addresses, i2cget="i2cget"):
    """\\return  the chip's bytes at these addresses"""
    text = guest.check(f"for r in {' '.join(map(hex, addresses))}; do {i2cget} -f -y {bus} 0x40 $r; done")
    return [int(word, 16) for word in text.split()]


def outputs_of(guest, bus, i2cget="i2cget"):
    """\\return  for pan and tilt: steps that the chip's registers keep the output high, 0 when it is off"""
    found = []
    for channel in (PAN, TILT):
        first = LED0_ON + BYTES_PER_CHANNEL * channel
        on_low, on_high, off_low, off_high = registers_of(guest, bus, range(first, first + BYTES_PER_CHANNEL), i2cget)
        on, off = on_high << 8 | on_low, off_high << 8 | off_low
        found.append(0 if off & FULL_OFF else (off - on) % STEPS)
    return tuple(found)


def config(*, scene, driver="sysfs-pwm", head="", follow=False, tilt="", slew=360, camera=None):
    recording = f'source = "recording"\ndevice = "/tmp/scene{scene}"\nrate_hz = 10.0'
    return f"""[camera]
{camera or recording}
[modbus]
allow_writes = true
[modbus.tcp]
listen = "0.0.0.0"
[pan_tilt]
driver = "{driver}"
{head}
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
        self.trace = Trace(guest)
        # Traces number lines across all chips.
        guest.check("mkdir -p /sys/kernel/debug; mount -t debugfs debugfs /sys/kernel/debug 2> /dev/null; true")
        self.first_line = int(guest.check("sed -n 's/.*GPIOs \\([0-9]*\\)-.*hil-lines.*/\\1/p' /sys/kernel/debug/gpio"))
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
        return outputs_of(self.guest, self.bus)

    def aim(self, pan_deg, tilt_deg):
        return self.guest.run(f"ninedot aim --pan-deg {pan_deg} --tilt-deg {tilt_deg}")

    def head_of(self, service):
        registers = service.read()
        return *registers.head_deg, registers.word(4)

    def events(self):
        """What trace.start("pwm/pwm_apply", "gpio/gpio_value") saw: ("power", value) and ("pwm", channel, duty in us, enabled)."""
        found = []
        for line, value, pwm, duty, enabled in re.findall(
            r"gpio_value: (\d+) set (\d)|pwm_apply: (\S+): period=\d+ duty_cycle=(\d+) .*enabled=(\d)", self.trace.stop()
        ):
            if pwm:
                found.append(("pwm", pwm, int(duty) / 1000, enabled == "1"))
            elif int(line) == self.first_line + POWER:
                found.append(("power", int(value)))
        return found

    def by_hand(self):
        service = GuestService(self.guest, self.config(scene=LANDMARK))
        self.trace.start("pwm/pwm_apply", "gpio/gpio_value")
        with service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            events = self.events()
            neutral, expected = self.pulses(), (steps_of(1550), steps_of(1500))
            self.stage.ok(
                "pwm-neutral",
                neutral == expected and self.head_of(service)[2] & STATUS_HAS_HEAD,
                f"at the start: pan {neutral[0]}, tilt {neutral[1]} of {STEPS} steps for 1550 and 1500 us",
            )
            on_at = events.index(("power", 1)) if ("power", 1) in events else 0
            standing = {event[2] for event in events[:on_at] if event[0] == "pwm" and event[3]}
            self.stage.ok(
                "power-on",
                self.value(POWER) == 1 and {1550, 1500} <= standing,
                f"the servo power line becomes active after the pulses stand at {sorted(standing)} us",
            )
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
            angles_kept = seen == (steps_of(1950), steps_of(1050))
            limits = f"80 and -80 deg: stays at 45 and -45 ({seen[0]}, {seen[1]} steps), servo_limit is set"
            self.angles_kept = (angles_kept, limits)
            self.aim(0, 0)
            status, text = self.guest.run("ninedot check --config /tmp/ninedotd.toml")
            held = [line for line in text.splitlines() if "a ninedotd is running" in line and "'servo-power' is in use by 'ninedot'" in line]
            self.stage.ok("line-in-use", status == 0 and held, f"status {status}: {held or text}")
            self.led("led-tracking", service, 1.0, "the landmark is in sight: lit")
            self.trace.start("pwm/pwm_apply", "gpio/gpio_value")
        events = self.events()
        # The chip's driver switches a channel off that is given back; others do not: the service has to do it.
        disabled = {event[1] for event in events if event[0] == "pwm" and not event[3]}
        off_at = events.index(("power", 0)) if ("power", 0) in events else len(events)
        self.stage.ok(
            "power-off-at-exit",
            self.value(POWER) == 0 and not any(event[0] == "pwm" and not event[3] for event in events[:off_at]),
            "the line is inactive after SIGINT, and was so before the pulses ended",
        )
        off = self.pulses()
        exported = self.guest.run("ls -d /sys/class/pwm/pwmchip*/pwm[0-9]*")[0] == 0
        self.stage.ok(
            "pwm-off-at-exit",
            off == (0, 0) and not exported and len(disabled) == 2,
            f"{len(disabled)} channels disabled by the service, both outputs are off, the channels given back",
        )

    def led(self, check, service, share, what):
        """Looks at the line for four of its patterns' two seconds."""
        text = self.guest.check(
            f"""look() {{ read up idle < /proc/uptime; read value < {self.lines}/sim_gpio{LED}/value; echo $up $value; now=${{up%.*}}; }}
            look; end=$((now + 8)); while [ $now -lt $end ]; do usleep 10000; look; done"""
        )
        seen = [(float(when), int(value)) for when, value in (line.split() for line in text.splitlines())]
        # By time and not by looks, which a busy host makes at any intervals.
        spans = [(after - when, value) for (when, value), (after, _) in zip(seen, seen[1:])]
        lit = sum(span * value for span, value in spans) / sum(span for span, _ in spans)
        self.stage.ok(
            check,
            abs(lit - share) < min(0.1, 0.7 * share) and len(seen) > 50,
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

        # Limits of the pulses that lie within those of the angles.
        with GuestService(self.guest, self.config(scene=LANDMARK, tilt="min_us = 1200\nmax_us = 1700")) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            cut = []
            for tilt in (45, -45):
                self.aim(0, tilt)
                limited = service.wait_for_frames(3).word(4) & STATUS_LIMIT
                cut.append((self.pulses()[1], bool(limited)))
                self.aim(0, 0)
            self.stage.ok(
                "pwm-limit",
                self.angles_kept[0] and cut == [(steps_of(1700), True), (steps_of(1200), True)],
                f"{self.angles_kept[1]}; pulses of 1200 to 1700 us at 45 and -45 deg: {cut} steps and limited",
            )

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
            valid = service.wait_for_frames(15).valid_when_taken
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
                self.aim(*LEFT_AT_DEG)
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
        left = self.pulses()
        self.stage.ok(
            "pwm-after-kill",
            left == tuple(steps_of(1500 + 10 * angle) for angle in LEFT_AT_DEG),
            f"sent to {LEFT_AT_DEG} deg before: the chip goes on with {left} steps and nobody to tell it",
        )
        self.goes_on()
        with GuestService(self.guest, self.config(scene=LANDMARK)) as again:
            again.wait_for(lambda registers: registers.valid, "a valid pose")
            self.aim(-20, 10)
            self.stage.ok(
                "restart-after-kill",
                self.pulses() == (steps_of(1300), steps_of(1600)) and self.value(POWER) == 1,
                "starts although the killed one left its PWM channels behind, and moves the head",
            )

    def goes_on(self):
        """From where the killed one left the head, at the speed that is configured."""
        self.trace.start("pwm/pwm_apply")
        with GuestService(self.guest, self.config(scene=LANDMARK, slew=RAMP_DEG_PER_S)) as service:
            service.wait_for(lambda registers: self.head_of(service)[:2] == (5, 0), "the head at neutral", 30)
            ways = self.traced_ways()
        # The kernel says nothing of a pulse that is set once more: the first to be told is the first step from there.
        first_us, last_us = (sorted(way[at][1] for way in ways.values()) for at in (0, -1))
        left_us = sorted(1500 + 10 * angle for angle in LEFT_AT_DEG)
        # In degrees beyond what the time since the pulse before, or since the first one, allows.
        ahead_deg = max(
            (
                abs(us - from_us) / 10 - RAMP_DEG_PER_S * (at_s - from_s)
                for way in ways.values()
                for before, (at_s, us) in zip(way, way[1:])
                for from_s, from_us in (before, way[0])
            ),
            default=math.nan,
        )
        self.stage.ok(
            "ramp-after-kill",
            len(first_us) == 2
            and all(abs(first - left) / 10 < RAMP_AHEAD_DEG for first, left in zip(first_us, left_us))
            and last_us == [1500, 1550]
            and ahead_deg < RAMP_AHEAD_DEG,
            f"left at {left_us} us: the first pulses {first_us}, the last ones {last_us}, {sum(map(len, ways.values()))} in all; "
            f"no more than {ahead_deg:.2f} deg ahead of {RAMP_DEG_PER_S} deg/s",
        )

    def traced_ways(self):
        """\\return  for each channel that runs its pulses as they were set: (time [s], width [us])"""
        ways = {}
        for seconds, channel, duty_ns in re.findall(
            r" (\d+\.\d+): pwm_apply: (\S+): period=\d+ duty_cycle=(\d+) .*enabled=1", self.trace.stop()
        ):
            ways.setdefault(channel, []).append((float(seconds), int(duty_ns) / 1000))
        return ways

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
        """Their widths as the kernel's trace of line changes shows them, beside the service's own measure."""
        with GuestService(self.guest, self.config(scene=LANDMARK, driver="gpio")) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            rows, good, errors_us, surplus = [], True, [], []
            for pan, tilt in ((0, 0), (30, -30), (-30, 30)):
                self.aim(pan, tilt)
                self.trace.start("gpio/gpio_value")
                time.sleep(4)
                widths = self.traced_widths(self.trace.stop())
                for axis, angle in ((PAN_LINE, pan), (TILT_LINE, tilt)):
                    wanted = 1500 + 10 * angle
                    shortest, tenth, median = quantiles(widths[axis], 0, 0.1, 0.5)
                    errors_us += [width - wanted for width in widths[axis]]
                    surplus.append(shortest - wanted)
                    good &= len(widths[axis]) > 50 and -SHORTER_US < shortest - wanted < LONGER_US
                    rows.append((NAMES[axis], angle, len(widths[axis]), f"{shortest:.0f}", f"{tenth:.0f}", f"{median:.0f}", wanted))
            p99, largest = service.client.read(86, 2)
            self.stage.table(
                "Software-made pulses, traced in the kernel for 4 s",
                ("line", "angle [deg]", "pulses", "shortest [us]", "10 % are shorter than", "median", "wanted"),
                rows,
            )
            self.stage.ok(
                "gpio-pulses",
                good,
                f"{len(errors_us)} pulses on two lines; the shortest of each {min(surplus):.0f} to {max(surplus):.0f} us too long ({-SHORTER_US} to {LONGER_US})",
            )
            traced_p99, traced_largest = quantiles([abs(error) for error in errors_us], 0.99, 1)
            # It measures since its start, so its largest is no smaller than any that was traced; a clock is read after each edge.
            self.stage.ok(
                "gpio-jitter",
                largest > 0.9 * min(traced_largest, 65535) - 100 and min(traced_p99, 65535) / 3 < p99 < max(5 * traced_p99, 1000),
                f"the service's own measure since its start: p99 {p99} us, largest {largest}; "
                f"traced meanwhile: {traced_p99:.0f} and {traced_largest:.0f}",
            )

    def traced_widths(self, trace):
        """\\return  [us] of the whole pulses on the two lines"""
        widths = {}
        for axis in (PAN_LINE, TILT_LINE):
            line = self.first_line + axis
            changes = [
                (float(seconds) * 1e6, value == "1")
                for seconds, value in re.findall(rf"(\d+\.\d+): gpio_value: {line} set (\d)", trace)
            ]
            widths[axis] = [fall - rise for (rise, high), (fall, low) in zip(changes, changes[1:]) if high and not low]
        return widths

    def over_i2c(self):
        """The same chip without the kernel's driver, down to its registers."""
        head = f'device = "/dev/i2c-{self.bus}"\noutput_enable = "hil-lines:{OUTPUT_ENABLE}"'
        options = dict(scene=LANDMARK, driver="pca9685", head=head)
        self.guest.write("/tmp/in-use.toml", self.config(**options))
        status, text = self.guest.run("ninedot check --config /tmp/in-use.toml")
        note = [line for line in text.splitlines() if "a driver of the kernel has the chip at 0x40" in line]
        self.stage.ok("i2c-in-use", status == 0 and note, "; ".join(note) or text)
        self.guest.check(f"echo 0x40 > /sys/bus/i2c/devices/i2c-{self.bus}/delete_device")
        self.pull(OUTPUT_ENABLE, True)  # the resistor to "off"
        self.power_up_chip()
        before = self.chip_state()
        with GuestService(self.guest, self.config(**options)) as service:
            service.wait_for(lambda registers: registers.valid, "a valid pose")
            mode = self.registers(MODE1, MODE2, PRE_SCALE)
            neutral = self.chip_state()
            self.stage.ok(
                "i2c-registers",
                before == (FULL_OFF, FULL_OFF, 1)
                and mode == [0x20, 0x04, 121]
                and neutral == (i2c_steps_of(1550), i2c_steps_of(1500), 0),
                f"MODE1, MODE2, PRE_SCALE {mode}; outputs {neutral[:2]} of {STEPS} steps for 1550 and 1500 us, OE low",
            )
            seen, wanted = [], []
            for pan, tilt in ((0, 0), (-30, 20), (12.5, -7.25), (45, -45), (-45, 45)):
                self.aim(pan, tilt)
                seen.append(self.chip_state())
                wanted.append((i2c_steps_of(1500 + 10 * pan), i2c_steps_of(1500 + 10 * tilt), 0))
            self.stage.ok("i2c-angles", seen == wanted, f"{len(seen)} positions: {[state[:2] for state in seen]} steps")
            self.pull(INHIBIT, True)
            service.wait_for(lambda registers: registers.word(4) & STATUS_INHIBITED, "inhibited", 10)
            service.wait_for_frames(2)
            inhibited = self.chip_state()
            self.pull(INHIBIT, False)
            service.wait_for(lambda registers: not registers.word(4) & STATUS_INHIBITED, "released", 10)
            service.wait_for_frames(2)
            self.stage.ok(
                "i2c-inhibit",
                inhibited == (FULL_OFF, FULL_OFF, 1) and self.chip_state() == wanted[-1],
                f"outputs {[hex(value) for value in inhibited[:2]]}, OE {inhibited[2]}; released: {self.chip_state()}",
            )
            self.power_up_chip()
            back = self.wait_for_state(wanted[-1])
            service.wait_for(lambda registers: not registers.word(4) & STATUS_FAULT, "no servo_fault", 10)
            self.stage.ok("i2c-supply", back is not None, f"a chip that forgot everything has its pulses back after {back} s")
        ended = self.chip_state()
        self.stage.ok("i2c-off-at-exit", ended == (FULL_OFF, FULL_OFF, 1), f"outputs {ended[:2]}, OE {ended[2]}")
        service = GuestService(self.guest, self.config(**options))
        try:
            with service:
                service.wait_for(lambda registers: registers.valid, "a valid pose")
                self.aim(-20, 10)
                self.guest.check("killall -KILL ninedotd; sleep 0.5")
        except AssertionError:
            if service.exit_status != "137":
                raise
        killed = self.chip_state()
        self.stage.ok(
            "i2c-after-kill",
            killed == (i2c_steps_of(1300), i2c_steps_of(1600), 1) and self.value(POWER) == 0,
            f"the registers keep the last pulses {killed[:2]}; OE is pulled to {killed[2]}, and the servos' power is off",
        )
        # So slowly that a ramp and a jump are easily told apart.
        self.trace.start("smbus/smbus_write")
        with GuestService(self.guest, self.config(**options, slew=10)) as again:
            again.wait_for(lambda registers: registers.valid, "a valid pose")
            back = self.wait_for_state(neutral)
            pulses, paused = self.traced_pulses(self.trace.stop())
            ramps = [
                bool(way) and all(abs(after - before) <= SLOW_STEPS for before, after in zip((start, *way), way))
                for start, way in zip(killed, (pulses[PAN], pulses[TILT]))
            ]
            self.stage.ok(
                "i2c-goes-on",
                all(ramps) and not paused and back is not None,
                f"from {killed[:2]} to {neutral[:2]} in {len(pulses[PAN])} and {len(pulses[TILT])} writes of {SLOW_STEPS} steps at most; "
                f"the chip slept or was switched off {paused} times",
            )
            self.aim(-20, 10)
            state = self.chip_state()
            self.stage.ok(
                "i2c-restart", state == (i2c_steps_of(1300), i2c_steps_of(1600), 0), f"takes over the chip: {state[:2]} steps"
            )

    def traced_pulses(self, trace):
        """\\return  by channel the widths [steps] that were written, and how often the chip was told to sleep or to switch one off"""
        pulses, paused = {PAN: [], TILT: []}, 0
        # The kernel shows a block with its length before it.
        for register, kind, text in re.findall(r"smbus_write: i2c-\d+ a=040 f=\w+ c=(\w+) (\w+) l=\d+ \[([\w-]*)\]", trace):
            address, values = int(register, 16), [int(value, 16) for value in text.split("-")]
            if address == MODE1 and kind == "BYTE_DATA":
                paused += bool(values[0] & SLEEP)
            for channel in pulses:
                if address == LED0_ON + BYTES_PER_CHANNEL * channel:
                    off = values[4] << 8 | values[3]
                    paused += bool(off & FULL_OFF)
                    pulses[channel].append(off)
        return pulses, paused

    def registers(self, *addresses):
        return registers_of(self.guest, self.bus, addresses)

    def chip_state(self):
        """\\return  for pan and tilt LEDn_OFF less LEDn_ON, FULL_OFF where that bit is set; and the level of the OE pin"""
        state = []
        for channel in (PAN, TILT):
            first = LED0_ON + BYTES_PER_CHANNEL * channel
            on_low, on_high, off_low, off_high = self.registers(*range(first, first + 4))
            off = off_high << 8 | off_low
            state.append(FULL_OFF if off & FULL_OFF else off - (on_high << 8 | on_low))
        return (*state, self.value(OUTPUT_ENABLE))

    def power_up_chip(self):
        """What the data sheet's table 4 says the registers hold then."""
        values = {MODE1: 0x11, MODE2: 0x04, PRE_SCALE: 0x1E}
        for channel in (PAN, TILT):
            first = LED0_ON + BYTES_PER_CHANNEL * channel
            values.update({first: 0, first + 1: 0, first + 2: 0, first + 3: FULL_OFF >> 8})
        self.guest.check(
            " && ".join(f"i2cset -f -y {self.bus} 0x40 {hex(address)} {hex(value)}" for address, value in values.items())
        )

    def wait_for_state(self, wanted, within_s=10.0):
        """\\return  seconds, rounded; None: never"""
        started = time.monotonic()
        while time.monotonic() - started < within_s:
            if self.chip_state() == wanted:
                return round(time.monotonic() - started, 1)
        return None

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
        self.by_hand()
        if self.stage.smoke:
            return
        self.absent()
        self.calibrated()
        self.inhibited()
        self.killed()
        self.following()
        self.pulses_by_software()
        self.over_i2c()


def run(stage):
    with stage.guest() as guest:
        ServoStage(stage, guest).run()
