"""Checks wheels and source distributions: size, licences, bill of materials, metadata, no symbols for debugging.

    python ci/check-wheels.py VERSION FILE...
"""

import re
import struct
import sys
import tarfile
import zipfile
from email.parser import BytesParser
from pathlib import Path

MOST_BYTES = 8_000_000
NOTICES = ("LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY.txt")
FIELDS = {
    "Author": 1,
    "Classifier": 10,
    "License-Expression": 1,
    "License-File": len(NOTICES),
    "Project-URL": 4,
    "Requires-Dist": 1,
    "Requires-Python": 1,
    "Summary": 1,
}
faults = []


def check(file: Path, is_right: object, fault: str) -> None:
    """Notes a fault of a file."""
    if not is_right:
        faults.append(f"{file.name}: {fault}")


def sections(library: bytes) -> set[str]:
    """Returns the names of the sections of an ELF file of 64 bits; none for other files."""
    if library[:5] != b"\x7fELF\x02":
        return set()
    (table,) = struct.unpack_from("<Q", library, 0x28)
    size, count, of_names = struct.unpack_from("<HHH", library, 0x3A)
    headers = [struct.unpack_from("<IIQQQQ", library, table + size * number) for number in range(count)]
    names = headers[of_names][4]
    ends = [(names + header[0], library.index(b"\0", names + header[0])) for header in headers]
    return {library[start:end].decode() for start, end in ends}


def check_metadata(file: Path, text: bytes, version: str) -> None:
    """Checks the fields that PyPI shows, and that links of the description are absolute."""
    metadata = BytesParser().parsebytes(text)
    check(file, metadata["Name"] == "geosweep", f"its name is {metadata['Name']}")
    check(file, metadata["Version"] == version, f"its version is {metadata['Version']}, not {version}")
    for field, least in FIELDS.items():
        count = len(metadata.get_all(field, []))
        check(file, count >= least, f"{count} fields {field} in its metadata, not {least}")
    body = str(metadata.get_payload())
    links = re.findall(r"\]\(([^)]*)\)", body)
    relative = [link for link in links if not link.startswith("https://")]
    check(file, links and not relative, f"links that PyPI cannot follow: {relative or 'none found'}")


def check_wheel(file: Path, version: str) -> None:
    """Checks the content of a wheel."""
    check(file, file.stat().st_size <= MOST_BYTES, f"{file.stat().st_size} bytes, more than {MOST_BYTES}")
    check(file, "-cp310-abi3-" in file.name, "it is not for all versions from 3.10 on")
    with zipfile.ZipFile(file) as wheel:
        names = wheel.namelist()
        info = f"geosweep-{version}.dist-info"
        for name in NOTICES:
            check(file, f"{info}/licenses/{name}" in names, f"{name} is missing")
        check(file, any(name.startswith(f"{info}/sboms/") for name in names), "no bill of materials")
        check(file, "geosweep/py.typed" in names, "geosweep/py.typed is missing")
        libraries = [name for name in names if name.endswith((".so", ".pyd"))]
        check(file, len(libraries) == 1, f"its libraries are {libraries}")
        for name in libraries:
            content = wheel.read(name)
            symbols = sections(content) & {".symtab", ".debug_info"}
            check(file, not symbols, f"{name} is not stripped: {symbols}")
        check_metadata(file, wheel.read(f"{info}/METADATA"), version)


def check_source(file: Path, version: str) -> None:
    """Checks the content of a source distribution."""
    with tarfile.open(file) as archive:
        names = archive.getnames()
        for name in (*NOTICES, "Cargo.lock", "PKG-INFO"):
            check(file, any(one.endswith(f"/{name}") for one in names), f"{name} is missing")
        member = archive.extractfile(f"geosweep-{version}/PKG-INFO")
        check_metadata(file, member.read() if member else b"", version)


version, *files = sys.argv[1:]
for path in map(Path, files):
    (check_wheel if path.suffix == ".whl" else check_source)(path, version)
    print(f"{path.stat().st_size / 1e6:6.2f} MB  {path.name}")
for fault in faults:
    print(f"ci/check-wheels.py: {fault}", file=sys.stderr)
sys.exit(bool(faults) or not files)
