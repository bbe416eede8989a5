#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_team.py [--robots N] [--seeds A:B] [--build DIR]: fuses the maps of simulated teams.

N robots drive on the ring of corridors of the simulated office, each over its share of the ring and some
metres more, with its own errors and its own frame. Their maps are fused without a guess. Prints for each
seed the robots that were placed, the placed robots whose pose is wrong (0.3 m or 1.5 deg), and the CPU time.
"""
import argparse
import json
import math
import random
import resource
import subprocess
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
LOW, HIGH = (17.0, 6.65), (34.5, 33.35)  # corners of the ring of corridors, m
CORNERS = [LOW, (HIGH[0], LOW[1]), HIGH, (LOW[0], HIGH[1])]
SIDES = [HIGH[0] - LOW[0], HIGH[1] - LOW[1]] * 2
MAX_ERROR_M, MAX_ERROR_DEG = 0.3, 1.5


def on_ring(s):
    """The point at a distance along the ring."""
    s %= sum(SIDES)
    for k, side in enumerate(SIDES):
        if s <= side:
            (x0, y0), (x1, y1) = CORNERS[k], CORNERS[(k + 1) % 4]
            return x0 + s / side * (x1 - x0), y0 + s / side * (y1 - y0)
        s -= side
    return CORNERS[0]


def write_mission(seed, robots, path):
    draw, ring = random.Random(seed), sum(SIDES)
    common = (PROJECT / "tests/simulator/office.ini").read_text(encoding="utf-8")
    text = [common.split("# The middle corridor from the west")[0].replace("seed = 21", f"seed = {100 * seed}")]
    start = draw.uniform(0, ring)
    for i in range(robots):
        begin = start + i * ring / robots + draw.uniform(-1, 1)
        end = begin + ring / robots + draw.uniform(4.5, 6.5)
        corners = [turn * ring + sum(SIDES[:k]) for turn in range(3) for k in range(4)]
        points = [on_ring(s) for s in [begin, *(c for c in corners if begin < c < end), end]]
        if draw.random() < 0.5:
            points.reverse()
        dx, dy = draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3)
        points = [(x + dx, y + dy) for x, y in points]
        text.append(f"""
[robot_{i}]
waypoints = {'; '.join(f'{x:.2f} {y:.2f}' for x, y in points)}
floor_z = 0.0
scan_spacing = 0.5
speed = 0.5
start_time = {200 * i}
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


def fuse(seed, robots, build, folder):
    """Number of placed robots, number of wrong robots, CPU seconds."""
    write_mission(seed, robots, folder / "mission.ini")
    subprocess.run([build / "bin/simulate-robots", folder / "mission.ini", "--world", "office", "--out", folder],
                   check=True, stdout=subprocess.DEVNULL)
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
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--seeds", default="1:11", help="first and end (default: %(default)s)")
    parser.add_argument("--build", type=Path, default=PROJECT / "build")
    arguments = parser.parse_args()
    first, end = (int(s) for s in arguments.seeds.split(":"))
    total = [0, 0]
    for seed in range(first, end):
        with tempfile.TemporaryDirectory() as folder:
            placed, wrong, seconds = fuse(seed, arguments.robots, arguments.build, Path(folder))
        total = [total[0] + placed, total[1] + wrong]
        print(f"seed {seed:3}: {placed} of {arguments.robots} placed, {wrong} wrong, {seconds:.1f} s CPU", flush=True)
    print(f"all: {total[0]} of {arguments.robots * (end - first)} placed, {total[1]} wrong")


if __name__ == "__main__":
    main()
