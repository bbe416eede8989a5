# SPDX-License-Identifier: BSD-3-Clause
"""What the tests share: the maps of two robots, and the command line."""
import os
import shutil
import subprocess
from pathlib import Path

import mrpt_fusion as mf
import numpy as np
import pytest

PAIR = Path(os.environ["PAIR_DIR"])


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Each test runs in a new folder with a.ot and b.ot."""
    for name in "ab":
        shutil.copy(PAIR / f"map_{name}.ot", tmp_path / f"{name}.ot")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def truth():
    """The true pose of map B in A's frame."""
    return np.loadtxt(PAIR / "T_a_b.txt")


@pytest.fixture
def map_fusion():
    """Runs map-fusion, and returns its exit code."""
    return lambda *arguments: subprocess.run(
        [os.environ["MAP_FUSION"], *map(str, arguments)], check=False, capture_output=True).returncode


def part_of(source, low, high):
    """The part of a map between two corners, m."""
    centres, log_odds, sizes = source.voxels("all")
    inside = ((centres > low) & (centres < high)).all(axis=1)
    return mf.Map.from_voxels(centres[inside], log_odds[inside], sizes[inside],
                              resolution=source.resolution)


@pytest.fixture(name="part_of")
def part_of_fixture():
    return part_of
