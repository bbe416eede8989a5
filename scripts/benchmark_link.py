#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_link.py [DIR...] [--loss PERCENT]... [--rate RATE] [--mission] [--build DIR]: costs of map-fusion join.

Each DIR holds map_a.ot, map_b.ot and T_a_b.txt, as scripts/benchmark.sh makes them. Robot r1 has map_a.ot, r2 has
map_b.ot. Each is in a network namespace of its own, behind RATE (default 256kbit), and r2 loses PERCENT (default 0) of
the packets that it should receive. Needs root, ip, tc and nft.

Prints for each robot: the error (m, deg) and the probability of the pose at which it meets the other, with the bytes of
the outline; the bytes of the other map with which both maps were fused first; the time until both have both maps;
all bytes that it received, Ethernet's headers included, over the bytes of the other map's samples; then, while nothing
changes, bytes per second and CPU. Checks that both fused maps are that of map-fusion fuse.

--mission: four robots drive through the simulated office for 30 minutes, ten times round. Each writes its map every 20 s,
and joins the others. All of it runs at 20 times its speed (--speed). Prints for each robot: the largest memory after a
third of the mission and at its end; CPU; CPU apart from matches, in percent of a core at real speed and for each change
of the map. The robots run with --threads 1, so that all matches are in the threads that fuse, which live for one fusion.
Checks that all fused maps are that of map-fusion fuse in the end.
"""
import argparse
import math
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
NETWORK = PROJECT / "tests/link/network.sh"
STANDING = 20  # s
MEETS = re.compile(r"(r\d) (?:may meet|meets) this robot at \[([^\]]*)\] \((\d+) %, by (\d+) bytes\)")
BOTH = re.compile(r"fused r1(?: \((?P<r1>\d+) bytes of it\))? r2(?: \((?P<r2>\d+) bytes of it\))?")


def matrix_of(pose):
    """The 4x4 matrix of x y z yaw pitch roll (m, deg)."""
    x, y, z = pose[:3]
    (cy, sy), (cp, sp), (cr, sr) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in pose[3:])
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, y],
            [-sp, cp * sr, cp * cr, z]]


def inverse_of(m):
    return [[m[0][i], m[1][i], m[2][i], -sum(m[k][i] * m[k][3] for k in range(3))] for i in range(3)]


def error_of(m, truth):
    shift = math.dist([row[3] for row in m[:3]], [row[3] for row in truth[:3]])
    trace = sum(m[i][k] * truth[i][k] for i in range(3) for k in range(3))
    return shift, math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2))))


class Robot:
    def __init__(self, program, folder, prefix, number, *more):
        self.name, self.namespace, self.folder = f"r{number}", f"{prefix}{number}", folder
        self.log = folder / f"{self.name}.log"
        self.process = subprocess.Popen(
            ["ip", "netns", "exec", self.namespace, program, "join", "--robot", self.name, "--map",
             f"{self.name}.ot", "--domain", "7", "-o", f"fused_{self.name}.ot", *more],
            cwd=folder, stdout=open(self.log, "w"), stderr=subprocess.STDOUT)

    def received(self):
        return int(subprocess.run(["ip", "netns", "exec", self.namespace, "cat",
                                   "/sys/class/net/eth0/statistics/rx_bytes"],
                                  check=True, capture_output=True, text=True).stdout)

    def cpu(self, thread=None):
        """CPU of the process, or of one of its threads, s."""
        path = f"/proc/{self.process.pid}/" + (f"task/{thread}/stat" if thread else "stat")
        fields = Path(path).read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def threads(self):
        return set(os.listdir(f"/proc/{self.process.pid}/task"))

    def peak_memory(self):
        """MB"""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s*(\d+)", status)[1]) / 1024

    def lines(self):
        return self.log.read_text().splitlines()

    def fused(self):
        path = self.folder / f"fused_{self.name}.ot"
        return path.read_bytes() if path.exists() else b""


def samples_bytes(program, folder, name):
    """Bytes of the samples of a robot's map: those of its journal."""
    subprocess.run([program, "join", "-q", "--robot", name, "--map", f"{name}.ot", "--domain", "231", "--journal",
                    f"journal_{name}", "--for", "0.1"], cwd=folder, check=True)
    return (folder / f"journal_{name}" / "samples").stat().st_size


def run(program, pair, loss, rate):
    prefix = f"bl{os.getpid()}r"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for robot, file in (("r1", "map_a.ot"), ("r2", "map_b.ot")):
            shutil.copy(pair / file, folder / f"{robot}.ot")
        truth = [[float(v) for v in line.split()] for line in (pair / "T_a_b.txt").read_text().splitlines()[:3]]
        subprocess.run([program, "fuse", "-q", "r1.ot", "r2.ot", "-o", "expected.ot"], cwd=folder, check=True)
        expected = (folder / "expected.ot").read_bytes()
        sizes = {r: samples_bytes(program, folder, r) for r in ("r1", "r2")}
        subprocess.run([NETWORK, "up", prefix, "2", rate], check=True)
        try:
            subprocess.run([NETWORK, "loss", prefix, "2", str(loss)], check=True)
            begin = time.monotonic()
            robots = [Robot(program, folder, prefix, i) for i in (1, 2)]
            while not all(r.fused() == expected for r in robots):
                if time.monotonic() - begin > 600:
                    raise SystemExit("the robots have not got the fused map of map-fusion fuse in 10 minutes")
                time.sleep(0.2)
            seconds = time.monotonic() - begin
            print(f"{pair.name}, loss {loss} %: both have the fused map of `fuse` after {seconds:.0f} s")
            time.sleep(3)  # what is on its way
            received, cpu = [r.received() for r in robots], [r.cpu() for r in robots]
            time.sleep(STANDING)
            for i, robot in enumerate(robots):
                other = robots[1 - i].name
                text = "\n".join(robot.lines())
                meets = MEETS.search(text)
                part = BOTH.search(text)[other]
                line = f"  {robot.name}: "
                if meets:
                    pose = matrix_of([float(v) for v in meets[2].split()])
                    shift, turn = error_of(pose, truth if i == 0 else inverse_of(truth))
                    line += f"meets {other} by {meets[4]} bytes, {shift:.2f} m {turn:.1f} deg off, {meets[3]} %; "
                line += (f"fused first with {part} bytes ({100 * int(part) / sizes[other]:.0f} %); " if part
                         else "fused first with the whole map; ")
                line += (f"received {received[i]} bytes, {received[i] / sizes[other]:.2f} times the samples; standing: "
                         f"{(robot.received() - received[i]) / STANDING:.0f} bytes/s, "
                         f"{100 * (robot.cpu() - cpu[i]) / STANDING:.1f} % CPU")
                print(line, flush=True)
        finally:
            subprocess.run([NETWORK, "down", prefix], check=True)


# The mission. The robots drive 0.5 m/s and scan every 2 m.
ROBOTS, SECONDS, PERIOD, RESOLUTION, SPEED, SPACING = 4, 1800, 20, 0.1, 0.5, 2


def write_drives(path):
    """Writes a mission of the simulator: each robot goes round the corridors of the office, from another corner."""
    common = (PROJECT / "tests/simulator/office.ini").read_text(encoding="utf-8").split("[robot_a]")[0]
    corners = [(17.0, 6.65), (34.5, 6.65), (34.5, 33.35), (17.0, 33.35)]
    text = [common]
    for i in range(ROBOTS):
        way, left = [corners[i]], SECONDS * SPEED
        while left > 0:
            a, b = way[-1], corners[(i + len(way)) % 4]
            length = math.dist(a, b)
            share = min(1, left / length)
            way.append(tuple(a[k] + share * (b[k] - a[k]) for k in (0, 1)))
            left -= length
        text.append(f"""
[robot_{i + 1}]
waypoints = {'; '.join(f'{x:.2f} {y:.2f}' for x, y in way)}
floor_z = 0.0
scan_spacing = {SPACING}
speed = {SPEED}
start_time = 0
radius = 0.2
ground_clearance = 0.2
sensor_pose = 0.10 0.00 1.00 0 2 0
map_frame = {way[0][0]} {way[0][1]} 0.02 {37 * i} 0 0
""")
    path.write_text("\n".join(text), encoding="utf-8")


def make_mission(build, folder):
    write_drives(folder / "drives.ini")
    subprocess.run([build / "bin/simulate-robots", folder / "drives.ini", "--world", "office", "--out", folder],
                   check=True, stdout=subprocess.DEVNULL)
    for i in range(1, ROBOTS + 1):
        subprocess.run([build / "bin/mission_player", "record", folder / f"robot_{i}.rawlog", folder / f"r{i}.rawlog",
                        str(round(PERIOD * SPEED / SPACING)), str(PERIOD), str(RESOLUTION)], check=True)
        (folder / f"robot_{i}.rawlog").unlink()
    (folder / "all.rawlog").unlink()


def drive(build, rate, speed):
    program, prefix = build / "bin/map-fusion", f"bl{os.getpid()}r"
    names = [f"r{i}" for i in range(1, ROBOTS + 1)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_mission(build, folder)
        subprocess.run([NETWORK, "up", prefix, str(ROBOTS), rate], check=True)
        try:
            players = [subprocess.Popen([build / "bin/mission_player", "play", f"{r}.rawlog", f"{r}.ot", str(speed)],
                                        cwd=folder) for r in names]
            while not all((folder / f"{r}.ot").exists() for r in names):
                time.sleep(0.1)
            robots = [Robot(program, folder, prefix, i, "--threads", "1") for i in range(1, ROBOTS + 1)]
            time.sleep(SECONDS / speed / 3)
            third, threads = [r.peak_memory() for r in robots], [r.threads() for r in robots]
            for player in players:
                if player.wait() != 0:
                    raise SystemExit("a mission cannot be played")
            apart = [sum(r.cpu(t) for t in r.threads() & known) for r, known in zip(robots, threads)]
            cpu, end = [r.cpu() for r in robots], [r.peak_memory() for r in robots]
            subprocess.run([program, "fuse", "-q", *(f"{r}.ot" for r in names), "-o", "expected.ot"], cwd=folder,
                           check=False)  # a map may be left out
            expected, begin = (folder / "expected.ot").read_bytes(), time.monotonic()
            while not all(r.fused() == expected for r in robots):
                if time.monotonic() - begin > 600:
                    raise SystemExit("the robots have not got the fused map of map-fusion fuse in 10 minutes")
                time.sleep(0.2)
            print(f"mission of {SECONDS / 60:.0f} minutes at {speed:g} times its speed, {rate}: all have the fused map "
                  f"of `fuse` {time.monotonic() - begin:.0f} s after its end")
            for i, robot in enumerate(robots):
                print(f"  {robot.name}: at most {third[i]:.0f} MB after a third, {end[i]:.0f} MB at the end, "
                      f"{robot.peak_memory():.0f} MB when all was fused; CPU {cpu[i]:.1f} s, apart from matches "
                      f"{apart[i]:.1f} s: {100 * apart[i] / SECONDS:.1f} % at real speed, "
                      f"{apart[i] * PERIOD / SECONDS:.2f} s for each change; received {robot.received()} bytes; "
                      f"map {(folder / f'{robot.name}.ot').stat().st_size} bytes")
        finally:
            subprocess.run([NETWORK, "down", prefix], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="*", type=Path, metavar="DIR")
    parser.add_argument("--loss", action="append", type=int)
    parser.add_argument("--rate", default="256kbit")
    parser.add_argument("--mission", action="store_true")
    parser.add_argument("--speed", type=float, default=20)
    parser.add_argument("--build", type=Path, default=PROJECT / "build")
    args = parser.parse_args()
    for pair in args.pairs:
        for loss in args.loss or [0]:
            run(args.build.resolve() / "bin/map-fusion", pair, loss, args.rate)
    if args.mission:
        drive(args.build.resolve(), args.rate, args.speed)


if __name__ == "__main__":
    main()
