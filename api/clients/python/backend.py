"""Builds the wheel and the source archive of this folder with the standard library alone, by PEP 517 and 660, so that
`pip install` needs no build tool and no network.

Leaves to others: what is in the package (pendulumd/). Invariant: the same files make the same bytes. With LIBRARY=path the wheel has the engine
(libpendulum.so) in it, and is of this processor; without one it is of any.
"""
import base64
import hashlib
import io
import os
import pathlib
import re
import sysconfig
import tarfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
TEXT = (HERE / "pyproject.toml").read_text(encoding="utf-8")


def field(name):
    return re.search(rf'^{name} = "(.*)"', TEXT, re.M)[1]


def listed(name):
    return re.findall(r'"([^"]+)"', re.search(rf"^{name} = \[(.*?)\]", TEXT, re.M | re.S)[1])


NAME, VERSION = field("name"), field("version")
INFO = f"{NAME}-{VERSION}.dist-info"


def metadata():
    lines = ["Metadata-Version: 2.1", f"Name: {NAME}", f"Version: {VERSION}", f"Summary: {field('description')}", "License: GPL-3.0-or-later",
             f"Requires-Python: {field('requires-python')}", "Description-Content-Type: text/markdown"]
    lines += [f"Requires-Dist: {package}" for package in listed("dependencies")]
    for extra in ("tables", "plots"):
        lines += [f"Provides-Extra: {extra}"] + [f'Requires-Dist: {package}; extra == "{extra}"' for package in listed(extra)]
    return "\n".join(lines) + "\n\n" + (HERE / "README.md").read_text(encoding="utf-8")


def write_wheel(directory, files):
    """Writes a wheel of files (name in the wheel, bytes); returns its name."""
    library = os.environ.get("LIBRARY")
    tag = "py3-none-" + (re.sub(r"[-.]", "_", sysconfig.get_platform()) if library else "any")
    if library:
        files.append(("pendulumd/libpendulum.so.0", pathlib.Path(library).read_bytes()))
    files += [(f"{INFO}/METADATA", metadata().encode()),
              (f"{INFO}/WHEEL", f"Wheel-Version: 1.0\nGenerator: pendulumd\nRoot-Is-Purelib: {'false' if library else 'true'}\nTag: {tag}\n".encode())]
    record = "".join(f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n" for name, data in files)
    files.append((f"{INFO}/RECORD", (record + f"{INFO}/RECORD,,\n").encode()))
    path = pathlib.Path(directory) / f"{NAME}-{VERSION}-{tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in files:
            entry = zipfile.ZipInfo(name)
            entry.external_attr = 0o644 << 16
            wheel.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return path.name


def build_wheel(directory, config_settings=None, metadata_directory=None):
    return write_wheel(directory, [(f"pendulumd/{path.name}", path.read_bytes()) for path in sorted((HERE / "pendulumd").iterdir()) if path.suffix in (".py", ".js", ".typed")])


def build_editable(directory, config_settings=None, metadata_directory=None):
    return write_wheel(directory, [(f"_{NAME}.pth", f"{HERE}\n".encode())])


def build_sdist(directory, config_settings=None):
    base = f"{NAME}-{VERSION}"
    with tarfile.open(pathlib.Path(directory) / f"{base}.tar.gz", "w:gz") as archive:
        def add(name, data):
            entry = tarfile.TarInfo(f"{base}/{name}")
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
        add("PKG-INFO", metadata().encode())
        for path in sorted([*HERE.glob("*.py"), *HERE.glob("*.toml"), *HERE.glob("*.md"), *(HERE / "pendulumd").glob("*.[pj]*"), HERE / "pendulumd/py.typed"]):
            add(path.relative_to(HERE).as_posix(), path.read_bytes())
    return f"{base}.tar.gz"


if __name__ == "__main__":
    import sys
    print(build_wheel(sys.argv[1]))
