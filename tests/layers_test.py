#!/usr/bin/python3
"""Fails on an #include that points the wrong way, and on two types of one name.

    tests/layers_test.py [ROOT]       checks the tree (default: the one that this script is in)
    tests/layers_test.py --self-test  proves on made-up trees that each kind of violation is caught

The arrows of docs/architecture.md are the table ALLOWED below; OWNERS says who may use which outside library.
Files under tests/ may include anything, and nothing outside tests/ may include them. All of it is one namespace: two types of one name
in two headers are the same to the linker, which keeps one of their functions (C++ [basic.def.odr]), and no compiler says so.
"""
import os
import re
import sys
import tempfile

# A folder may include itself and what stands here: folders, or single headers.
BASE = ["firmware/base"]
GEOMETRY_AND_IMAGE = ["firmware/geometry", "firmware/image"] + BASE
ALLOWED = {
    "firmware/base": [],
    "firmware/image": BASE,
    "firmware/geometry": BASE,
    "firmware/detect": GEOMETRY_AND_IMAGE,
    # The detector hands its observation, plain numbers, to the solvers; the detector itself stays unknown to them.
    "firmware/pose": GEOMETRY_AND_IMAGE + ["firmware/detect/observation.h"],
    # What lasts from frame to frame: of what the detector saw, of what the solvers answer, and of the camera in the world.
    "firmware/track": ["firmware/pose", "firmware/detect/observation.h", "firmware/detect/forecast.h", "firmware/world"] + GEOMETRY_AND_IMAGE,
    "firmware/ports": ["firmware/image"] + BASE,
    "firmware/report": BASE,
    "firmware/aim": ["firmware/ports", "firmware/report"] + GEOMETRY_AND_IMAGE,
    "firmware/world": ["firmware/geometry"] + BASE,
    # Codes of the map beside what a picture shows; where landmarks hang is no concern of colour.
    "firmware/colour": ["firmware/world/landmark_codes.h", "firmware/world/landmark_map.h"] + GEOMETRY_AND_IMAGE,
    # Maps from sightings, for `ninedot` alone: the service does not link it.
    "firmware/mapping": ["firmware/world", "firmware/geometry"] + BASE,
    "firmware/calibrate": GEOMETRY_AND_IMAGE + ["firmware/detect", "firmware/pose"],
    # Lenses from what recordings show, for `ninedot` alone as well.
    "firmware/calibrate_camera": GEOMETRY_AND_IMAGE + ["firmware/detect", "firmware/pose"],
    # Heads likewise.
    "firmware/calibrate_head": ["firmware/world", "firmware/geometry", "firmware/mapping/chi_square.h"] + BASE,
    "firmware/config": ["firmware/aim", "firmware/world", "firmware/ports"] + GEOMETRY_AND_IMAGE,
    "firmware/drawing": ["firmware/world", "firmware/detect/observation.h", "firmware/detect/failed_search.h", "firmware/report"] + GEOMETRY_AND_IMAGE,
    "firmware/pipeline": ["firmware/ports", "firmware/colour", "firmware/aim", "firmware/track", "firmware/pose", "firmware/detect", "firmware/world",
                          "firmware/report"] + GEOMETRY_AND_IMAGE,
    # What becomes of a report, and the one place that knows both it and the wire's.
    "firmware/outputs": ["firmware/report", "firmware/aim", "firmware/ports", "proto"] + GEOMETRY_AND_IMAGE,
    "drivers/posix": ["firmware/ports", "firmware/image"] + BASE,
    "drivers/picture": ["firmware/image", "drivers/posix"] + BASE,
    "drivers/recording": ["firmware/ports", "firmware/image", "proto", "drivers/picture", "drivers/posix"] + BASE,
    "drivers/camera": ["firmware/ports", "firmware/image", "drivers/picture", "drivers/posix"] + BASE,
    "drivers/servo": ["firmware/ports", "firmware/aim/servo_axis.h", "drivers/posix"] + BASE,
    # Of the camera it takes the numbers alone: what it shows must not share a mistake with those who look at it.
    "drivers/simulation": ["firmware/ports", "firmware/image", "firmware/geometry/camera_model.h"] + BASE,
    "drivers/gpio": ["firmware/ports", "drivers/posix"] + BASE,
    "drivers/modbus": ["proto", "drivers/posix"] + BASE,
    "drivers/tap": ["proto", "firmware/image", "drivers/posix"] + BASE,
    "proto": BASE,
    # The composition root and what belongs to one program alone: above all others, included by none.
    "programs": ["firmware", "drivers", "proto"],
}

# Outside library: (what its headers start with, the folders that may include them). A library that is not here is free.
OWNERS = [
    (r"libcamera/", ["drivers/camera"]),
    (r"linux/videodev2\.h", ["drivers/camera"]),
    (r"png\.h|turbojpeg\.h", ["drivers/picture"]),
    (r"gpiod\.(h|hpp)", ["drivers/gpio", "drivers/servo"]),
    (r"modbus(/|\.h|-)", ["drivers/modbus"]),
    (r"systemd/", ["drivers/posix"]),
    (r"linux/i2c(-dev)?\.h", ["drivers/servo"]),
    (r"opencv2/", ["firmware/image", "firmware/detect", "firmware/pose", "firmware/drawing"]),
    (r"yaml-cpp/", ["firmware/calibrate"]),
    (r"ceres/", ["firmware/mapping", "firmware/calibrate_camera", "firmware/calibrate_head"]),
    (r"toml\+\+/|toml\.hpp", ["firmware/config"]),
    (r"CLI/", ["programs"]),
    (r"microhttpd\.h", ["programs/web"]),
]

PRODUCT = ("firmware", "drivers", "proto", "programs")
SOURCE = (".h", ".hpp", ".cpp", ".inc")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
MAX_LINES = 500
MAX_ROOM = 1 / 3  # of all lines of firmware/: a larger folder does several things


def sources(root):
    for top in PRODUCT:
        for folder, subfolders, names in os.walk(os.path.join(root, top)):
            subfolders.sort()
            for name in sorted(names):
                if name.endswith(SOURCE):
                    yield os.path.relpath(os.path.join(folder, name), root)


def resolve(root, path, included):
    """The included file inside the tree, as the compiler finds it, or None for a header from outside."""
    for start in (os.path.dirname(path), "firmware", ""):
        candidate = os.path.normpath(os.path.join(start, included))
        if os.path.isfile(os.path.join(root, candidate)):
            return candidate
    return None


def rule_of(path):
    """(the folder that a file belongs to, what that folder may include); None where the table knows no such folder."""
    for key, allowed in ALLOWED.items():
        if path.startswith(key + "/"):
            return key, allowed
    return None, None


def under(path, places):
    for place in places:
        if path == place or path.startswith(place + "/"):
            return True
    return False


def check_include(root, path, included, quoted):
    """Why `path` must not include `included`, or None."""
    home, allowed = rule_of(path)
    target = resolve(root, path, included)
    if target is not None:
        if under(target, [home] + allowed):
            return None
        return f"{home} must not include {target}: allowed are {', '.join(allowed) or 'no other folder'}"
    for pattern, owners in OWNERS:
        if re.match(pattern, included) and not under(path, owners):
            return f"<{included}> may be used in {', '.join(owners)} only"
    if quoted:
        return f'"{included}" is not in the tree: include headers from outside with <>'
    return None


# At the beginning of a line, so in no other type.
TYPE = re.compile(r"(?:template\s*<.*>\s*)?(?:struct|class|enum(?:\s+class)?|union)\s+(?:\[\[.*?\]\]\s*|alignas\([^)]*\)\s*)?(\w+)\b[^;]*\{")


def violations(root):
    found, count, rooms, types = [], 0, {}, {}
    for path in sources(root):
        count += 1
        if rule_of(path)[0] is None:
            found.append(f"{path}: its folder is in no layer: add it to ALLOWED in tests/layers_test.py")
            continue
        with open(os.path.join(root, path), encoding="utf-8") as file:
            lines = file.read().splitlines()
        if path.startswith("firmware/"):
            rooms[rule_of(path)[0]] = rooms.get(rule_of(path)[0], 0) + len(lines)
        if len(lines) > MAX_LINES:
            found.append(f"{path}: {len(lines)} lines, more than {MAX_LINES}: split it by what its parts do")
        for number, line in enumerate(lines, 1):
            match = TYPE.match(line) if path.endswith(".h") else None
            if match and types.setdefault(match.group(1), path) != path:
                found.append(f"{path}:{number}: {match.group(1)} is a type of {types[match.group(1)]} as well: give it a name of its own")
            match = INCLUDE.match(line)
            if match:
                why = check_include(root, path, match.group(2), match.group(1) == '"')
                if why:
                    found.append(f"{path}:{number}: {why}")
    for room, size in rooms.items():
        if len(rooms) > 3 and size > MAX_ROOM * sum(rooms.values()):
            found.append(f"{room}: {size} of the {sum(rooms.values())} lines of firmware: split it by what its files do")
    return found, count


GOOD = {
    "firmware/base/result.h": "#include <cstdint>\n",
    "firmware/image/blur.cpp": '#include <opencv2/core.hpp>\n#include "base/result.h"\n',
    "firmware/geometry/transform.h": "#include <Eigen/Core>\n",
    "firmware/world/map.h": '#include "geometry/transform.h"\n',
    "firmware/detect/observation.h": '#include "geometry/transform.h"\n',
    "firmware/detect/detector.h": '#include "detect/observation.h"\n',
    "firmware/pose/solver.h": '#include "detect/observation.h"\n',
    "firmware/ports/frame_source.h": '#include "base/result.h"\n',
    "firmware/pipeline/localiser.h": '#include "world/map.h"\n#include "report/report.h"\n#include "detect/detector.h"\n',
    "programs/main.cpp": '#include <CLI/CLI.hpp>\n#include "drivers/modbus/server.h"\n#include "proto/registers.h"\n',
    "drivers/modbus/server.h": '#include <modbus.h>\n#include "fd.h"\n#include "drivers/posix/fd.h"\n#include "proto/registers.h"\n',
    "drivers/modbus/fd.h": '#include "base/result.h"\n',
    "drivers/posix/fd.h": "#include <unistd.h>\n",
    "firmware/report/report.h": '#include "base/result.h"\n',
    "firmware/outputs/wire.h": '#include "report/report.h"\n#include "proto/registers.h"\n',
    "proto/wire.h": '#include "base/result.h"\nstruct Taken {\n',
    "proto/registers.h": '#include "proto/wire.h"\n',
    "tests/support/render.h": '#include "programs/main.cpp"\n',
}
# One file more, and what the report must say about it.
BAD = [
    ("firmware/base/a.h", '#include "geometry/transform.h"\n', "firmware/base must not include firmware/geometry"),
    ("firmware/world/a.h", '#include "detect/detector.h"\n', "firmware/world must not include firmware/detect"),
    ("firmware/pose/a.h", '#include "detect/detector.h"\n', "firmware/pose must not include firmware/detect/detector.h"),
    ("firmware/pipeline/a.h", '#include "proto/registers.h"\n', "firmware/pipeline must not include proto/registers.h"),
    ("firmware/pipeline/a.h", '#include "outputs/wire.h"\n', "firmware/pipeline must not include firmware/outputs"),
    ("proto/a.h", '#include "report/report.h"\n', "proto must not include firmware/report"),
    ("firmware/pipeline/a.cpp", '#include "programs/main.cpp"\n', "firmware/pipeline must not include programs"),
    ("firmware/image/a.cpp", '#include "tests/support/render.h"\n', "firmware/image must not include tests/support"),
    ("drivers/camera/a.h", '#include "drivers/modbus/server.h"\n', "drivers/camera must not include drivers/modbus"),
    ("drivers/camera/a.h", '#include "pipeline/localiser.h"\n', "drivers/camera must not include firmware/pipeline"),
    ("firmware/pipeline/a.h", '#include "drivers/posix/fd.h"\n', "firmware/pipeline must not include drivers/posix"),
    ("firmware/config/a.h", '#include "drivers/posix/fd.h"\n', "firmware/config must not include drivers/posix"),
    ("drivers/modbus/a.h", '#include "programs/main.cpp"\n', "drivers/modbus must not include programs"),
    ("proto/a.cpp", '#include "drivers/posix/fd.h"\n', "proto must not include drivers/posix"),
    ("drivers/camera/a.cpp", "#include <modbus.h>\n", "<modbus.h> may be used in drivers/modbus only"),
    ("firmware/pipeline/a.cpp", "  #  include <libcamera/camera.h>\n", "may be used in drivers/camera only"),
    ("programs/a.cpp", "#include <png.h>\n", "may be used in drivers/picture only"),
    ("proto/a.cpp", "#include <opencv2/core.hpp>\n", "may be used in firmware/image"),
    ("firmware/pipeline/a.cpp", "#include <toml++/toml.h>\n", "may be used in firmware/config only"),
    ("firmware/world/a.cpp", "#include <ceres/ceres.h>\n", "may be used in firmware/mapping, firmware/calibrate_camera, firmware/calibrate_head only"),
    ("firmware/gadgets/a.cpp", "#include <cstdint>\n", "its folder is in no layer"),
    ("firmware/base/a.cpp", '#include "base/nowhere.h"\n', "is not in the tree"),
    ("proto/a.cpp", "\n" * (MAX_LINES + 1), "more than 500"),
    ("proto/z.h", "struct Taken final {\n", "Taken is a type of proto/wire.h as well"),
]


def write_tree(root, files):
    for path, text in files.items():
        os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
        with open(os.path.join(root, path), "w", encoding="utf-8") as file:
            file.write(text)


def self_test():
    with tempfile.TemporaryDirectory() as root:
        write_tree(root, GOOD)
        found, _ = violations(root)
        assert not found, f"a tree without a violation is refused: {found}"
    for path, text, expected in BAD:
        with tempfile.TemporaryDirectory() as root:
            write_tree(root, {**GOOD, path: text})
            found, _ = violations(root)
            assert len(found) == 1 and found[0].startswith(path) and expected in found[0], f"{path} {text!r}: reported {found}"
    with tempfile.TemporaryDirectory() as root:
        write_tree(root, {**GOOD, "firmware/detect/a.cpp": "\n" * 400})
        found, _ = violations(root)
        assert len(found) == 1 and found[0].startswith("firmware/detect: 402 of the 415 lines"), f"a room that is too large: {found}"
    print(f"layers: the check catches all {len(BAD) + 1} kinds of violation")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    found, count = violations(root)
    if count == 0:
        print(f"layers: no source files under {root}", file=sys.stderr)
        return 1
    for line in found:
        print(line, file=sys.stderr)
    if not found:
        print(f"layers: {count} files, every arrow points the right way")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
