#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""check_includes.py [DIR]: checks who may include whom, see doc/architecture.md.

Reads the #include lines of modules/, apps/ and python/ below DIR (default: this project). Prints each
include that the rules forbid as "<file>:<line>: <room> must not include <room>", and exits with 1 if
there is any.
"""
import re
import sys
from pathlib import Path

BASE, OCTREE, MAP, FEATURES = "base", "octree", "map", "features"
SEARCH, REGISTRATION, VERDICT, MERGE, PAIR = "search", "registration", "verdict", "merge", "pair"
TEAM, LINK, REPORT, MAPS, FUSION, APPS, PYTHON = "team", "link", "report", "maps", "fusion", "apps", "python"

# What each room may include, beside itself.
ALLOWED = {
    BASE: set(),
    OCTREE: {BASE},
    MAP: {BASE, OCTREE},
    FEATURES: {BASE, OCTREE, MAP},
    SEARCH: {BASE, OCTREE, MAP, FEATURES},
    REGISTRATION: {BASE, OCTREE, MAP, FEATURES},
    VERDICT: {BASE, OCTREE, MAP, FEATURES, REGISTRATION},
    MERGE: {BASE, OCTREE, MAP},
}
ALLOWED[PAIR] = set(ALLOWED) | set()
ALLOWED[TEAM] = ALLOWED[PAIR] | {PAIR}
ALLOWED[LINK] = ALLOWED[TEAM] | {TEAM}
ALLOWED[REPORT] = ALLOWED[TEAM] | {TEAM}
ALLOWED[MAPS] = {BASE, OCTREE, MAP, FEATURES, LINK}
ALLOWED[FUSION] = ALLOWED[TEAM] | {TEAM, MAPS, LINK}
ALLOWED[APPS] = ALLOWED[FUSION] | {FUSION, REPORT}
ALLOWED[PYTHON] = ALLOWED[FUSION] | {FUSION, REPORT}

# Python binds public headers. It shows pages and errors as the command line does.
PRIVATE_OF_PYTHON = {BASE, REPORT}

# Rooms of the public headers, by the room whose sources define what they declare.
PUBLIC = {
    "mrpt/fusion/export.h": BASE,
    "mrpt/fusion/sources.h": OCTREE,
    "mrpt/fusion/voxels.h": MAP,
    "mrpt/fusion/edges.h": FEATURES,
    "mrpt/fusion/prepared_map.h": FEATURES,
    "mrpt/fusion/search_params.h": SEARCH,
    "mrpt/fusion/registration_params.h": REGISTRATION,
    "mrpt/fusion/match_result.h": REGISTRATION,
    "mrpt/fusion/evaluation.h": VERDICT,
    "mrpt/fusion/merging.h": MERGE,
    "mrpt/fusion/poses.h": PAIR,
    "mrpt/fusion/options.h": PAIR,
    "mrpt/fusion/alignment.h": PAIR,
    "mrpt/fusion/many_maps.h": TEAM,
    "mrpt/fusion/compat.h": MAPS,
    "mrpt/fusion/map_files.h": MAPS,
    "mrpt/maps/CProbOctoMap.h": MAPS,
    "mrpt/maps/CEdgeVoxelMap.h": MAPS,
    "mrpt/obs/CObservationLocalMap.h": MAPS,
    "mrpt/fusion/fusion.h": FUSION,
    "mrpt/fusion/fusion_scene.h": FUSION,
    "mrpt/fusion/map_fusion.h": FUSION,
    "mrpt/slam/CMapTeam.h": FUSION,
    "mrpt/slam/CProbabilisticMapMatching.h": FUSION,
}

FOLDERS = [
    ("modules/fusion_base/", BASE),
    ("modules/fusion_octree/", OCTREE),
    *((f"modules/fusion_core/{room}/", room)
      for room in (MAP, FEATURES, SEARCH, REGISTRATION, VERDICT, MERGE, PAIR)),
    ("modules/fusion_team/", TEAM),
    ("modules/fusion_link/", LINK),
    ("modules/fusion_report/", REPORT),
    ("modules/mrpt_fusion_maps/", MAPS),
    ("modules/mrpt_fusion/", FUSION),
    ("apps/", APPS),
    ("python/", PYTHON),
]

# Headers of other projects that only some rooms may use.
FOREIGN = [
    (re.compile(r"^mpi\.h"), set(), "MPI"),
    (re.compile(r"^dds/"), {LINK}, "DDS"),
    (re.compile(r"^nlohmann/"), {REPORT, APPS, PYTHON}, "JSON"),
    (re.compile(r"^CLI/"), {APPS}, "CLI11"),
    (re.compile(r"^mrpt/(maps|obs|slam|opengl|viz|img)/"), {MAPS, FUSION, APPS, PYTHON},
     "MRPT's map classes"),
    (re.compile(r"^mrpt/(config|poses|system|math|serialization)/"),
     {BASE, MAP, PAIR, TEAM, REPORT, MAPS, FUSION, APPS, PYTHON}, "MRPT"),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def room_of_file(path):
    if "/include/" in path:
        return PUBLIC.get(path.split("/include/", 1)[1])
    return next((room for folder, room in FOLDERS if path.startswith(folder)), None)


def room_of_include(name):
    if name in PUBLIC:
        return PUBLIC[name]
    return next((room for folder, room in FOLDERS
                 if folder.startswith("modules/") and name.startswith(folder[len("modules/"):])),
                None)


def check(root):
    faults = []
    files = sorted(p for folder in ("modules", "apps", "python") for p in (root / folder).rglob("*")
                   if p.suffix in (".h", ".cpp"))
    if not files:
        faults.append(f"{root}: has no sources")
    for file in files:
        path = file.relative_to(root).as_posix()
        room = room_of_file(path)
        if room is None:
            faults.append(f"{path}:1: is in no room that scripts/check_includes.py knows")
            continue
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            found = INCLUDE.match(line)
            if not found:
                continue
            name = found.group(2)
            included = room_of_include(name)
            if included is not None:
                if included != room and included not in ALLOWED[room]:
                    faults.append(f"{path}:{number}: {room} must not include {included} ({name})")
                if room == PYTHON and name not in PUBLIC and included not in PRIVATE_OF_PYTHON:
                    faults.append(f"{path}:{number}: python includes the private {name}")
                if "/include/" in path and name not in PUBLIC:
                    faults.append(f"{path}:{number}: a public header includes the private {name}")
                continue
            for pattern, rooms, what in FOREIGN:
                if pattern.match(name) and room not in rooms:
                    faults.append(f"{path}:{number}: {room} must not use {what} ({name})")
    return faults


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    faults = check(root)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
