#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""make_maps.py: writes a.ot and b.ot, two parts of the real building of OctoMap's examples that overlap,
and T_a_b.txt, the pose of b in a's frame."""
import gzip
import math
from pathlib import Path

import mrpt_fusion as mf
import numpy as np

folder = Path("/usr/share/doc/liboctomap-dev/examples/data")
packed = folder / "geb079.bt.gz"
building = mf.Map.from_bytes(gzip.decompress(packed.read_bytes()) if packed.exists()
                             else (folder / "geb079.bt").read_bytes())
low, high = building.bounds
middle, half_overlap = (low[0] + high[0]) / 2, 0.15 * (high[0] - low[0])
centres, log_odds, sizes = building.voxels("all")


def part(inside, path):
    mf.Map.from_voxels(centres[inside], log_odds[inside], sizes[inside],
                       resolution=building.resolution).save(path)


part(centres[:, 0] < middle + half_overlap, "a.ot")
part(centres[:, 0] > middle - half_overlap, "b_in_a.ot")
turn = math.radians(40)
pose = np.array([[math.cos(turn), -math.sin(turn), 0, 3], [math.sin(turn), math.cos(turn), 0, -2],
                 [0, 0, 1, 0.2], [0, 0, 0, 1]])
np.savetxt("T_a_b.txt", pose, fmt="%.12f")
np.savetxt("T_b_a.txt", np.linalg.inv(pose), fmt="%.12f")
