#!/usr/bin/python3
"""What a Debian root is made of, as an SPDX 2.3 document in JSON: each package with version, source, supplier and licences.

    toolchains/sbom.py ROOT --name NAME --version VERSION --out FILE [--unpacked DEB...]

From the root's own dpkg database and from /usr/share/doc/*/copyright, where that is machine-readable (DEP 5). --unpacked: packages whose files are in
the root without being installed there. SOURCE_DATE_EPOCH is the document's time: the same root gives the same bytes.
"""

import argparse
import datetime
import hashlib
import json
import os
import re
import subprocess
import sys
import urllib.parse

# Debian's short names of licences (DEP 5, and what packages write) that are SPDX's by another name. What is not here stays Debian's: LicenseRef-debian-NAME.
SPDX_OF_DEBIAN = {
    "apache-2": "Apache-2.0", "apache-2.0": "Apache-2.0", "artistic": "Artistic-1.0-Perl", "artistic-2": "Artistic-2.0", "artistic-2.0": "Artistic-2.0",
    "bsd-2": "BSD-2-Clause", "bsd-2-clause": "BSD-2-Clause", "bsd-3": "BSD-3-Clause", "bsd-3-clause": "BSD-3-Clause", "bsd-4-clause": "BSD-4-Clause",
    "bsl-1.0": "BSL-1.0", "boost-1.0": "BSL-1.0", "cc0-1.0": "CC0-1.0", "cc0": "CC0-1.0", "cc-by-4.0": "CC-BY-4.0", "cc-by-sa-4.0": "CC-BY-SA-4.0",
    "curl": "curl", "expat": "MIT", "isc": "ISC", "mit-0": "MIT-0", "mpl-1.1": "MPL-1.1", "mpl-2.0": "MPL-2.0", "openssl": "OpenSSL",
    "psf-2": "PSF-2.0", "psf-2.0": "PSF-2.0", "unlicense": "Unlicense", "zlib": "Zlib", "0bsd": "0BSD", "x11": "X11", "wtfpl": "WTFPL",
    "ofl-1.1": "OFL-1.1", "bzip2-1.0.6": "bzip2-1.0.6", "libpng": "Libpng", "afl-2.1": "AFL-2.1",
    **{f"{kind.lower()}-{debian}{plus}": f"{kind}-{spdx}-{'or-later' if plus else 'only'}"
       for kind, versions in (("GPL", ("1", "2", "3")), ("LGPL", ("2", "2.1", "3")), ("AGPL", ("3",)), ("GFDL", ("1.2", "1.3")))
       for number in versions
       for debian, spdx in ((number, number if "." in number else number + ".0"), (number if "." in number else number + ".0",) * 2)
       for plus in ("", "+")},
}


def fail(what):
    print(f"sbom.py: {what}", file=sys.stderr)
    sys.exit(2)


def paragraphs(text):
    """[{field: value}] of a file in Debian's control format; names of fields in lower case."""
    found = []
    for block in re.split(r"\n[ \t]*\n", text):
        fields, name = {}, None
        for line in block.splitlines():
            if line[:1] in (" ", "\t") and name:
                fields[name] += "\n" + line[1:]
            elif (match := re.match(r"([A-Za-z][A-Za-z0-9-]*):[ \t]*(.*)", line)):
                name = match[1].lower()
                fields[name] = match[2]
        if fields:
            found.append(fields)
    return found


def installed_packages(root):
    """Returns the paragraphs of what is installed, by name"""
    with open(os.path.join(root, "var/lib/dpkg/status"), encoding="utf-8") as file:
        found = [p for p in paragraphs(file.read()) if p.get("status", "").split()[-1:] == ["installed"]]
    return sorted(found, key=lambda p: (p["package"], p["architecture"]))


def control_of(deb):
    done = subprocess.run(["dpkg-deb", "-f", deb], capture_output=True, text=True, check=True)
    return paragraphs(done.stdout)[0]


def copyright_of_deb(deb, package):
    """Returns the text, empty where the package leaves it to another one"""
    members = subprocess.Popen(["dpkg-deb", "--fsys-tarfile", deb], stdout=subprocess.PIPE)
    done = subprocess.run(["tar", "-xO", f"./usr/share/doc/{package}/copyright"], stdin=members.stdout, capture_output=True, check=False)
    members.stdout.close()
    members.wait()
    return done.stdout.decode("utf-8", errors="replace")


def copyright_in_root(root, package):
    """Returns the text, empty where there is none. Links lead about in the root, not in this machine."""
    folder = os.path.join(root, "usr/share/doc", package)
    if os.path.islink(folder):
        folder = os.path.join(root, "usr/share/doc", os.path.basename(os.readlink(folder)))
    path = os.path.join(folder, "copyright")
    for _ in range(4):
        if not os.path.islink(path):
            break
        target = os.readlink(path)
        path = os.path.join(root, target.lstrip("/")) if target.startswith("/") else os.path.normpath(os.path.join(os.path.dirname(path), target))
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError:
        return ""


class Licences:
    """SPDX's expressions for what packages say, and what Debian's own names in them stand for."""

    def __init__(self):
        self.extracted = {}

    def one(self, name, texts):
        plain = name.strip().lower()
        if plain in SPDX_OF_DEBIAN:
            return SPDX_OF_DEBIAN[plain]
        identifier = "LicenseRef-debian-" + re.sub(r"[^A-Za-z0-9.-]+", "-", name.strip()).strip("-")
        text = texts.get(plain, "").strip()
        known = self.extracted.setdefault(identifier, {"name": name.strip(), "text": text})
        if not known["text"]:
            known["text"] = text
        return identifier

    def expression(self, synopsis, texts):
        """'GPL-2+ or Artistic' becomes '(GPL-2.0-or-later OR Artistic-1.0-Perl)'. What has more grammar than that is one name as a whole."""
        synopsis = " ".join(synopsis.split())
        if not re.search(r" (and|or) ", synopsis, re.I) or re.search(r",|\(| with ", synopsis):
            return self.one(synopsis, texts)
        either = []
        for part in re.split(r" or ", synopsis, flags=re.I):
            both = [self.one(word, texts) for word in re.split(r" and ", part, flags=re.I)]
            either.append(both[0] if len(both) == 1 else "(" + " AND ".join(both) + ")")
        return either[0] if len(either) == 1 else "(" + " OR ".join(either) + ")"

    def of(self, text):
        """Returns the expression of a machine-readable copyright file, None where it is none"""
        if not re.match(r"(?i)format:\s*\S*(copyright-format|dep-?5|copyright/)", text.lstrip("\ufeff \n")):
            return None
        found = paragraphs(re.sub(r"(?m)^#.*\n", "", text))
        texts, synopses = {}, []
        for fields in found:
            synopsis, _, body = fields.get("license", "").partition("\n")
            if not synopsis.strip():
                continue
            if body.strip():
                texts.setdefault(synopsis.strip().lower(), re.sub(r"(?m)^\.$", "", body))
            if "files" in fields:
                synopses.append(synopsis)
        expressions = sorted({self.expression(synopsis, texts) for synopsis in synopses})
        return " AND ".join(expressions) if expressions else None


def identifier_of(package):
    return "SPDXRef-Package-" + re.sub(r"[^A-Za-z0-9.-]", lambda match: f"-{ord(match[0]):02x}-", f"{package['package']}-{package['architecture']}")


def supplier_of(package):
    """Returns the maintainer as SPDX writes a supplier"""
    name = package.get("maintainer", "").strip()
    match = re.fullmatch(r"(.*?)\s*<(.*)>", name)
    if not match:
        return f"Organization: {name}" if name else "NOASSERTION"
    kind = "Organization" if re.search(r"(?i)team|maintainers|developers|group|packagers|ninedot", match[1]) else "Person"
    return f"{kind}: {match[1].strip(chr(34))} ({match[2]})"


def described(package, licence, comment):
    """Returns SPDX's description of one package"""
    is_own = package["package"] == "ninedot" or package["package"].startswith("ninedot-")
    source, _, version = package.get("source", package["package"]).partition(" ")
    version = version.strip("()") or package["version"]
    quoted = urllib.parse.quote
    purl = (f"pkg:deb/{'ninedot' if is_own else 'debian'}/{quoted(package['package'], safe='')}@{quoted(package['version'], safe='')}"
            f"?arch={package['architecture']}" + ("" if is_own else "&distro=trixie"))
    entry = {
        "SPDXID": identifier_of(package),
        "name": package["package"],
        "versionInfo": package["version"],
        "supplier": supplier_of(package),
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "sourceInfo": f"built from source package {source} {version}",
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": licence or "NOASSERTION",
        "copyrightText": "NOASSERTION",
        "summary": package.get("description", "").split("\n")[0],
        "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": purl}],
        "primaryPackagePurpose": "OPERATING-SYSTEM" if package["package"].startswith("linux-image-") else "LIBRARY" if package["package"].startswith("lib") else "APPLICATION",
    }
    if package.get("homepage"):
        entry["homepage"] = package["homepage"]
    if comment:
        entry["comment"] = comment
    return entry


def document(root, name, version, unpacked):
    """Returns the whole, ready for JSON"""
    licences, entries = Licences(), []
    for package in installed_packages(root):
        entries.append(described(package, licences.of(copyright_in_root(root, package["package"])), None))
    for deb in sorted(unpacked, key=os.path.basename):
        package = control_of(deb)
        entries.append(described(package, licences.of(copyright_of_deb(deb, package["package"])), "unpacked, in whole or in part, without being installed: not in dpkg's database"))
    image = {
        "SPDXID": "SPDXRef-Image", "name": name, "versionInfo": version, "supplier": "Organization: ninedot", "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
        "licenseConcluded": "NOASSERTION", "licenseDeclared": "NOASSERTION", "copyrightText": "NOASSERTION", "primaryPackagePurpose": "OPERATING-SYSTEM",
    }
    created = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), datetime.timezone.utc)
    content = hashlib.sha256(json.dumps([image, entries], sort_keys=True).encode()).hexdigest()
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"{name}-{version}",
        "documentNamespace": f"https://ninedot.invalid/spdx/{urllib.parse.quote(name)}-{urllib.parse.quote(version)}-{content[:32]}",
        "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Organization: ninedot", "Tool: ninedot-sbom-1"]},
        "documentDescribes": [image["SPDXID"]],
        "packages": [image, *entries],
        "hasExtractedLicensingInfos": [
            {"licenseId": identifier, "name": licence["name"],
             "extractedText": licence["text"] or f"Named '{licence['name']}' in the copyright files of Debian's packages, which see."}
            for identifier, licence in sorted(licences.extracted.items())],
        "relationships": [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": image["SPDXID"]}] + [
            {"spdxElementId": image["SPDXID"], "relationshipType": "CONTAINS", "relatedSpdxElement": entry["SPDXID"]} for entry in entries],
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root")
    parser.add_argument("--name", required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--unpacked", nargs="*", default=[])
    arguments = parser.parse_args()
    if not os.path.exists(os.path.join(arguments.root, "var/lib/dpkg/status")):
        fail(f"{arguments.root} is no Debian root: it has no var/lib/dpkg/status")
    made = document(arguments.root, arguments.name, arguments.version, arguments.unpacked)
    with open(arguments.out, "w", encoding="utf-8") as file:
        json.dump(made, file, indent=1, ensure_ascii=False)
        file.write("\n")
    known = sum(package["licenseDeclared"] != "NOASSERTION" for package in made["packages"])
    print(f"sbom.py: {len(made['packages']) - 1} packages, {known} with a machine-readable licence")


if __name__ == "__main__":
    main()
