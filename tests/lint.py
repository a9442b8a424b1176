#!/usr/bin/python3
"""Formatting and clang-tidy over the whole tree. `./dev lint` calls it, with all that it needs installed.

    tests/lint.py format                 all tracked sources, against .clang-format
    tests/lint.py tidy BUILD_FOLDER      the product's translation units, as BUILD_FOLDER/compile_commands.json compiles them, against .clang-tidy
          --since COMMIT                 those alone that changed since then or include a header that did; all, where git does not know
                                         COMMIT or .clang-tidy changed
          --seconds COUNT                no further file after so long: what changed last is looked at first, and how many were not is said
          --all                          also what is on the list of what is still to do
    tests/lint.py --self-test            proves on made-up sources that findings are findings

Both ask version 14 (Debian 12) and leave the check out, saying so, where another one is installed: each version formats and finds differently.
NINEDOT_JOBS: how many run at once (default: one per core). Exit status: 0 nothing found, 1 something, 2 it could not be done.
"""
import concurrent.futures
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time

VERSION = 14
PRODUCT = ("firmware", "drivers", "proto", "programs")
SOURCE = (".h", ".hpp", ".cpp", ".inc")

# Files or folders whose findings do not count yet. An entry that has none any more, or that is gone, fails: the list can only shrink.
NOT_YET = [
    "drivers/camera",
    "drivers/modbus",
    "firmware/detect",
    "firmware/image",
]

FINDING = re.compile(r"^(?P<path>[^:\s]+):(?P<line>\d+):(?P<column>\d+): (?:warning|error): (?P<what>.*?) \[(?P<check>[^\]]+)\]$")


def version_of(tool):
    """The tool's major version, or None where it is missing."""
    try:
        said = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    match = re.search(r"version (\d+)", said)
    return int(match.group(1)) if match else None


def right_version(tool):
    """Whether to go on. Ends the program where the tool is missing."""
    version = version_of(tool)
    if version is None:
        print(f"lint: {tool} is missing: install it, version {VERSION}", file=sys.stderr)
        sys.exit(2)
    if version != VERSION:
        print(f"lint: {tool} is version {version} and {VERSION} is wanted: left out")
    return version == VERSION


def check_format(root):
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        print(f"lint: which sources are tracked, git does not say: {listed.stderr.strip()}", file=sys.stderr)
        return 2
    files = [path for path in listed.stdout.split("\0") if path.endswith(SOURCE) and os.path.exists(os.path.join(root, path))]
    if not files:
        print(f"lint: no tracked sources under {root}", file=sys.stderr)
        return 2
    done = subprocess.run(["clang-format", "--dry-run", "-Werror", *files], cwd=root, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        print(f"format: {len(files)} files as clang-format {VERSION} writes them")
        return 0
    sys.stderr.write(done.stderr)
    print("format: write it with: clang-format -i FILE", file=sys.stderr)
    return 1


def product_units(root, build):
    """The product's translation units that are to be compiled and that exist, the largest first: they take longest."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        commands = json.load(file)
    units = {os.path.relpath(os.path.join(entry["directory"], entry["file"]), root) for entry in commands}
    units = [unit for unit in units if unit.startswith(tuple(top + "/" for top in PRODUCT)) and os.path.isfile(os.path.join(root, unit))]
    return sorted(units, key=lambda unit: (-os.path.getsize(os.path.join(root, unit)), unit))


def changed_since(commit, root):
    """Paths below root, what changed last first, or None where that can't be said."""
    def paths(*command):
        asked = subprocess.run(["git", *command, "-z"], cwd=root, capture_output=True, text=True, check=False)
        return None if asked.returncode != 0 else [name for name in asked.stdout.split("\0") if name]

    all_of_it = paths("diff", "--name-only", "--relative", commit)
    if all_of_it is None or ".clang-tidy" in all_of_it:
        return None
    newest_first = (paths("diff", "--name-only", "--relative", "HEAD") or []) + (paths("log", "--format=", "--name-only", "--relative", commit + "..HEAD") or [])
    rank = {path: place for place, path in reversed(list(enumerate(newest_first)))}
    return sorted(all_of_it, key=lambda path: (rank.get(path, len(rank)), path))


def touched_units(units, changed, root):
    """Those that changed, or that include a header that did, in the order of `changed`."""
    def included(unit):
        with open(os.path.join(root, unit), encoding="utf-8") as file:
            return re.findall(r'^#include "([^"]+)"', file.read(), re.MULTILINE)

    place_of = {path.removeprefix("firmware/") if path.endswith((".h", ".hpp", ".inc")) else path: place for place, path in enumerate(changed)}
    place = {unit: min((place_of[path] for path in [unit, *included(unit)] if path in place_of), default=None) for unit in units}
    return sorted((unit for unit in units if place[unit] is not None), key=place.get)


# A tree may read the largest headers once, for all of its files: here each is to include what it needs.
HEADERS_OF_ALL = re.compile(r"\s-include\s+\S*cmake_pch\.hxx(?=\s)")


def write_commands(build, folder):
    """The build's compile commands, each for a file on its own."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        commands = json.load(file)
    for entry in commands:
        # -Wno- of a warning that only the other compiler has is nothing to tell, least of all as an error.
        entry["command"] = HEADERS_OF_ALL.sub("", entry["command"]) + " -Wno-unknown-warning-option"
    with open(os.path.join(folder, "compile_commands.json"), "w", encoding="utf-8") as file:
        json.dump(commands, file)


def findings_of(unit, root, build):
    """(findings, trouble) of one translation unit; trouble: what clang-tidy says where it fails without a finding."""
    done = subprocess.run(["clang-tidy", "--quiet", "-p", os.path.abspath(build), unit], cwd=root, capture_output=True, text=True, check=False)
    found = set()
    for line in done.stdout.splitlines():
        match = FINDING.match(line)
        if match:
            check = match["check"].replace(",-warnings-as-errors", "")
            path = os.path.relpath(os.path.join(root, match["path"]), root)
            found.add((path, int(match["line"]), int(match["column"]), f"{match['what']} [{check}]"))
    return found, "" if found or done.returncode == 0 else f"{unit}: clang-tidy failed\n{done.stdout}{done.stderr}"


def verdict(found, not_yet, root, looked_at_all=True):
    """(what is wrong, how many findings do not count yet)"""
    wrong = []
    for entry in not_yet:
        if not os.path.exists(os.path.join(root, entry)):
            wrong.append(f"{entry}: is gone: take it off NOT_YET in tests/lint.py")
        elif looked_at_all and not any(path == entry or path.startswith(entry + "/") for path, *_ in found):
            wrong.append(f"{entry}: is clean: take it off NOT_YET in tests/lint.py")
    counting = [finding for finding in sorted(found)
                if not any(finding[0] == entry or finding[0].startswith(entry + "/") for entry in not_yet)]
    wrong += [f"{path}:{line}:{column}: {what}" for path, line, column, what in counting]
    return wrong, len(found) - len(counting)


def check_tidy(root, build, not_yet, show_all=False, since=None, seconds=None):
    all_units = product_units(root, build)
    if not all_units:
        print(f"lint: {build} compiles nothing of {', '.join(PRODUCT)}", file=sys.stderr)
        return 2
    changed = changed_since(since, root) if since else None
    units = all_units if changed is None else touched_units(all_units, changed, root)
    began, found, troubles, looked_at = time.monotonic(), set(), [], 0
    jobs = int(os.environ.get("NINEDOT_JOBS") or os.cpu_count() or 1)
    with tempfile.TemporaryDirectory() as commands, concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        write_commands(build, commands)
        def look(unit):
            return None if seconds is not None and time.monotonic() - began > seconds else findings_of(unit, root, commands)

        for result in pool.map(look, units):
            if result is not None:
                found |= result[0]
                troubles += [result[1]] if result[1] else []
                looked_at += 1
    wrong, later = verdict(found, [] if show_all else not_yet, root, looked_at == len(all_units))
    for line in wrong + troubles:
        print(line, file=sys.stderr)
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    not_reached = f"; {len(units) - looked_at} more were not reached in {seconds} s" if looked_at < len(units) else ""
    print(f"clang-tidy: {looked_at} of {len(all_units)} files in {time.monotonic() - began:.0f} s, {spent.ru_utime + spent.ru_stime:.0f} s of processor time; "
          f"{len(wrong)} findings" + (f", {later} more on the list of what is still to do" if later else "") + not_reached)
    return 1 if wrong or troubles else 0


GOOD_UNIT = '#include "a.h"\nint twice(int x) { return 2 * x; }\n'
BAD_UNIT = '#include "a.h"\nint twice(int x) { return static_cast<int>(x + 0.5); }\n'  # bugprone-incorrect-roundings
BAD_HEADER = "#pragma once\n#include <string>\ninline int size(const std::string t) { return static_cast<int>(t.size()); }\nint twice(int x);\n"


def self_test():
    if not (right_version("clang-format") and right_version("clang-tidy")):
        return
    tree = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")

    def run(unit, header="#pragma once\nint twice(int x);\n", not_yet=(), command="c++ -std=c++20 -Wall -c proto/a.cpp", changed=None, seconds=None):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "proto"))
            for name in (".clang-tidy", ".clang-format"):
                with open(os.path.join(tree, name), encoding="utf-8") as source, open(os.path.join(root, name), "w", encoding="utf-8") as copy:
                    copy.write(source.read())
            files = {"proto/a.cpp": unit, "proto/a.h": header, "cmake_pch.hxx": "#include <string>\n", "compile_commands.json": json.dumps(
                [{"directory": root, "file": name, "command": command} for name in ("proto/a.cpp", "proto/gone.cpp", "tests/a.cpp")])}
            for name, text in files.items():
                with open(os.path.join(root, name), "w", encoding="utf-8") as file:
                    file.write(text)
            subprocess.run(["git", "init", "-q", root], check=True)
            subprocess.run(["git", "-C", root, "add", "proto"], check=True)
            if changed is not None:
                commit = ["git", "-C", root, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "a"]
                subprocess.run(commit, check=True)
                for name in changed:
                    with open(os.path.join(root, name), "a", encoding="utf-8") as file:
                        file.write("\n")
            return check_format(root), check_tidy(root, root, list(not_yet), since=None if changed is None else "HEAD", seconds=seconds)

    assert run(GOOD_UNIT) == (0, 0)
    assert run(GOOD_UNIT.replace("{ return", "{return")) == (1, 0), "wrong formatting passes"
    assert run(BAD_UNIT) == (0, 1), "a finding in a source passes"
    assert run(GOOD_UNIT, BAD_HEADER) == (0, 1), "a finding in a header passes"
    assert run(GOOD_UNIT + "static int unused() { return 1; }\n") == (0, 1), "a warning of Clang passes"
    assert run("#include <nowhere.h>\n") == (0, 1), "a source that cannot be read passes"
    assert run('#include "a.h"\nstd::string s;\n', command="c++ -std=c++20 -include cmake_pch.hxx -c proto/a.cpp") == (0, 1), "a missing header passes"
    assert run(GOOD_UNIT, command="c++ -std=c++20 -Werror -Wno-stringop-overread -c proto/a.cpp") == (0, 0), "a warning of GCC alone is a finding"
    assert run(BAD_UNIT, not_yet=["proto"]) == (0, 0)
    assert run(GOOD_UNIT, not_yet=["proto"]) == (0, 1), "an entry of NOT_YET that outlived its reason passes"
    assert run(GOOD_UNIT, not_yet=["proto/gone.h"]) == (0, 1), "an entry of NOT_YET that is gone passes"
    assert run(BAD_UNIT, changed=()) == (0, 0), "what did not change is looked at"
    assert run(BAD_UNIT, changed=("proto/a.cpp",))[1] == 1, "what changed is not looked at"
    assert run(BAD_UNIT.replace('"a.h"', '"proto/a.h"'), changed=("proto/a.h",), command="c++ -std=c++20 -I. -c proto/a.cpp")[1] == 1
    assert run(GOOD_UNIT, changed=(), not_yet=["proto"]) == (0, 0), "nobody looked there"
    assert run(BAD_UNIT, seconds=-1) == (0, 0), "a file is begun after the time is over"
    assert run(GOOD_UNIT, not_yet=["proto"], seconds=-1) == (0, 0), "what was not reached is called clean"
    print("lint: findings are findings")


def main():
    root = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        self_test()
        return 0
    if arguments == ["format"]:
        return check_format(root) if right_version("clang-format") else 0
    if arguments[:1] == ["tidy"] and len(arguments) >= 2:
        build, options = arguments[1], arguments[2:]
        show_all = "--all" in options
        if show_all:
            options.remove("--all")
        given = dict(zip(options[::2], options[1::2]))
        seconds = given.get("--seconds")
        if len(options) == 2 * len(given) and given.keys() <= {"--since", "--seconds"} and (seconds is None or seconds.isdigit()):
            if not right_version("clang-tidy"):
                return 0
            return check_tidy(root, build, NOT_YET, show_all, given.get("--since"), None if seconds is None else int(seconds))
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
