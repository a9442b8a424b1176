#!/usr/bin/python3
"""Applies one mutation after the other, builds the one program concerned, and runs the check that should turn red: tests/mutation.sh.

    run.py copy FOLDER               the repository's files into FOLDER, those alone that differ
    run.py judge [--hil] [--again] [PATTERN]      in the copy
    run.py places                    whether each mutation has its place in the sources, once
"""

import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

import verdict

LIST = pathlib.Path("tests/mutation/mutations.txt")
SEEN_RED = pathlib.Path("build/seen-red.json")
VERDICT = pathlib.Path("tests/mutation/verdict.py")
BUILD = pathlib.Path("build/release")
PATIENCE_S = 600


class Mutation:
    """A block of the list:

    FILE
    - what stands there, once
    + what stands there instead
    ! PROGRAM GTEST-FILTER, or: ! hil STAGE.CHECK
    ~ why it may survive
    % why its check may never end: that is red then
    """

    def __init__(self, lines):
        self.file, self.old, self.new, self.check = lines[0], [], [], None
        self.may_survive = self.may_not_end = None
        for line in lines[1:]:
            kind, text = line[0], line[2:]
            if kind == "-":
                self.old.append(text)
            elif kind == "+":
                self.new.append(text)
            elif kind == "!":
                self.check = text.split()
            elif kind == "~":
                self.may_survive = text
            elif kind == "%":
                self.may_not_end = text
            else:
                raise ValueError(f"{LIST}: a line begins with none of - + ! ~ %: {line}")
        if not self.old or len(self.check or []) != 2:
            raise ValueError(f"{LIST}: not whole: {lines}")
        self.before, self.after = "\n".join(self.old), "\n".join(self.new)

    is_hil = property(lambda self: self.check[0] == "hil")
    # What has to be green without any mutation: the guest's check, or the program.
    asks = property(lambda self: self.check[1] if self.is_hil else self.check[0])
    name = property(lambda self: " ".join(f"{self.file}: {self.after.strip() or 'without ' + self.before}".split()))

    def applies(self):
        path = pathlib.Path(self.file)
        return path.exists() and path.read_text().count(self.before) == 1

    def identity(self):
        """Another one when the file, the mutation, a test of the check's room, or what is called red is."""
        room = pathlib.Path("tests") / ("hil" if self.is_hil else self.check[0].removesuffix("_test"))
        digest = hashlib.sha256(repr((self.file, self.before, self.after, self.check)).encode())
        for path in [pathlib.Path(self.file), VERDICT, *sorted(path for path in room.glob("*") if path.suffix in (".cpp", ".h", ".py"))]:
            digest.update(path.read_bytes())
        return digest.hexdigest()


def read_list():
    blocks, lines = [], []
    for line in [*LIST.read_text().splitlines(), ""]:
        if line.startswith("#"):
            continue
        if line:
            lines.append(line)
        elif lines:
            blocks.append(Mutation(lines))
            lines = []
    return blocks


def copy_to(folder):
    files = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], capture_output=True, check=True
    ).stdout.decode()
    wanted = {name for name in files.split("\0") if name and pathlib.Path(name).is_file()}
    for name in sorted(wanted):
        source, target = pathlib.Path(name), folder / name
        if target.exists() and target.read_bytes() == source.read_bytes():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)  # its time is now: what is built of it is older
        shutil.copymode(source, target)
    for path in folder.rglob("*"):
        name = path.relative_to(folder)
        if name.parts[0] != "build" and path.is_file() and str(name) not in wanted:
            path.unlink()
    if not (folder / BUILD).exists() and (BUILD / "CMakeCache.txt").exists():
        shutil.copytree(BUILD, folder / BUILD, symlinks=True)


class Progress:
    """On a terminal one line that changes; in a pipe a line for each result alone."""

    def __init__(self, count):
        self.count, self.done, self.started = count, 0, time.monotonic()

    def at(self, what):
        if sys.stdout.isatty():
            print(f"\r\x1b[K{self.done + 1} of {self.count}, {time.monotonic() - self.started:.0f} s: {what}"[:160], end="", flush=True)

    def say(self, result, text):
        self.done += 1
        if sys.stdout.isatty():
            print("\r\x1b[K", end="")
        print(f"{result:9} {text}", flush=True)


def built(*targets):
    jobs = os.environ.get("NINEDOT_JOBS") or str(os.cpu_count())
    return subprocess.run(["cmake", "--build", BUILD, "-j", jobs, "--target", *targets], capture_output=True, text=True)


def run_tests(program, tests):
    """\\return  (outcome, what there is to add)"""
    command = [BUILD / "bin" / program, f"--gtest_filter={tests}"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return verdict.of_tests(verdict.NO_TIME_LEFT, "")
    return verdict.of_tests(done.returncode, done.stdout)


def run_checks(checks):
    """In a guest. \\return  of each STAGE.CHECK (outcome, what there is to add)"""
    command = ["/usr/bin/python3", "tests/hil/run.py", BUILD / "bin", "build/hil", *checks]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return {check: verdict.of_check(check, done.stdout) for check in checks}


def judge(mutation):
    """\\return  (result, what there is to add)"""
    program, check = mutation.check
    path = pathlib.Path(mutation.file)
    original = path.read_text()
    try:
        path.write_text(original.replace(mutation.before, mutation.after))
        made = built("ninedot", "ninedotd") if mutation.is_hil else built(program)
        if made.returncode != 0:
            errors = [line for line in made.stdout.splitlines() if "error:" in line]
            return "NO BUILD", errors[0] if errors else made.stdout[-200:]
        outcome, detail = run_checks([check])[check] if mutation.is_hil else run_tests(program, check)
    finally:
        path.write_text(original)
    return verdict.of_mutation(outcome, detail, mutation.may_survive, mutation.may_not_end)


def green_without(mutations):
    """The programs and the guest's checks that are green as they are: of others a red one says nothing. \\return  names"""
    green = set()
    if checks := sorted({mutation.asks for mutation in mutations if mutation.is_hil}):
        made = built("ninedot", "ninedotd")
        if made.returncode != 0:
            sys.exit(f"mutation: the programs do not build as they are:\n{made.stdout[-2000:]}")
        # Together: each stage once, or its smoke part where that has them all.
        for check, (outcome, detail) in run_checks(checks).items():
            if outcome == verdict.GREEN:
                green.add(check)
            else:
                print(f"NOT GREEN {check} without any mutation: {outcome}  {detail}", flush=True)
    for program in sorted({mutation.check[0] for mutation in mutations if not mutation.is_hil}):
        made = built(program)
        if made.returncode != 0:
            sys.exit(f"mutation: {program} does not build as it is:\n{made.stdout[-2000:]}")
        tests = ":".join(sorted({mutation.check[1] for mutation in mutations if mutation.check[0] == program}))
        outcome, detail = run_tests(program, tests)
        if outcome == verdict.GREEN:
            green.add(program)
        else:
            print(f"NOT GREEN {program} without any mutation: {outcome}  {detail or tests}", flush=True)
    return green


def tell_places():
    mutations = read_list()
    lost = [mutation for mutation in mutations if not mutation.applies()]
    for mutation in lost:
        print(f"{mutation.file}: not there, or more than once: {mutation.before.strip()}", file=sys.stderr)
    print(f"mutations: {len(mutations) - len(lost)} of {len(mutations)} have their place")
    return 1 if lost or not mutations else 0


def main(arguments):
    if arguments[:1] == ["copy"] and len(arguments) == 2:
        return copy_to(pathlib.Path(arguments[1]).resolve())
    if arguments == ["places"]:
        return tell_places()
    if arguments[:1] != ["judge"]:
        sys.exit(__doc__)
    with_hil, again = "--hil" in arguments, "--again" in arguments
    patterns = [argument for argument in arguments[1:] if not argument.startswith("--")]
    mutations = [
        mutation
        for mutation in read_list()
        if all(pattern in f"{mutation.name} {mutation.before} {' '.join(mutation.check)}" for pattern in patterns)
    ]
    if not mutations:
        sys.exit(f"mutation: nothing in {LIST} matches {' '.join(patterns)}")
    if not (BUILD / "CMakeCache.txt").exists():
        subprocess.run(["cmake", "--preset", "release", "-DNINEDOT_TESTS=ON"], check=True, stdout=subprocess.DEVNULL)
    seen_red = json.loads(SEEN_RED.read_text()) if SEEN_RED.exists() and not again else []
    started, counts, wrong = time.monotonic(), {}, 0
    left_out = sum(mutation.is_hil for mutation in mutations) if not with_hil else 0
    asked = [mutation for mutation in mutations if with_hil or not mutation.is_hil]
    open_ones = [mutation for mutation in asked if not mutation.applies() or mutation.identity() not in seen_red]
    green = green_without([mutation for mutation in open_ones if mutation.applies()])
    progress = Progress(len(open_ones))
    for mutation in open_ones:
        progress.at(mutation.name)
        if not mutation.applies():
            result, detail = "NO PLACE", "the line is not there, or more than once: correct the list"
        elif mutation.asks not in green:
            result, detail = "NOT GREEN", "without any mutation: see above"
        else:
            identity = mutation.identity()
            result, detail = judge(mutation)
            if result == "red":
                seen_red.append(identity)
                SEEN_RED.write_text(json.dumps(seen_red))
        wrong += result.isupper()
        counts[result] = counts.get(result, 0) + 1
        progress.say(result, f"{mutation.name}  [{' '.join(mutation.check)}]" + (f"  {detail}" if detail else ""))
    remembered = len(asked) - len(open_ones)
    text = ", ".join(f"{count} {result}" for result, count in sorted(counts.items()))
    print(
        f"{len(asked)} mutations: {text or 'nothing to do'}"
        + (f", {remembered} seen red before" if remembered else "")
        + (f", {left_out} of `./dev hil` left out (--hil)" if left_out else "")
        + f"; {time.monotonic() - started:.0f} s"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
