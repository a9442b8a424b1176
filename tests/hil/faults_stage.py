"""Every fault that vivid can inject, unplugging, and a camera that is not there: the service lives on, says that it is not valid, and
recovers by itself."""

import threading
import time

from registers import REASON_CAMERA_LOST
from service import GuestService, camera_config
from tracing import Trace, frames_of
from vivid import CAPTURE, RATE_HZ, Vivid

STILL = "/media/stills/10.raw"
CAMERA = "/tmp/camera"  # a link as udev makes them: where it leads is plugged in
STALL_FRAMES = 30
RATE_TOLERANCE = 0.15  # of a busy host; frames that nobody counts, or a wrap that counts as a gap, are far beyond it
UNBIND, BIND = "/sys/bus/platform/drivers/vivid/unbind", "/sys/bus/platform/drivers/vivid/bind"


class Watch:
    """What the registers showed from the fault on."""

    def __init__(self, service):
        self.service = service
        self.started = time.monotonic()
        self.before = self.last = service.read()
        self.reasons = []  # in order of appearance, without repetition in a row; 0: valid
        self.lost_at = None  # the first read that said camera lost
        self.back_at = None  # the first one after the last of them
        self.sums = []  # (when, frames accounted for), at each change
        self.ages_ms = []  # while the camera was lost

    def look(self):
        registers = self.last = self.service.read()
        now = time.monotonic()
        if not self.reasons or self.reasons[-1] != registers.reason:
            self.reasons.append(registers.reason)
        total = registers.processed + registers.dropped + registers.failed
        if not self.sums or self.sums[-1][1] != total:
            self.sums.append((now, total))
        if registers.reason != REASON_CAMERA_LOST:
            self.back_at = self.back_at or now
        else:
            self.lost_at = self.lost_at or now
            self.back_at = None
            self.ages_ms.append(registers.age_ms)
            if registers.valid:
                raise AssertionError("a lost camera's pose is called valid")
        time.sleep(0.01)
        return registers

    def until(self, condition, what, within_s=30.0):
        """\\return  seconds"""
        started = time.monotonic()
        while not condition(self.look()):
            if time.monotonic() - started > within_s:
                raise AssertionError(
                    f"not within {within_s:.0f} s: {what}; reasons seen {self.reasons}; log:\n{self.service.log()}"
                )
        return time.monotonic() - started

    def during(self, command, guest, timeout_s=60):
        """Runs a command in the guest and goes on looking."""
        failure = []

        def work():
            try:
                guest.check(command, timeout_s)
            except Exception as error:
                failure.append(error)

        thread = threading.Thread(target=work)
        thread.start()
        while thread.is_alive():
            self.look()
        thread.join()
        if failure:
            raise failure[0]

    def frames_per_s(self):
        """Processed, dropped and failed together. The counters are published about once a second: the slope through the edges."""
        edges = self.sums[1:]
        middle_at, middle = (sum(values) / len(edges) for values in zip(*edges))
        return sum((at - middle_at) * (total - middle) for at, total in edges) / sum((at - middle_at) ** 2 for at, _ in edges)

    def changed(self, name):
        return getattr(self.last, name) - getattr(self.before, name)


def share_given(frames):
    """Of the frames that the driver counted, those that it gave away."""
    return len(frames) / (frames[-1].sequence - frames[0].sequence + 1)


def sequence_wraps(frames):
    wraps = [(before, after) for before, after in zip(frames, frames[1:]) if before.sequence >> 31 and not after.sequence >> 31]
    return len(wraps) == 1, "; ".join(f"sequence {before.sequence} then {after.sequence}" for before, after in wraps) or "no wrap"


def stamps_cross(boundary_ns):
    """vivid sets its clock so that it passes there 16 s after the stream's start."""

    def witness(frames):
        stamps = [frame.stamp_ns % (1 << 64) for frame in frames]
        found = [(before, after) for before, after in zip(stamps, stamps[1:]) if boundary_ns - 60e9 < before < boundary_ns <= after]
        return len(found) == 1, "; ".join(f"stamp {before} then {after} ns" for before, after in found) or "no wrap"

    return witness


def gives_less_than(quiet):
    """:param quiet: the share that the driver gave away before. Far more has to be missing than what a busy host makes the guest miss."""

    def witness(frames):
        given = share_given(frames)
        return given < 0.7 * quiet, f"the driver gives {100 * given:.0f} % of its frames away, {100 * quiet:.0f} % before"

    return witness


class FaultsStage:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        self.vivid = Vivid(guest)
        self.trace = Trace(guest)
        self.rows = []
        guest.check(f"ln -sfn {CAPTURE} {CAMERA}")
        self.vivid.play(STILL)

    def set(self, name, value=1):
        return f"v4l2-ctl -d {CAPTURE} -c {name}={value}"

    def settle(self, service):
        """A quiet camera before each fault: valid, for several frames on end."""
        count = 0

        def quiet(registers):
            nonlocal count
            count = count + 1 if registers.valid else 0
            return count >= 5

        service.wait_for(quiet, "a valid pose before the next fault")

    def note(self, check, title, good, seen, watch, recovered_s=None):
        expected_alive = watch.last.uptime_s >= watch.before.uptime_s
        self.stage.ok(
            check,
            good and expected_alive,
            f"{title}: {seen}" + (f", frames again after {recovered_s:.1f} s" if recovered_s is not None else ""),
        )
        self.rows.append(
            (
                title,
                seen,
                f"{recovered_s:.1f} s" if recovered_s is not None else "was never lost",
                f"{watch.changed('restarts'):+d}",
                f"{watch.changed('failed'):+d}",
                f"{watch.changed('dropped'):+d}",
            )
        )

    def lost_and_back(self, service, check, title, start, end=None, hold_s=1.0, player=True):
        """A fault that takes the camera away: until `end`, or only until it is opened again. vivid hands an injected error to
        whichever of its two nodes comes first: without a player that is the camera."""
        self.settle(service)
        self.stage.begin(check)
        if not player:
            self.vivid.stop()
        watch = Watch(service)
        watch.during(start, self.guest)
        if watch.lost_at is None:
            watch.until(lambda registers: registers.reason == REASON_CAMERA_LOST, f"{title}: camera lost")
        lost_after = watch.lost_at - watch.started
        stays_lost, over_at = True, watch.lost_at
        if end:
            until = time.monotonic() + hold_s
            watch.until(lambda _: time.monotonic() > until, "")
            stays_lost = watch.last.reason == REASON_CAMERA_LOST and not watch.last.valid
            watch.during(end, self.guest)
            over_at = time.monotonic()
        watch.until(lambda registers: registers.reason != REASON_CAMERA_LOST, f"{title}: frames again")
        back_s = max(0.0, watch.back_at - over_at)
        if not player:
            self.vivid.play(STILL)
        watch.until(lambda registers: registers.valid, f"{title}: valid again")
        ages_grow = watch.ages_ms == sorted(watch.ages_ms)
        self.note(
            check,
            title,
            stays_lost and ages_grow and watch.changed("restarts") == 1,
            f"camera lost (4) after {lost_after:.2f} s"
            + ("" if ages_grow else ", the age went back")
            + ("" if stays_lost else ", not for as long as the fault lasted"),
            watch,
            back_s,
        )

    def stays_valid(self, service, check, title, start, end, witness, seconds=8.0, restart=False):
        """A disturbance that must cost nothing but frames.
        :param witness: whether the frames that the driver gave away show that it was there, and what they show"""
        self.settle(service)
        self.stage.begin(check)
        self.trace.start("v4l2/v4l2_dqbuf")
        if restart:  # it takes effect when a stream starts
            watch = Watch(service)
            watch.during(start + "; " + self.set("inject_fatal_streaming_error"), self.guest)
            watch.until(
                lambda registers: registers.restarts > watch.before.restarts and registers.valid,
                f"{title}: the stream started anew",
            )
            start = "true"
        watch = Watch(service)
        watch.during(start, self.guest)
        ages = []
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            ages.append(watch.look().age_ms)
        per_s = watch.frames_per_s()
        was_there, shown = witness(frames_of(self.trace.stop()))
        watch.during(end, self.guest)
        # A stamp from the future has the age 0, one of long ago more than any frame that is still in the driver.
        good = (
            was_there
            and watch.lost_at is None
            and watch.changed("restarts") == 0
            and abs(per_s - RATE_HZ) < RATE_TOLERANCE * RATE_HZ
            and 0 < min(ages) <= max(ages) < 2000
        )
        self.note(
            check,
            title,
            good,
            f"{shown}; processed, dropped and failed together {per_s:.1f} per second of {RATE_HZ}; "
            f"age {min(ages):.0f} to {max(ages):.0f} ms",
            watch,
        )

    def flagged(self, service):
        self.settle(service)
        self.stage.begin("flagged")
        self.vivid.stop()
        watch = Watch(service)
        count = 5
        for _ in range(count):
            watch.during(self.set("inject_v4l2_buf_flag_error") + "; sleep 0.1", self.guest)
        until = time.monotonic() + 1.5
        watch.until(lambda _: time.monotonic() > until, "")
        self.vivid.play(STILL)
        self.note(
            "flagged",
            f"`inject_v4l2_buf_flag_error`, {count} times",
            watch.changed("failed") == count and watch.lost_at is None,
            f"{watch.changed('failed')} frames counted as failed",
            watch,
        )

    def refused_calls(self, service):
        fatal = self.set("inject_fatal_streaming_error")
        for call in ("reqbufs", "qbuf", "streamon"):
            control = f"inject_vidioc_{call}_error"
            self.lost_and_back(
                service, call, f"`{control}` while it is opened again", f"{self.set(control)}; {fatal}", player=False
            )

    def lost_buffers(self, service):
        """A buffer that the driver refuses to take back is out of the game; when none is left, the stall gets them all back."""
        again = " ".join(["1"] * 5)
        self.lost_and_back(
            service,
            "starved",
            "`inject_vidioc_qbuf_error` until no buffer is left",
            f"for i in {again}; do {self.set('inject_vidioc_qbuf_error')}; sleep 0.2; done",
            player=False,
        )

    def busy(self, service):
        """The camera is away for a moment, and somebody else is faster to take it."""
        self.lost_and_back(
            service,
            "busy",
            "another program takes the camera, for 2 s",
            f"""rm {CAMERA}; {self.set("inject_fatal_streaming_error")}; sleep 0.3
                           v4l2-ctl -d {CAPTURE} --stream-mmap 3 --stream-count 100000 > /tmp/thief.log 2>&1 & echo $! > /tmp/thief.pid
                           for _ in $(seq 200); do grep -q "<" /tmp/thief.log && break; sleep 0.05; done
                           ln -sfn {CAPTURE} {CAMERA}""",
            "kill $(cat /tmp/thief.pid)",
            hold_s=2,
        )

    def unplugged(self, service):
        self.settle(service)
        self.stage.begin("unplugged")
        plug_in = f"echo vivid.0 > {BIND}; sleep 0.5"
        watch = Watch(service)
        watch.during(f"rm {CAMERA}; echo vivid.0 > {UNBIND}", self.guest)
        watch.until(lambda registers: registers.reason == REASON_CAMERA_LOST, "unbind: camera lost")
        lost_after = watch.lost_at - watch.started
        until = time.monotonic() + 3
        watch.until(lambda _: time.monotonic() > until, "")
        stays_lost = watch.last.reason == REASON_CAMERA_LOST
        gone = self.guest.run(f"test -e {CAPTURE}")[0] != 0
        self.guest.check(plug_in)
        self.vivid.stop()
        self.vivid.set_up()
        self.vivid.play(STILL)
        plugged = time.monotonic()
        watch.during(f"ln -sfn {CAPTURE} {CAMERA}", self.guest)
        watch.until(lambda registers: registers.valid, "bind: valid again")
        self.note(
            "unplugged",
            "driver unbound, bound again after 3 s and more",
            gone and stays_lost and watch.changed("restarts") >= 1,
            f"camera lost (4) after {lost_after:.2f} s",
            watch,
            watch.back_at - plugged,
        )

    def late(self, service):
        """The service was started without its camera: it is up, says so, and uses the camera when it comes."""
        self.stage.begin("late")
        watch = Watch(service)
        until = time.monotonic() + 5
        watch.until(lambda registers: registers.reason == REASON_CAMERA_LOST, "started without a camera: camera lost")
        watch.until(lambda _: time.monotonic() > until, "")
        stays_lost = watch.last.reason == REASON_CAMERA_LOST and not watch.last.valid
        plugged = time.monotonic()
        watch.during(f"ln -sfn {CAPTURE} {CAMERA}", self.guest)
        watch.until(lambda registers: registers.valid, "camera plugged in: valid")
        self.note(
            "late",
            "no camera when the service starts, plugged in after 5 s",
            stays_lost,
            "camera lost (4) from the start",
            watch,
            watch.back_at - plugged,
        )

    def signals(self, service):
        for choice, check, title in ((2, "no-lock", "no lock"), (3, "out-of-range", "signal out of range")):
            self.lost_and_back(
                service,
                check,
                f"`dv_timings_signal_mode={choice}` ({title})",
                self.set("dv_timings_signal_mode", choice),
                self.set("dv_timings_signal_mode", 0),
                hold_s=2,
            )

    def drops(self, service):
        dropped = "percentage_of_dropped_buffers"
        self.lost_and_back(
            service, "silent", f"`{dropped}=100` (silent stall)", self.set(dropped, 100), self.set(dropped, 0), hold_s=2
        )

    def dropped(self, service):
        dropped = "percentage_of_dropped_buffers"
        self.settle(service)
        self.trace.start("v4l2/v4l2_dqbuf")
        time.sleep(3)
        quiet = share_given(frames_of(self.trace.stop()))
        self.stays_valid(service, "dropped", f"`{dropped}=92`", self.set(dropped, 92), self.set(dropped, 0), gives_less_than(quiet))

    def wraps(self, service):
        self.stays_valid(
            service,
            "sequence-wrap",
            "`wrap_sequence_number`: from 2^32 - 1 to 0",
            self.set("wrap_sequence_number", 1),
            self.set("wrap_sequence_number", 0),
            sequence_wraps,
            seconds=10,
            restart=True,
        )
        for bits, choice, boundary_ns in ((32, 2, (1 << 31) * 10**9), (64, 1, 1 << 63)):
            self.stays_valid(
                service,
                f"timestamp-wrap-{bits}",
                f"`wrap_timestamp={choice}` ({bits} bit)",
                self.set("wrap_timestamp", choice),
                self.set("wrap_timestamp", 0),
                stamps_cross(boundary_ns),
                seconds=18,
                restart=True,
            )

    def shortest(self, service):
        self.lost_and_back(service, "fatal", "`inject_fatal_streaming_error`", self.set("inject_fatal_streaming_error"))
        self.flagged(service)
        self.lost_and_back(service, "disconnect", "`disconnect`", self.set("disconnect"))
        self.lost_and_back(
            service,
            "no-signal",
            "`dv_timings_signal_mode=1` (no signal)",
            self.set("dv_timings_signal_mode", 1),
            self.set("dv_timings_signal_mode", 0),
            hold_s=2,
        )
        self.unplugged(service)

    def run(self):
        config = camera_config(stall_frames=STALL_FRAMES).replace(f'"{CAPTURE}"', f'"{CAMERA}"')
        service = GuestService(self.guest, config)
        self.guest.check(f"rm {CAMERA}")
        with service:
            self.late(service)
            self.shortest(service)
            if not self.stage.smoke:
                for group in (self.signals, self.drops, self.refused_calls, self.lost_buffers, self.busy, self.wraps):
                    group(service)
            (self.stage.out / "ninedotd-faults.log").write_text(service.log() + "\n")
        self.stage.ok("ends", service.exit_status == "0", f"exit status {service.exit_status} on SIGINT, after all of these")
        if not self.stage.smoke:
            # A service that takes no pause of a second for a stall.
            with GuestService(self.guest, config.replace(f"stall_frames = {STALL_FRAMES}", "stall_frames = 600")) as patient:
                self.dropped(patient)
        self.stage.table("Faults", ("fault", "seen", "frames again", "restarts", "failed", "dropped"), self.rows)


SMOKE_CHECKS = ("late", "fatal", "flagged", "disconnect", "no-signal", "unplugged", "ends")
CHECKS = SMOKE_CHECKS + (
    "no-lock",
    "out-of-range",
    "silent",
    "dropped",
    "reqbufs",
    "qbuf",
    "streamon",
    "starved",
    "busy",
    "sequence-wrap",
    "timestamp-wrap-32",
    "timestamp-wrap-64",
)


def run(stage):
    with stage.guest() as guest:
        FaultsStage(stage, guest).run()
