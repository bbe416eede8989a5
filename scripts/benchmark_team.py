#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_team.py [--mixed] [--building NAME] [--robots N] [--seeds A:B] ...: fuses the maps of simulated teams.

N robots drive on the ring of corridors of the simulated office, through the hall of the lobby, along the corridor of
a real building, or in the corridors of a large storey: in as many of them as give each robot 12 m. Each robot drives
its share of the way and some metres more, with its own errors and its own frame. Strangers are robots of another building. The maps are fused without a guess, by team-benchmark
(cmake -DMRPT_FUSION_BUILD_BENCHMARKS=ON), and by two baselines on the same matches: growth of the first map by the
most probable accepted match, and the spanning tree of the most probable matches. --false-edges adds matches that
claim to be sure and are wrong: half of them are shifts by a bay that agree with each other.

Prints for each mission and method the placed robots, the wrong ones (0.3 m or 1.5 deg, or a stranger), those that are
left out, the mean NEES of the right ones (6 degrees of freedom), and the CPU time. --table keeps one line for each
robot.
"""
import argparse
import csv
import itertools
import math
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
WAYS = {"office": [(17.0, 6.65), (34.5, 6.65), (34.5, 33.35), (17.0, 33.35), (17.0, 6.65)],  # m
        "lobby": [(5, 7.6), (12.4, 7.6), (16, 7.8), (23.7, 7.8), (31.3, 7.8), (35, 7.6)],
        "corridor": [(-5.5, -0.4), (0.5, 0.6), (0.6, 0.3), (2.4, -0.4), (3.4, 0), (4.2, -0.4), (10, -0.4),
                     (11.4, -0.1), (12.5, -0.4), (15.2, -0.4), (15.62, -0.9), (17, 0.6), (21.13, -0.6), (24, 0.6),
                     (26.5, 0.5)]}
STOREY_X = (17.0, 34.5, 50.2, 69.0, 85.6, 104.1)  # middle lines of the corridors along y, m
STOREY_Y = (6.65, 20.0, 34.1, 47.2, 61.05, 74.3, 87.6)  # and of those along x, m
STOREY_END = 5.0  # the corridors are driven so far beyond the outer crossings, m
STOREY_SHARE = 12.0  # least way of a robot in the storey, m
BUILDINGS = sorted([*WAYS, "storey"])
ASIDE = {"office": 0.3, "storey": 0.3, "lobby": 0.0, "corridor": 0.0}  # robots drive at most so far beside the way, m
SETTINGS = {"office": "office", "storey": "office", "lobby": "lobby", "corridor": "geb079"}  # of the simulator
ANOTHER = {"office": "lobby", "storey": "lobby", "lobby": "office", "corridor": "office"}  # building of the strangers
STRANGERS_SHARE = 8  # a stranger drives so many-th of the way of its building
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


def length_of(way):
    return sum(math.dist(a, b) for a, b in zip(way, way[1:]))


def storey_ways(robots):
    """The corridors of the storey that give each robot its share of the way: the first of either direction."""
    for n in range(2, len(STOREY_X) + len(STOREY_Y) + 1):
        xs, ys = STOREY_X[:n // 2], STOREY_Y[:n - n // 2]
        along_x = [[(xs[0] - STOREY_END, y), (xs[-1] + STOREY_END, y)] for y in ys]
        along_y = [[(x, ys[0] - STOREY_END), (x, ys[-1] + STOREY_END)] for x in xs]
        if sum(length_of(way) for way in along_x + along_y) >= robots * STOREY_SHARE:
            break
    return along_x + along_y


def ways_of(building, robots):
    """The ways of a building, each with its number of robots."""
    if building != "storey":
        return [(WAYS[building], robots)]
    ways = storey_ways(robots)
    whole, done, shares = sum(length_of(way) for way in ways), 0.0, []
    for way in ways:  # as many as round off to the share of the way so far
        before, done = round(robots * done / whole), done + length_of(way)
        shares.append((way, round(robots * done / whole) - before))
    return [(way, share) for way, share in shares if share > 0]


def drives_on(way, robots, draw):
    """Yields the points of the drive of each robot on a way."""
    is_ring, length = way[0] == way[-1], length_of(way)
    start = draw.uniform(0, length) if is_ring else 0
    for i in range(robots):
        begin = start + i * length / robots + draw.uniform(-1, 1)
        end = begin + length / robots + draw.uniform(4.5, 6.5)
        if is_ring and begin < 0:
            begin, end = begin + length, end + length
        yield piece_of(way, begin, end) if is_ring else piece_of(way, max(0, begin), min(end, length - 0.01))


def write_mission(path, seed, building, robots, delay, drift=1.0, count=None):
    """Writes a mission of the simulator. count: only so many robots of the mission drive."""
    draw = random.Random(seed)
    common = (PROJECT / f"tests/simulator/{SETTINGS[building]}.ini").read_text(encoding="utf-8").split("[robot_a]")[0]
    common = re.sub(r"(?m)^(drift_\w+ = )(.*)", lambda m: f"{m[1]}{drift * float(m[2]):g}", common)
    text = [re.sub(r"(?m)^seed = .*", f"seed = {100 * seed}", common)]
    drives = (points for way, share in ways_of(building, robots) for points in drives_on(way, share, draw))
    for i, points in enumerate(itertools.islice(drives, count)):
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


def world_of(building, build):
    if building != "corridor":
        return building
    return subprocess.run([PROJECT / "scripts/find_geb079.sh", build], check=True, capture_output=True,
                          text=True).stdout.strip()


def simulate(mission, building, build, folder):
    """Makes robot_I.ot and T_robot_I_w.txt in a folder. \a mission: keywords of write_mission() but the delay."""
    world = world_of(building, build)
    for delay in range(0, 1000, 37):  # people may stand in the way
        write_mission(folder / "mission.ini", building=building, delay=delay, **mission)
        simulated = subprocess.run([build / "bin/simulate-robots", folder / "mission.ini", "--world", world, "--out",
                                    folder], check=False, capture_output=True, text=True)
        if simulated.returncode == 0:
            break
    else:
        raise SystemExit(simulated.stderr)
    for rawlog in sorted(folder.glob("robot_*.rawlog")):
        subprocess.run([build / "bin/map-fusion", "build", "-q", rawlog, "-o", rawlog.with_suffix(".ot")], check=True)
        rawlog.unlink()
    (folder / "all.rawlog").unlink()


def mixed(seed, options):
    """Options of a mission that is drawn by its seed."""
    draw, mission = random.Random(7 * seed + 1), argparse.Namespace(**vars(options))
    mission.building = draw.choice(["office", "office", "lobby", "corridor"])
    mission.robots = draw.randint(6, 10) if mission.building == "office" else draw.randint(4, 6)
    mission.strangers = draw.choice([0, 0, 1, 2])
    mission.drift = draw.choice([1, 1, 1, 3])
    return mission


def make_maps(seed, options, folder):
    """Makes the maps of a mission: robots with the pose of the world in their frames, strangers without."""
    simulate({"seed": seed, "robots": options.robots, "drift": options.drift}, options.building, options.build, folder)
    if options.strangers == 0:
        return
    with tempfile.TemporaryDirectory() as other:
        simulate({"seed": seed, "robots": STRANGERS_SHARE, "drift": options.drift, "count": options.strangers},
                 ANOTHER[options.building], options.build, Path(other))
        for i in range(options.strangers):
            shutil.move(Path(other) / f"robot_{i}.ot", folder / f"stranger_{i}.ot")


def number(text):
    return float(text) if text else None


def summary(rows):
    """Text on the maps of one mission, or of many, by one method."""
    robots = [r for r in rows if r["is_stranger"] == "0"]
    placed = [r for r in rows if r["placed"] == "1"]
    wrong = [r for r in placed if not (number(r["error_m"]) <= MAX_ERROR_M and number(r["error_deg"]) <= MAX_ERROR_DEG)]
    nees = [number(r["nees"]) for r in placed if r["nees"] and r not in wrong]
    text = (f"{sum(r['is_stranger'] == '0' for r in placed)} of {len(robots)} placed, {len(wrong)} wrong, "
            f"{len(robots) - sum(r['is_stranger'] == '0' for r in placed)} left out")
    if len(robots) < len(rows):
        text += f", {sum(r['is_stranger'] == '1' for r in placed)} of {len(rows) - len(robots)} strangers placed"
    return text + (f", NEES {sum(nees) / len(nees):.1f}" if nees else "")


def groups_of(rows):
    """Lines by kind of matches and method, in the order of the table."""
    groups = {}
    for row in rows:
        groups.setdefault((row["edges"], row["method"]), []).append(row)
    return groups


def print_groups(title, rows):
    print(title)
    for (edges, method), group in groups_of(rows).items():
        name = method + (" with false matches" if edges == "false" else "")
        cpu = {r["mission"]: float(r["cpu_s"]) for r in group if r["cpu_s"]}  # without the maps' simulation
        print(f"  {name:26} {summary(group)}" + (f", {sum(cpu.values()) / len(cpu):.1f} s CPU" if cpu else ""))
    sys.stdout.flush()


def fuse(folder, seed, options):
    """Lines of the table of a mission."""
    run = subprocess.run([options.build / "bin/team-benchmark", folder, "--false-edges", str(options.false_edges),
                          "--seed", str(seed), "--threads", str(options.threads)], check=True, capture_output=True,
                         text=True)
    return list(csv.DictReader(run.stdout.splitlines()))


def missions_of(options):
    """Lines of the table of each mission: new missions, or those of kept folders."""
    first, end = (int(s) for s in options.seeds.split(":"))
    for seed in range(first, end):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / str(seed) if options.keep is None else options.keep / str(seed)
            if not (folder / "mission.ini").exists():
                folder.mkdir(parents=True)
                make_maps(seed, mixed(seed, options) if options.mixed else options, folder)
            yield seed, fuse(folder, seed, options)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mixed", action="store_true",
                        help="the seed draws building, number of robots (4 to 10), strangers (0 to 2) and drift (1, 3)")
    parser.add_argument("--building", choices=BUILDINGS, default="office")
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--strangers", type=int, default=0, help="robots of another building, at most 8")
    parser.add_argument("--drift", type=float, default=1, help="factor of the drift (default: %(default)s)")
    parser.add_argument("--false-edges", type=float, default=0, help="number of false matches over the number of pairs")
    parser.add_argument("--seeds", default="1:11", help="first and end (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder of the maps: kept, and used if they are there")
    parser.add_argument("--table", type=Path, help="CSV file with a line for each map")
    parser.add_argument("--build", type=Path, default=PROJECT / "build")
    options = parser.parse_args()
    table = []
    for seed, rows in missions_of(options):
        table += rows
        print_groups(f"seed {seed}:", rows)
    print_groups(f"all missions of seeds {options.seeds}:", table)
    if options.table and table:
        with open(options.table, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, fieldnames=list(table[0]))
            writer.writeheader()
            writer.writerows(table)


if __name__ == "__main__":
    main()
