#!/usr/bin/python3
"""Fails on a public number that does not say its unit.

    tests/units_test.py [ROOT]         checks the headers of firmware/, drivers/ and proto/ (default: the tree that this script is in)
    tests/units_test.py --self-test    proves on made-up headers what is caught and what passes

Looked at: every member, constant, parameter and return value that others can see and whose type is a number, an Eigen vector or
matrix, or a container of them. One of these must say what it is measured in:

- its type: std::chrono, MonoTime and Transform are not numbers here and need nothing more;
- its name: a unit of UNITS as its last word (`dead_band_rad`, `slew_rad_per_s`), or before a word like `at` (`focal_length_mm_at`);
- its documentation: a unit in brackets ([m], [px^2], [rad/s]; [1] where there is none), written out ("picture pixels", "in mm"), or "z = 1",
  where a ray is meant. A parameter's documentation is its \\param (or its name in backquotes), a return value's is \\return, else the
  text before the first \\param. What a class says of all its members in brackets holds for each of them;
- its kind, where it has no unit. Kinds are words in the name: KINDS below (a count, an index, an identity, a share of one, a grey level). An
  integer named by a plural counts what it names (`kMaxPoints`, `lost_frames`), and so does one named by what happened to it (`dropped`).
"""
import os
import re
import sys
import tempfile

TOPS = ("firmware", "drivers", "proto")

UNITS = set("""px px2 m m2 mm mm2 um rad rad2 deg deg2 hz khz lsb s ms us ns bytes kb mb bits degc celsius kelvin baud
               units radii steps percent permille ppm""".split())
UNITS_ANYWHERE = {unit for unit in UNITS if len(unit) > 1}  # m and s only at the end: they are words of one letter
FOLLOWED_BY = {"at", "of", "from", "for", "in", "on", "per"}

# A number of one of these kinds has no unit. One of the words of its name says which kind it is.
KINDS = {
    "count": "count number size length capacity depth total".split(),
    "index": "index i j k n row column x y u v position place slot octave line dot element frame sequence cursor first last buffer offset "
             "sector".split(),
    "identity": "id ids code address port unit function register pin channel socket errno error os fd descriptor handle version magic flag "
                "flags mask word byte raw value bit crc hash seed letter character pid errc fourcc format signal status priority command".split(),
    "share": "ratio share fraction part percentage probability likelihood odds ambiguity quality confidence score weight gain factor "
             "coverage occlusion visibility completeness overlap".split(),
    "level of a picture": "r g b red green blue cb cr luma chroma grey".split(),
    "plain number": "coefficient sine cosine sin cos tan exponent divisor multiplier degree order rank level attempt scale "
                    "determinant condition freedom quaternion".split(),
}
KIND_WORDS = {word for words in KINDS.values() for word in words}
# In floating point these words name lengths, places and sums, and those have units.
ONLY_INTEGERS = {*KINDS["count"], *KINDS["index"], *KINDS["level of a picture"], "value", "raw", "level", "degree", "part", "error"}
NO_PLURAL = {"radius", "bias", "axis", "focus", "address", "status", "class", "alias", "basis", "brightness", "sharpness", "thickness", "pos",
             "canvas", "loss", "less", "this", "pass", "has"}

IN_BRACKETS = re.compile(r"\[(1|[a-zA-Z%]+(\^-?\d)?([ /*]\s*[a-zA-Z]+(\^-?\d)?)*|1/[a-z]+(\^-?\d)?)\]")
WRITTEN_OUT = re.compile(
    r"z = 1(?!\d)|(?<![\w.-])(px|mm|rad|deg|ms|us|ns|Hz|lsb|bytes?|pixels?|metres?|millimetres?|degrees?|radians?|seconds|per second|milliseconds|"
    r"microseconds|nanoseconds|steps?|baud|grey levels?|per cent|per mille|dot radii)(?![\w-])")
DIMENSIONLESS = re.compile(
    r"(?i)(?<!\w)(how many|how often|number of|count of|counts|index of|ratio of|share of|part of|parts of|fraction of|probability|dimensionless|"
    r"0\.\.1|unit vector|any length|rotation matrix|errno|file descriptor)(?!\w)")

INTEGER = r"(?:std::)?(?:u?int(?:8|16|32|64)_t|size_t|ptrdiff_t)|unsigned(?: int| long(?: long)?| char| short)?|int|long(?: long)?|short|ssize_t"
FLOATING = r"double|float|Eigen::(?:Vector|RowVector|Matrix|Array|Map|Ref|DiagonalMatrix)\w*(?:<.*>)?|cv::(?:Point|Size|Matx|Vec)\w*"
INTEGER_TYPE, FLOATING_TYPE = re.compile(rf"^(?:{INTEGER})$"), re.compile(rf"^(?:{FLOATING})$")
WRAPPER = re.compile(r"^(?:std::|tl::)?(array|span|vector|optional|atomic|pair|expected|Result|InlineVector|initializer_list|LatestValue|Mailbox)<(.*)>$")
QUALIFIERS = re.compile(r"\b(?:const|constexpr|static|inline|mutable|volatile|explicit|virtual|friend|extern|typename|register|thread_local)\b|"
                        r"\[\[.*?\]\]|alignas\([^)]*\)")


def split_top(text, separator=","):
    """Splits at separators that stand in no bracket."""
    parts, depth, start = [], 0, 0
    for i, c in enumerate(text):
        if c in "(<[{":
            depth += 1
        elif c in ")]}" or (c == ">" and text[i - 1:i] != "-"):
            depth -= 1
        elif c == separator and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    return [part.strip() for part in parts + [text[start:]] if part.strip()]


class Numbers:
    """Which types are numbers: 'integer', 'floating' or None. Aliases of numbers are numbers."""

    def __init__(self):
        self.aliases = {}

    def kind(self, written, depth=0):
        text = re.sub(r"\s+", " ", QUALIFIERS.sub(" ", written)).strip().rstrip("&* ").strip()
        if depth > 4:
            return None
        if INTEGER_TYPE.match(text):
            return "integer"
        if FLOATING_TYPE.match(text):
            return "floating"
        if text in self.aliases:
            return self.kind(self.aliases[text], depth + 1)
        match = WRAPPER.match(text)
        if match:
            inside = split_top(match.group(2))
            # A row of single bytes is a message or a picture, not a quantity.
            if inside and re.sub(r"\bconst\b", "", inside[0]).strip() in ("std::uint8_t", "std::byte", "char", "unsigned char"):
                return self.kind(inside[0], depth + 1) if match.group(1) in ("optional", "atomic") else None
            kinds = [self.kind(part, depth + 1) for part in (inside if match.group(1) == "pair" else inside[:1])]
            return next((kind for kind in kinds if kind), None)
        return None


class Declaration:
    def __init__(self, text, line, doc, class_doc, opens_body=False):
        self.text, self.line, self.doc, self.class_doc, self.opens_body = text, line, doc, class_doc, opens_body


def blank(match):
    return re.sub(r"[^\n]", " ", match.group(0))


def declarations(source):
    """What others can see, each with its documentation: of namespaces and of the public part of classes, without function bodies."""
    docs, lines = {}, source.split("\n")
    for number, line in enumerate(lines, 1):
        match = re.search(r"///?<?\s?(.*)", line)
        if match and not line[:match.start()].count('"') % 2:
            docs[number] = (match.group(0).startswith("///"), line[:match.start()].strip() == "", match.group(1))
    code = re.sub(r'"(?:\\.|[^"\\\n])*"', lambda m: '"' + " " * (len(m.group(0)) - 2) + '"', source)
    code = re.sub(r"'(?:\\.|[^'\\\n])'", "' '", code)
    code = re.sub(r"//[^\n]*|/\*.*?\*/", blank, code, flags=re.S)
    code = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, code, flags=re.M)

    def doc_of(first, last, stop):
        above, number = [], first - 1
        while number in docs and docs[number][1]:
            above.insert(0, docs[number][2] if docs[number][0] else "")
            number -= 1
        trailing = [docs[n][2] for n in range(first, last + 1) if n in docs and docs[n][0]]
        number = last + 1
        while last in docs and number in docs and docs[number][1] and number < stop and "///<" in lines[number - 1]:
            trailing.append(docs[number][2])
            number += 1
        return "\n".join(above + trailing)

    found, stack, start, line, round_depth = [], [("namespace", True, "")], None, 1, 0
    i, text = 0, ""
    while i < len(code):
        c = code[i]
        if c == "\n":
            line += 1
        kind, visible, class_doc = stack[-1]
        if kind == "body":
            if c == "{":
                stack.append(("body", False, ""))
            elif c == "}":
                stack.pop()
                if stack[-1][0] == "initialiser":
                    stack.pop()
                    text += "}"
                elif stack[-1][0] != "body":
                    text, start = "", None
            i += 1
            continue
        if not text.strip() and not c.isspace():
            start = line
        if c in "([":
            round_depth += 1
        elif c in ")]":
            round_depth -= 1
        if c == "{" and round_depth > 0 or c == "{" and is_initialiser(text):
            stack += [("initialiser", visible, class_doc), ("body", False, "")]
            text += "{"
        elif c == "{":
            head = " ".join(text.split())
            match = re.match(r"(?:template <.*> )?(?:typedef )?(namespace|class|struct|union|enum|extern)\b", head)
            if match and match.group(1) in ("namespace", "extern"):
                stack.append(("namespace", visible, ""))
            elif match and match.group(1) != "enum" and "(" not in re.sub(r"alignas\([^)]*\)", "", head):
                stack.append(("class", visible and match.group(1) != "class", doc_of(start, start, line)))
                if not visible:
                    stack[-1] = ("hidden class", False, "")
            else:
                if not match and visible:
                    found.append(Declaration(head, start, doc_of(start, line, line + 1), class_doc, True))
                stack.append(("body", False, ""))
            text, start = "", None
        elif c == "}":
            stack.pop()
            text, start = "", None
        elif c == ";" and round_depth == 0:
            if visible and text.strip():
                found.append(Declaration(" ".join(text.split()), start, doc_of(start, line, line + 20), class_doc))
            text, start = "", None
        else:
            text += c
            match = re.match(r"\s*(public|protected|private)\s*:$", text)
            if match and code[i + 1:i + 2] != ":":
                if kind == "class":
                    stack[-1] = ("class", match.group(1) != "private", class_doc)
                text, start = "", None
        i += 1
    if len(stack) != 1:
        raise ValueError("braces that this script does not understand")
    return found


def is_initialiser(text):
    """Whether the brace after this text holds values (`int x{`, `int x = {`) and no body."""
    head = " ".join(text.split())
    if re.match(r"(?:template <.*> )?(?:namespace|class|struct|union|enum|extern)\b", head):
        return False
    if re.search(r"=\s*$", head):
        return True
    if re.search(r"\)\s*(const|noexcept|override|final|->.*|:.*)?[\s\w&:]*$", head) and "(" in head.split("=")[0]:
        # A constructor's list of members: `: a_{1}, b_(2) {`. Its own braces follow a name directly.
        return bool(re.search(r"\)\s*(noexcept)?\s*:.*[\w]$", head))
    return bool(re.search(r"[\w\]>]$", head))


NAME = re.compile(r"^(.*?[\s&*>])((?:operator\s*[^\s(\w]+|operator\(\)|~?\w+))\s*(\[[^\]]*\])?$", re.S)


def variables(text):
    """(type, name) of each variable that a declaration without parentheses declares."""
    parts = split_top(text)
    first, found, written = True, [], None
    for part in parts:
        part = re.split(r"(?<![=!<>])=(?!=)|\{", part)[0].strip()
        if first:
            match = NAME.match(part)
            if not match:
                return found
            written, name, first = match.group(1).strip(), match.group(2), False
        else:
            match = re.match(r"^[&*\s]*(\w+)", part)
            if not match:
                continue
            name = match.group(1)
        found.append((written, name))
    return found


def close_of(text, start):
    depth = 0
    for i in range(start, len(text)):
        if text[i] == "(":
            depth += 1
        elif text[i] == ")":
            depth -= 1
            if depth == 0:
                return i
    return len(text)


def quantities(declaration, numbers):
    """(what, name, kind, documentation) of each number in a declaration."""
    text = re.sub(r"^template <.*?> (?=\w)", "", declaration.text)
    text = re.sub(r"\s+", " ", QUALIFIERS.sub(" ", text)).strip()
    if re.match(r"(using|typedef|namespace|class|struct|union|enum|static_assert|return|NINEDOT_\w+|public|template)\b", text):
        return []
    before_value = re.split(r"(?<![=!<>])=(?!=)", text)[0]
    match = re.search(r"(operator\s*\(\)|operator\s*[^\s(\w]+|[\w~]+)\s*\(", before_value)
    if not match or "{" in before_value[:match.start()]:
        return [("", name, numbers.kind(written), declaration.doc) for written, name in variables(text) if numbers.kind(written)]
    name, returned = match.group(1), text[:match.start()].strip()
    if "operator" in name and re.search(r"operator\s*(==|!=|<|>|<=>|=|bool|\[\])", name):
        return []
    found, sections = [], parts_of(declaration.doc)
    kind = numbers.kind(returned)
    pointer_to_out = returned.endswith("*")
    if kind and not pointer_to_out:
        found.append(("returned by ", name, kind, sections.get("return", sections[""])))
    inside = text[match.end():close_of(text, match.end() - 1)]
    for written, parameter in (pair for part in split_top(inside) for pair in variables(part)):
        if numbers.kind(written):
            found.append((f"parameter of {name}: ", parameter, numbers.kind(written), sections.get(parameter, mention(sections[""], parameter))))
    return found


def parts_of(doc):
    """The documentation by what it is about: '' the function, 'return', and each parameter's name."""
    sections, now = {"": ""}, [""]
    for piece in re.split(r"(\\param\s+\w+(?:\s*,\s*\w+)*|\\return|\\error)", doc):
        if piece.startswith("\\param"):
            now = re.split(r"[\s,]+", piece)[1:]
        elif piece.startswith("\\"):
            now = [piece[1:]]
        else:
            for key in now:
                sections[key] = sections.get(key, "") + piece
    return sections


def mention(doc, parameter):
    """The sentences that name a parameter in backquotes."""
    return " ".join(sentence for sentence in re.split(r"(?<=[.;])\s", doc) if f"`{parameter}`" in sentence)


def words_of(name):
    name = re.sub(r"^k(?=[A-Z])", "", name.strip("_"))
    return [word.lower() for part in name.split("_") for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+", part)]


def unit_in_name(name):
    words = [word for word in re.split(r"_+", name.strip("_")) if word]
    lower = [word.lower() for word in words]
    if not words:
        return False
    if lower[-1] in UNITS:
        return True
    return any(word in UNITS_ANYWHERE and after in FOLLOWED_BY for word, after in zip(lower, lower[1:]))


def kind_in_name(name, kind):
    words = words_of(name)
    if kind == "integer" and any(word in KIND_WORDS for word in words):
        return True
    if kind == "floating" and any(word in KIND_WORDS - ONLY_INTEGERS for word in words):
        return True
    return kind == "integer" and any(len(word) > 3 and word.endswith(("s", "ed")) and word not in NO_PLURAL for word in words)


def says_its_unit(name, kind, doc, class_doc):
    if unit_in_name(name) or kind_in_name(name, kind):
        return True
    if IN_BRACKETS.search(doc) or WRITTEN_OUT.search(doc) or DIMENSIONLESS.search(doc):
        return True
    return bool(IN_BRACKETS.search(class_doc))


def headers(root):
    for top in TOPS:
        for folder, subfolders, names in os.walk(os.path.join(root, top)):
            subfolders.sort()
            for name in sorted(names):
                if name.endswith((".h", ".hpp")):
                    yield os.path.relpath(os.path.join(folder, name), root)


def examine(root):
    """{header: ([line: what is missing], how many numbers it has)}"""
    sources, numbers = {}, Numbers()
    for path in headers(root):
        with open(os.path.join(root, path), encoding="utf-8") as file:
            sources[path] = file.read()
        for match in re.finditer(r"\busing (\w+) = ([^;]+);", sources[path]):
            numbers.aliases[match.group(1)] = match.group(2)
    result = {}
    for path, source in sources.items():
        missing, count = [], 0
        try:
            declared = declarations(source)
        except (ValueError, IndexError) as error:
            raise SystemExit(f"units: {path}: {error}") from error
        for declaration in declared:
            for what, name, kind, doc in quantities(declaration, numbers):
                count += 1
                if not says_its_unit(name, kind, doc, declaration.class_doc):
                    missing.append(f"{path}:{declaration.line}: {what}{name}")
        result[path] = (missing, count)
    return result


# One header each, and the numbers in it that must be called.
HEADERS = [
    ("struct A {\n  double width_px = 0, gap = 0;\n};", ["gap"]),
    ("struct A {\n  double gap = 0;  ///< between two dots [m]\n  double reach = 1;\n};", ["reach"]),
    ("struct A {\n  double gap = 0;  // [m]: not for others\n};", ["gap"]),
    ("struct A {\n  /// Between two dots,\n  /// in mm.\n  float gap = 0;\n};", []),
    ("/// Lengths [m].\nstruct A {\n  double gap = 0, reach{1};\n};", []),
    ("class A {\n  double hidden = 0;\n public:\n  double seen = 0;\n private:\n  double mine_ = 0;\n};", ["seen"]),
    ("class A {\n  struct B {\n    double hidden = 0;\n  };\n public:\n  struct C {\n    double seen = 0;\n  };\n};", ["seen"]),
    ("inline constexpr double kReach = 3;\ninline constexpr double kReach_m = 3;", ["kReach"]),
    ("constexpr std::array<double, 2> kReach{1, 2};", ["kReach"]),
    ("struct A {\n  int dots = 0;\n  std::uint32_t dropped = 0;\n  std::uint64_t frame_number = 0;\n  double gain = 1;\n  int radius = 0;\n};", ["radius"]),
    ("struct A {\n  double position = 0, frames = 0;\n};", ["position", "frames"]),
    ("struct A {\n  std::chrono::nanoseconds wait{};\n  MonoTime at{};\n  bool is_open = false;\n  std::string name = \"a; double b\";\n};", []),
    ("double reach(double gap, double angle_rad) noexcept;", ["reach", "gap"]),
    ("/// \\param gap  [m]\n/// \\return  the same in mm\ndouble reach(double gap) noexcept;", []),
    ("/// \\param gap  [m]\ndouble reach(double gap) noexcept;", ["reach"]),
    ("struct A {\n  const char* text = \"{ double b;\";\n  double after = 0;\n};", ["after"]),
    ("/// How far `gap` [m] reaches.\n/// \\return  a share\ndouble reach(double gap, double other);", ["reach", "other"]),
    ("double reach_m(int x) {\n  double inner = x;\n  return inner;\n}\ndouble behind();", ["behind"]),
    ("using Six = Eigen::Matrix<double, 6, 1>;\nstruct A {\n  Six step;\n  std::optional<Six> next;\n};", ["step", "next"]),
    ("void fill(std::span<const std::uint8_t> message, std::span<const double> heights);", ["heights"]),
    ("struct A {\n  explicit A(double reach) : reach_m{reach} {}\n  double reach_m;\n  double after = 0;\n};", ["reach", "after"]),
    ("struct A {\n  bool operator==(const A&) const = default;\n  double operator()(double reach_m) const;\n};", ["operator()"]),
    ("enum class Kind : int { kA = 1, kB };\nstruct A {\n  Kind kind = Kind::kA;\n  double focal_mm_at(int index) const;\n};", []),
    ("template <typename T, int N>\nclass A {\n public:\n  Result<double> height() const;\n  T value;\n};", ["height"]),
    ("#define REACH(x) \\\n  double x;\n/* double old; */\nstruct A {\n  Eigen::Vector3d p_world;  ///< frame world [m]\n};", []),
]


def self_test():
    for text, expected in HEADERS:
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "firmware/base"))
            with open(os.path.join(root, "firmware/base/a.h"), "w", encoding="utf-8") as file:
                file.write("#pragma once\nnamespace ninedot {\n\n" + text + "\n\n}  // namespace ninedot\n")
            missing, _ = examine(root)["firmware/base/a.h"]
            called = [line.split(": ")[-1].removeprefix("returned by ") for line in missing]
            assert called == expected, f"{text}\nmust call {expected}, called {missing}"
    print(f"units: the check calls what is missing in {len(HEADERS)} headers")


def main():
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        self_test()
        return 0
    root = arguments[0] if arguments else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    result = examine(root)
    total = sum(count for _, count in result.values())
    if total == 0:
        print(f"units: no public numbers under {root}", file=sys.stderr)
        return 1
    wrong = [line for missing, _ in result.values() for line in missing]
    for line in wrong:
        print(line, file=sys.stderr)
    with_numbers = [missing for missing, count in result.values() if count]
    clean = sum(not missing for missing in with_numbers)
    print(f"units: {total - len(wrong)} of {total} public numbers say theirs ({100 * (total - len(wrong)) / total:.1f} %), "
          f"all of them in {clean} of {len(with_numbers)} headers ({100 * clean / len(with_numbers):.1f} %)")
    if wrong:
        print("units: give the unit in the name (_px _m _rad ...) or in the documentation ([px] [m] ...; [1]: none), see tests/units_test.py",
              file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
