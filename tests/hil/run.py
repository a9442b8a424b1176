#!/usr/bin/python3
"""Tests against kernel drivers, in a guest under QEMU: `./dev hil [--smoke] [STAGE...]`.

    run.py BIN_FOLDER OUT_FOLDER [--smoke] [STAGE|STAGE.CHECK...]

STAGE.CHECK runs as much of the stage as it needs: the smoke part, if the check is in it.

Prints one line for each check, `ok STAGE.CHECK detail` or `not ok ...`, writes OUT_FOLDER/report.md, and exits with 1 if a check failed
or never came to be made.
"""

import os
import pathlib
import platform
import subprocess
import sys
import time
import traceback

SOURCE = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("NINEDOT_SOURCE_DIR", os.fspath(SOURCE))
os.environ.setdefault("NINEDOT_BIN_DIR", os.fspath(pathlib.Path(sys.argv[1]).resolve()) if len(sys.argv) > 1 else "")
sys.path[:0] = [os.fspath(SOURCE / "tests" / "hil"), os.fspath(SOURCE / "tests" / "programs")]

import camera_stage
import faults_stage
import installed_stage
import libcamera_stage
import sensors_stage
import serial_stage
import servo_stage
import visca_stage
from guest import Guest
from media import make_media

STAGES = {
    "camera": camera_stage,
    "faults": faults_stage,
    "sensors": sensors_stage,
    "serial": serial_stage,
    "servo": servo_stage,
    "visca": visca_stage,
    "libcamera": libcamera_stage,
    "installed": installed_stage,
}

NOT_REACHED = "was not reached"


class Stage:
    """One stage's lines and tables."""

    def __init__(self, name, module, out, smoke, is_asked_for):
        self.name, self.module, self.out, self.smoke, self.is_asked_for = name, module, out, smoke, is_asked_for
        self.lines, self.tables = [], []
        self.seconds = 0.0
        self.left_out = None
        self.under_way = None

    def guest(self, *extra):
        return Guest(self.out, self.out / f"console-{self.name}.log", extra)

    def begin(self, check):
        """What does not come in time from here on is this check's own failure: without it the check was only not reached."""
        self.under_way = check

    def ok(self, check, good, detail=""):
        self.under_way = None
        self.lines.append((check, bool(good), detail))
        print(f"{'ok' if good else 'not ok'} {self.name}.{check}  {detail}", flush=True)

    def leave_out(self, reason):
        self.left_out = reason
        if self.is_asked_for:
            self.ok("runs", False, reason)
        else:
            print(f"left out {self.name}  {reason}", flush=True)

    def table(self, title, header, rows):
        self.tables.append((title, header, rows))

    def run(self):
        started = time.monotonic()
        try:
            self.module.run(self)
        except Exception as failure:
            # One stage's end must not hide what the others have to say.
            traceback.print_exc()
            what = str(failure).splitlines()[0] if str(failure) else type(failure).__name__
            # Anything else, a guest that is gone, says nothing about what is tested.
            if self.under_way and isinstance(failure, AssertionError):
                self.ok(self.under_way, False, what)
            self.ok("runs", False, what)
        expected = self.module.SMOKE_CHECKS if self.smoke else self.module.CHECKS
        for check in () if self.left_out else expected:
            if check not in (line[0] for line in self.lines):
                self.ok(check, False, NOT_REACHED)
        self.seconds = time.monotonic() - started
        print(f"   {self.name}: {self.seconds:.0f} s", flush=True)

    failed = property(lambda self: [line for line in self.lines if not line[1]])


def as_table(header, rows):
    cells = [header, ["---"] * len(header), *rows]
    return "".join("| " + " | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in row) + " |\n" for row in cells)


def report(stages):
    text = "# Tests against kernel drivers\n\n"
    text += as_table(
        ("stage", "checks", "failed", "seconds"), [(s.name, len(s.lines), len(s.failed), f"{s.seconds:.0f}") for s in stages]
    )
    text += f"\nGuest under QEMU's TCG on {platform.machine()}, {os.cpu_count()} processors: judge function here, never speed.\n"
    for stage in stages:
        text += f"\n## {stage.name}\n\n"
        if stage.left_out:
            text += f"Left out: {stage.left_out}.\n"
            continue
        text += as_table(
            ("check", "", "seen"), [(check, "ok" if good else "FAILED", detail) for check, good, detail in stage.lines]
        )
        for title, header, rows in stage.tables:
            text += f"\n### {title}\n\n" + as_table(header, rows)
    return text


def stages_for(asked, smoke):
    """\\return  of each stage that is asked for, as STAGE or STAGE.CHECK, whether its smoke part is enough"""
    enough = {}
    for argument in asked:
        name, _, check = argument.partition(".")
        if name not in STAGES:
            sys.exit(f"hil: there is no stage {name}; there are {' '.join(STAGES)}")
        if check and check not in STAGES[name].CHECKS:
            sys.exit(f"hil: {name} has no check {check}; it has {' '.join(STAGES[name].CHECKS)}")
        enough[name] = enough.get(name, True) and (smoke or check in STAGES[name].SMOKE_CHECKS)
    return enough


def main(arguments):
    if len(arguments) < 2:
        sys.exit(__doc__)
    bin_folder, out = (pathlib.Path(argument).resolve() for argument in arguments[:2])
    smoke = "--smoke" in arguments
    asked_for = stages_for((argument for argument in arguments[2:] if argument != "--smoke"), smoke)
    names = list(asked_for) or list(STAGES)
    out.mkdir(parents=True, exist_ok=True)
    make_media(SOURCE / "tests" / "recordings", out / "media")
    simulated = ["--simulated-hardware"] if "servo" in names or "sensors" in names else []
    image = [SOURCE / "tests" / "hil" / "guest_image.sh", bin_folder, out / "media", out, *simulated]
    # That stage has an image of its own.
    if names != ["installed"] and subprocess.run(image).returncode != 0:
        return 2
    stages = [Stage(name, STAGES[name], out, asked_for.get(name, smoke), name in asked_for) for name in names]
    for stage in stages:
        stage.run()
    (out / "report.md").write_text(report(stages))
    failed = sum(len(stage.failed) for stage in stages)
    print(f"{sum(len(stage.lines) for stage in stages)} checks, {failed} failed; {out / 'report.md'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
