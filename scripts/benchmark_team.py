#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_team.py [--building NAME] [--robots N] [--seeds A:B] [--build DIR]: fuses the maps of simulated teams.

N robots drive on the ring of corridors of the simulated office, or through the hall of the lobby. Each robot
drives its share of the way and some metres more, with its own errors and its own frame. The maps are fused
without a guess. Prints for each seed the number of placed robots, of placed robots whose pose is wrong
(0.3 m or 1.5 deg), and the CPU time.
"""
import argparse
import json
import math
import random
import re
import resource
import subprocess
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
WAYS = {"office": [(17.0, 6.65), (34.5, 6.65), (34.5, 33.35), (17.0, 33.35), (17.0, 6.65)],  # m
        "lobby": [(5, 7.6), (12.4, 7.6), (16, 7.8), (23.7, 7.8), (31.3, 7.8), (35, 7.6)]}
ASIDE = {"office": 0.3, "lobby": 0.0}  # robots drive at most so far beside the way, m
MAX_ERROR_M, MAX_ERROR_DEG = 0.3, 1.5


def piece_of(way, begin, end):
    """The points of a way between two distances along it. A way that ends where it begins goes round."""
    turns = 3 if way[0] == way[-1] else 1
    points, s = [], 0.0
    for a, b in list(zip(way, way[1:])) * turns:
        length = math.dist(a, b)
        for at in (begin, end) if not points else (end,):
            if s <= at < s + length:
                points.append(tuple(a[k] + (at - s) / length * (b[k] - a[k]) for k in (0, 1)))
        s += length
        if begin < s < end:
            points.append(b)
    return points


def write_mission(seed, building, robots, delay, path):
    draw, way = random.Random(seed), WAYS[building]
    is_ring, length = way[0] == way[-1], sum(math.dist(a, b) for a, b in zip(way, way[1:]))
    common = (PROJECT / f"tests/simulator/{building}.ini").read_text(encoding="utf-8").split("[robot_a]")[0]
    text = [re.sub(r"(?m)^seed = .*", f"seed = {100 * seed}", common)]
    start = draw.uniform(0, length) if is_ring else 0
    for i in range(robots):
        begin = start + i * length / robots + draw.uniform(-1, 1)
        end = begin + length / robots + draw.uniform(4.5, 6.5)
        if is_ring and begin < 0:
            begin, end = begin + length, end + length
        points = piece_of(way, begin, end) if is_ring else piece_of(way, max(0, begin), min(end, length - 0.01))
        if draw.random() < 0.5:
            points.reverse()
        dx, dy = (draw.uniform(-ASIDE[building], ASIDE[building]) for _ in range(2))
        points = [(x + dx, y + dy) for x, y in points]
        text.append(f"""
[robot_{i}]
waypoints = {'; '.join(f'{x:.2f} {y:.2f}' for x, y in points)}
floor_z = 0.0
scan_spacing = 0.5
speed = 0.5
start_time = {200 * i + delay}
radius = 0.2
ground_clearance = 0.2
sensor_pose = 0.10 0.00 1.00 0 2 0
map_frame = {points[0][0]:.3f} {points[0][1]:.3f} 0.02 {draw.uniform(-180, 180):.1f} 0 0
""")
    path.write_text("\n".join(text), encoding="utf-8")


def product(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def inverse(t):
    r = [[t[c][r] for c in range(3)] for r in range(3)]
    p = [-sum(r[i][k] * t[k][3] for k in range(3)) for i in range(3)]
    return [[*r[i], p[i]] for i in range(3)] + [[0, 0, 0, 1]]


def is_wrong(pose, truth):
    d = product(inverse(truth), pose)
    angle = math.acos(max(-1, min(1, (d[0][0] + d[1][1] + d[2][2] - 1) / 2)))
    return math.hypot(d[0][3], d[1][3], d[2][3]) > MAX_ERROR_M or math.degrees(angle) > MAX_ERROR_DEG


def fuse(seed, building, robots, build, folder):
    """Number of placed robots, number of wrong robots, CPU seconds."""
    for delay in range(0, 1000, 37):  # people may stand in the way
        write_mission(seed, building, robots, delay, folder / "mission.ini")
        simulated = subprocess.run(
            [build / "bin/simulate-robots", folder / "mission.ini", "--world", building, "--out", folder],
            check=False, capture_output=True, text=True)
        if simulated.returncode == 0:
            break
    else:
        raise SystemExit(simulated.stderr)
    maps = []
    for i in range(robots):
        maps.append(folder / f"robot_{i}.ot")
        subprocess.run([build / "bin/map-fusion", "build", "-q", folder / f"robot_{i}.rawlog", "-o", maps[-1]],
                       check=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([build / "bin/map-fusion", "fuse", "-q", *maps, "-o", folder / "fused.ot", "--json",
                    folder / "fused.json"], check=False, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = json.loads((folder / "fused.json").read_text(encoding="utf-8"))
    truth = [[[float(v) for v in line.split()] for line in
              (folder / f"T_robot_{i}_w.txt").read_text(encoding="utf-8").split("\n") if line]
             for i in range(robots)]
    placed = [i for i, robot in enumerate(report["robots"]) if robot["joined"]]
    wrong = [i for i in placed if i > 0 and is_wrong(report["robots"][i]["pose"]["matrix"],
                                                    product(truth[0], inverse(truth[i])))]
    return len(placed), len(wrong), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--building", choices=sorted(WAYS), default="office")
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--seeds", default="1:11", help="first and end (default: %(default)s)")
    parser.add_argument("--build", type=Path, default=PROJECT / "build")
    arguments = parser.parse_args()
    first, end = (int(s) for s in arguments.seeds.split(":"))
    total = [0, 0]
    for seed in range(first, end):
        with tempfile.TemporaryDirectory() as folder:
            placed, wrong, seconds = fuse(seed, arguments.building, arguments.robots, arguments.build, Path(folder))
        total = [total[0] + placed, total[1] + wrong]
        print(f"seed {seed:3}: {placed} of {arguments.robots} placed, {wrong} wrong, {seconds:.1f} s CPU", flush=True)
    print(f"all: {total[0]} of {arguments.robots * (end - first)} placed, {total[1]} wrong")


if __name__ == "__main__":
    main()
