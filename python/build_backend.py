# SPDX-License-Identifier: BSD-3-Clause
"""Builds wheels of mrpt_fusion by CMake: a backend as PEP 517 describes it, without dependencies.

Other backends that run CMake are not in Debian 12, and pip would need a network to fetch one.
"""
import base64
import hashlib
import io
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROJECT = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
VERSION = re.search(r"project\(mrpt-fusion VERSION (\S+)", PROJECT).group(1)
SUMMARY = re.search(r'DESCRIPTION "([^"]+)"', PROJECT).group(1)
TAG = "cp{0}{1}-cp{0}{1}-{2}".format(*sys.version_info[:2],
                                     re.sub(r"[-.]", "_", sysconfig.get_platform()))
INFO = f"mrpt_fusion-{VERSION}.dist-info"
METADATA = f"""Metadata-Version: 2.1
Name: mrpt-fusion
Version: {VERSION}
Summary: {SUMMARY}
License: BSD-3-Clause
Requires-Python: >=3.9
Requires-Dist: numpy
Description-Content-Type: text/markdown

{(ROOT / "README.md").read_text(encoding="utf-8")}"""
# The time of all files, so that two builds are equal.
EPOCH = (1980, 1, 1, 0, 0, 0)


def install(prefix, build):
    """Builds the module in the folder build, and installs the package below prefix."""

    def cmake(*arguments):
        subprocess.run(["cmake", *map(str, arguments)], check=True)

    cmake("-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DMRPT_FUSION_PYTHON_WHEEL=ON",
          "-DMRPT_FUSION_BUILD_APPS=OFF", "-DMRPT_FUSION_BUILD_TESTS=OFF",
          f"-DPython3_EXECUTABLE={sys.executable}")
    cmake("--build", build, "--target", "mrpt_fusion_python", "-j", os.cpu_count() or 1)
    cmake("--install", build, "--component", "python", "--prefix", prefix, "--strip")


def information():
    """The files of the wheel's .dist-info folder, without RECORD, by their names in the wheel."""
    return {
        f"{INFO}/METADATA": METADATA.encode(),
        f"{INFO}/WHEEL": (f"Wheel-Version: 1.0\nGenerator: mrpt-fusion {VERSION}\n"
                          f"Root-Is-Purelib: false\nTag: {TAG}\n").encode(),
        f"{INFO}/LICENSE": (ROOT / "LICENSE").read_bytes(),
    }


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    for name, data in information().items():
        path = Path(metadata_directory) / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)
    return INFO


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Setting build-dir: folder of the build. The default is a folder of its own below build/."""
    build = ROOT / (config_settings or {}).get("build-dir", f"build/wheel-{TAG}")
    files = {}
    with tempfile.TemporaryDirectory() as prefix:
        install(prefix, build)
        for file in sorted(Path(prefix).rglob("*")):
            if file.is_file():
                files[file.relative_to(prefix).as_posix()] = file.read_bytes()
    files.update(information())
    record = f"{INFO}/RECORD"
    files[record] = "".join(
        f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip('=')}"
        f",{len(data)}\n" for name, data in files.items()).encode() + f"{record},,\n".encode()

    name = f"mrpt_fusion-{VERSION}-{TAG}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, EPOCH)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    base = f"mrpt_fusion-{VERSION}"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True)
    with tarfile.open(Path(sdist_directory) / f"{base}.tar.gz", "w:gz") as archive:
        for name in listed.stdout.decode().split("\0")[:-1]:
            archive.add(ROOT / name, f"{base}/{name}")
        entry = tarfile.TarInfo(f"{base}/PKG-INFO")
        entry.size = len(METADATA.encode())
        archive.addfile(entry, io.BytesIO(METADATA.encode()))
    return f"{base}.tar.gz"
