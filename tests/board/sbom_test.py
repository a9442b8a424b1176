#!/usr/bin/python3
"""The software bill of materials: toolchains/sbom.py on a root made here; and, with an image, that image's against its own dpkg database.

    tests/board/sbom_test.py                  the first
    tests/board/sbom_test.py IMAGE-FOLDER     the second: build/image. Needs squashfs-tools
"""

import copy
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
NAME = "ninedot-arm64"
# What SPDX 2.3 asks of a package, and its forms of identifiers and times (clauses 3.2, 6.9, 7).
PACKAGE_KEYS = {"SPDXID", "name", "versionInfo", "supplier", "downloadLocation", "filesAnalyzed", "licenseConcluded", "licenseDeclared", "copyrightText"}
DOCUMENT_KEYS = {"spdxVersion", "dataLicense", "SPDXID", "name", "documentNamespace", "creationInfo", "packages", "relationships"}
PURPOSES = {"APPLICATION", "FRAMEWORK", "LIBRARY", "CONTAINER", "OPERATING-SYSTEM", "DEVICE", "FIRMWARE", "SOURCE", "ARCHIVE", "FILE", "INSTALL", "OTHER"}

sys.path.insert(0, str(SOURCE / "toolchains"))
import sbom  # noqa: E402  (from the folder above)


def faults_of_expression(expression, declared):
    """An expression is NOASSERTION, or names of licences with AND, OR and brackets that close; SPDX's own names, or those that the document explains."""
    if expression == "NOASSERTION":
        return []
    known = set(sbom.SPDX_OF_DEBIAN.values()) | declared
    tokens = re.findall(r"[()]|[^\s()]+", expression)
    depth, wants_name, faults = 0, True, []
    for token in tokens:
        if token == "(" and wants_name:
            depth += 1
        elif token == ")" and not wants_name and depth > 0:
            depth -= 1
        elif token in ("AND", "OR") and not wants_name:
            wants_name = True
        elif wants_name and token in known:
            wants_name = False
        else:
            faults.append(f"'{token}' in the licence '{expression}'")
    return faults + ([f"unfinished licence '{expression}'"] if depth or wants_name else [])


def faults_of(document):
    """Returns what is wrong with the document as SPDX 2.3"""
    faults = [f"no {key}" for key in sorted(DOCUMENT_KEYS - document.keys())]
    if faults:
        return faults
    identifiers = [document["SPDXID"], *(package.get("SPDXID", "") for package in document["packages"])]
    faults += [f"'{i}' is no identifier" for i in identifiers if not re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", i)]
    faults += [f"'{i}' twice" for i in set(identifiers) if identifiers.count(i) > 1]
    if (document["spdxVersion"], document["dataLicense"], document["SPDXID"]) != ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"):
        faults.append("version, licence or identifier of the document")
    if not re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", document["creationInfo"].get("created", "")) or not document["creationInfo"].get("creators"):
        faults.append("when it was made, and with what")
    if not re.fullmatch(r"https?://[^\s#]+", document["documentNamespace"]):
        faults.append("its namespace")
    declared = {info["licenseId"] for info in document.get("hasExtractedLicensingInfos", [])}
    faults += [f"licence {i}" for i in declared if not re.fullmatch(r"LicenseRef-[A-Za-z0-9.-]+", i)]
    faults += [f"no text for {info['licenseId']}" for info in document.get("hasExtractedLicensingInfos", []) if not info.get("extractedText")]
    for package in document["packages"]:
        faults += [f"{package.get('name')}: no {key}" for key in sorted(PACKAGE_KEYS - package.keys())]
        faults += faults_of_expression(package.get("licenseDeclared", ""), declared)
        if not re.match(r"(Person|Organization): \S|NOASSERTION$", package.get("supplier", "")):
            faults.append(f"{package.get('name')}: supplier {package.get('supplier')}")
        if package.get("primaryPackagePurpose") not in PURPOSES:
            faults.append(f"{package.get('name')}: purpose {package.get('primaryPackagePurpose')}")
    described = {r["relatedSpdxElement"] for r in document["relationships"] if r["relationshipType"] == "DESCRIBES"}
    contained = {r["relatedSpdxElement"] for r in document["relationships"] if r["relationshipType"] == "CONTAINS"}
    faults += [f"{r} is related to nothing" for r in set(identifiers[1:]) - described - contained]
    faults += [f"{end} of a relationship is nowhere" for r in document["relationships"] for end in (r["spdxElementId"], r["relatedSpdxElement"]) if end not in identifiers]
    return faults


STATUS = """Package: libexample1
Status: install ok installed
Architecture: arm64
Maintainer: Debian Example Team <example@lists.debian.org>
Source: example (1.2-3)
Version: 1.2-3+b1
Homepage: https://example.org
Description: an example
 with more to say

Package: gone
Status: deinstall ok config-files
Architecture: arm64
Version: 1
Description: no longer there

Package: ninedot
Status: install ok installed
Architecture: arm64
Maintainer: ninedot <x@example.org>
Version: 0.1.0-1
Description: position sensor

Package: g++-x
Status: install ok installed
Architecture: all
Maintainer: A Person <a@example.org>
Version: 2:3~4
Description: a name with signs
"""
COPYRIGHT = """Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/

Files: *
Copyright: somebody
License: GPL-2+ or Artistic

Files: contrib/*
Copyright: another
License: house-rules
 Do what the house says.
 .
 Or leave.

License: GPL-2+
 see common-licenses
"""


class Document(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("var/lib/dpkg/status", STATUS)
        self.write("usr/share/doc/libexample1/copyright", COPYRIGHT)
        self.write("usr/share/doc/ninedot/copyright", "Somebody's rights, in prose.\n")
        (self.root / "usr/share/doc/g++-x").symlink_to("libexample1")
        os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
        self.addCleanup(os.environ.pop, "SOURCE_DATE_EPOCH")
        self.document = sbom.document(str(self.root), NAME, "1", [])

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text)

    def package(self, name):
        return next(package for package in self.document["packages"] if package["name"] == name)

    def test_is_sound(self):
        self.assertEqual(faults_of(self.document), [])

    def test_has_what_is_installed_and_nothing_else(self):
        self.assertEqual([package["name"] for package in self.document["packages"]], [NAME, "g++-x", "libexample1", "ninedot"])

    def test_tells_version_source_and_supplier(self):
        package = self.package("libexample1")
        self.assertEqual(package["versionInfo"], "1.2-3+b1")
        self.assertEqual(package["sourceInfo"], "built from source package example 1.2-3")
        self.assertEqual(package["supplier"], "Organization: Debian Example Team (example@lists.debian.org)")
        self.assertEqual(package["externalRefs"][0]["referenceLocator"], "pkg:deb/debian/libexample1@1.2-3%2Bb1?arch=arm64&distro=trixie")
        self.assertEqual(self.package("g++-x")["supplier"], "Person: A Person (a@example.org)")

    def test_tells_licences_where_they_can_be_read_by_machine(self):
        wanted = "(GPL-2.0-or-later OR Artistic-1.0-Perl) AND LicenseRef-debian-house-rules"
        self.assertEqual(self.package("libexample1")["licenseDeclared"], wanted)
        self.assertEqual(self.package("g++-x")["licenseDeclared"], wanted, "a link to another package's folder")
        self.assertEqual(self.package("ninedot")["licenseDeclared"], "NOASSERTION")
        self.assertEqual([info["extractedText"] for info in self.document["hasExtractedLicensingInfos"]], ["Do what the house says.\n\nOr leave."])

    def test_the_same_root_gives_the_same_document(self):
        self.assertEqual(json.dumps(sbom.document(str(self.root), NAME, "1", [])), json.dumps(self.document))

    def test_another_version_of_anything_is_another_document(self):
        self.write("var/lib/dpkg/status", STATUS.replace("1.2-3+b1", "1.2-3+b2"))
        self.assertNotEqual(sbom.document(str(self.root), NAME, "1", [])["documentNamespace"], self.document["documentNamespace"])

    def test_each_fault_is_found(self):
        def broken(change):
            document = copy.deepcopy(self.document)
            change(document)
            return faults_of(document)

        for what, change in {
                "no version": lambda d: d["packages"][1].pop("versionInfo"),
                "twice": lambda d: d["packages"].append(d["packages"][1]),
                "related to nothing": lambda d: d["relationships"].pop(),
                "leads nowhere": lambda d: d["relationships"][1].update(relatedSpdxElement="SPDXRef-X"),
                "unknown licence": lambda d: d["packages"][2].update(licenseDeclared="GPL-2+"),
                "unfinished licence": lambda d: d["packages"][2].update(licenseDeclared="MIT AND"),
                "unexplained licence": lambda d: d["hasExtractedLicensingInfos"].clear(),
                "no time": lambda d: d["creationInfo"].update(created="today"),
                "supplier": lambda d: d["packages"][1].update(supplier="somebody"),
                "no relationships": lambda d: d.pop("relationships")}.items():
            self.assertNotEqual(broken(change), [], what)


def file_of_image(image, path):
    """Returns a file of the image's root, its second partition"""
    with open(image, "rb") as file:
        first = struct.unpack_from("<I", file.read(512), 446 + 16 + 8)[0]
    done = subprocess.run(["unsquashfs", "-o", str(first * 512), "-cat", str(image), path], capture_output=True, check=True)
    return done.stdout.decode()


def check_image(folder):
    """Each package of the image's dpkg database is in its bill, with that version, and the other way round but for what the bill calls unpacked."""
    image = next(iter(folder.glob(f"{NAME}*.img")), folder / f"{NAME}.img")
    bill = image.with_suffix(".spdx.json")
    text = bill.read_text(encoding="utf-8")
    document = json.loads(text)
    faults = faults_of(document)
    installed = {(p["package"], p["architecture"], p["version"])
                 for p in sbom.paragraphs(file_of_image(image, "var/lib/dpkg/status")) if p.get("status", "").endswith(" installed")}
    listed, unpacked = set(), set()
    for package in document["packages"][1:]:
        architecture = re.search(r"\?arch=(\w+)", package["externalRefs"][0]["referenceLocator"])[1]
        (unpacked if "comment" in package else listed).add((package["name"], architecture, package["versionInfo"]))
    faults += [f"not in the bill: {what}" for what in sorted(installed - listed)] + [f"in the bill alone: {what}" for what in sorted(listed - installed)]
    names = {name for name, _, _ in unpacked}
    # A Raspberry Pi 5 has its firmware on the board.
    unpacked_always = {"busybox-static", "u-boot-rpi"} | ({"raspi-firmware"} if image.stem == NAME else set())
    faults += [f"not in the bill: {what}" for what in sorted(unpacked_always - names)]
    faults += [] if any(name.startswith("linux-image-") for name in names) else ["the kernel is not in the bill"]
    faults += [f"{what} is not installed" for what in ("ninedot", "ninedot-web") if what not in {name for name, _, _ in installed}]
    if file_of_image(image, "usr/share/ninedot/sbom.spdx.json") != text:
        faults.append("the image holds another bill than the one beside it")
    if faults:
        print("FAILED: the bill of materials: " + "; ".join(faults[:20]), file=sys.stderr)
        return 1
    known = sum(package["licenseDeclared"] != "NOASSERTION" for package in document["packages"])
    print(f"ok: bill of materials: {len(installed)} installed packages with their versions, {len(unpacked)} unpacked; {known} with a machine-readable licence")
    return 0


if __name__ == "__main__":
    if len(sys.argv) == 2 and not sys.argv[1].startswith("-"):
        sys.exit(check_image(pathlib.Path(sys.argv[1])))
    unittest.main(verbosity=2)
