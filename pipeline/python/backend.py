# SPDX-License-Identifier: Apache-2.0
"""Builds the wheel (PEP 517) by CMake and Python's standard library alone, so that `pip install .` downloads no tool: the
library and its modules lie in the package, and one wheel serves every Python 3."""

import base64
import hashlib
import io
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
TREE = HERE.parent.parent
BUILD = TREE / "build-python"
HEADERS = [f"{folder}/include/fewray/{name}.h" for folder, name in (
    ("features", "features"), ("denoise", "denoise"), ("guide", "guide"), ("guide", "guiding"), ("pipeline", "pipeline"))]
VERSION = re.search(r"project\(fewray VERSION ([\d.]+)", (TREE / "CMakeLists.txt").read_text())[1]
NAME = f"fewray-{VERSION}"
METADATA = f"""Metadata-Version: 2.1
Name: fewray
Version: {VERSION}
Summary: Denoiser, guided path tracer and metrics for pictures of a few paths a pixel
License: Apache-2.0
Requires-Python: >=3.9
Requires-Dist: numpy>=1.21
Description-Content-Type: text/markdown

"""


def files():
    """Where each file of the package comes from: archive name -> path or bytes."""
    stage = BUILD / "stage"
    cmake = ["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DFEWRAY_TESTS=OFF",
             "-DCMAKE_INSTALL_LIBDIR=lib"]
    for command in (cmake, ["cmake", "--build", BUILD], ["cmake", "--install", BUILD, "--prefix", stage, "--strip"]):
        subprocess.run(list(map(str, command)), check=True, stdout=sys.stderr)
    found = {f"fewray/{p.name}": p for p in sorted((HERE / "fewray").glob("*.py"))}
    found["fewray/py.typed"] = b""
    found["fewray/_structs.py"] = subprocess.run(
        [sys.executable, HERE / "structs.py"] + [TREE / h for h in HEADERS], check=True, stdout=subprocess.PIPE).stdout
    found["fewray/lib/libfewray.so"] = (stage / "lib/libfewray.so").resolve()
    for module in sorted((stage / "lib/fewray").glob("*.so")):
        found[f"fewray/lib/fewray/{module.name}"] = module
    return found


def platform_tag():
    return re.sub(r"[-.]", "_", sysconfig.get_platform())


def metadata():
    return METADATA.encode() + (TREE / "README.md").read_bytes()


def metadata_files(tag):
    return {"METADATA": metadata(),
            "WHEEL": f"Wheel-Version: 1.0\nGenerator: fewray\nRoot-Is-Purelib: false\nTag: {tag}\n".encode(),
            "LICENSE": (TREE / "LICENSE").read_bytes()}


def add(archive, record, name, content):
    data = content if isinstance(content, bytes) else content.read_bytes()
    archive.writestr(name, data)
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    record.append(f"{name},sha256={digest},{len(data)}")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    tag, record = f"py3-none-{platform_tag()}", []
    name = f"{NAME}-{tag}.whl"
    content = files()
    temporary = Path(wheel_directory) / (name + ".part")
    with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, source in content.items():
            add(archive, record, path, source)
        for path, data in metadata_files(tag).items():
            add(archive, record, f"{NAME}.dist-info/{path}", data)
        record.append(f"{NAME}.dist-info/RECORD,,")
        archive.writestr(f"{NAME}.dist-info/RECORD", "\n".join(record) + "\n")
    os.replace(temporary, Path(wheel_directory) / name)
    return name


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = Path(metadata_directory) / f"{NAME}.dist-info"
    folder.mkdir()
    for path, data in metadata_files(f"py3-none-{platform_tag()}").items():
        (folder / path).write_bytes(data)
    return folder.name


def build_sdist(sdist_directory, config_settings=None):
    name = f"{NAME}.tar.gz"
    tracked = subprocess.run(["git", "-C", str(TREE), "ls-files", "-z"], check=True, stdout=subprocess.PIPE).stdout
    with tarfile.open(Path(sdist_directory) / name, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path in filter(None, tracked.decode().split("\0")):
            archive.add(TREE / path, f"{NAME}/{path}")
        entry = tarfile.TarInfo(f"{NAME}/PKG-INFO")
        entry.size = len(metadata())
        archive.addfile(entry, io.BytesIO(metadata()))
    return name
