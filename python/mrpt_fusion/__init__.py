# SPDX-License-Identifier: BSD-3-Clause
"""Fuses 3-D occupancy maps of several robots.

>>> import mrpt_fusion as mf
>>> r = mf.fuse(['a.ot', 'b.ot'])
>>> r.accepted
True
>>> r.pose.shape
(4, 4)
>>> r.save_page('why.html')

Lengths are in m. Angles are in deg where a name or a docstring says so. Poses are 4x4 arrays: the
pose of map B in the frame of map A is the T with p_a = T @ p_b.
"""
from ._core import (Cubes, Edges, Error, Fusion, Hypothesis, Map, MapBuilder, MapTeam, Match, Member,
                    Pair, __version__, default_options, edges, evaluate, fuse, load, load_mission, match,
                    merge)

__all__ = ["Cubes", "Edges", "Error", "Fusion", "Hypothesis", "Map", "MapBuilder", "MapTeam", "Match",
           "Member", "Pair", "default_options", "edges", "evaluate", "fuse", "load", "load_mission",
           "match", "merge"]

for _name in __all__:
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = __name__
del _name
