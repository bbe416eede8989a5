#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_link.py DIR... [--loss PERCENT]... [--rate RATE] [--build DIR]: bytes and times of map-fusion join.

Each DIR holds map_a.ot, map_b.ot and T_a_b.txt, as scripts/benchmark.sh makes them. Robot r1 has map_a.ot, r2 has
map_b.ot. Each is in a network namespace of its own, behind RATE (default 256kbit), and r2 loses PERCENT (default 0) of
the packets that it should receive. Needs root, ip, tc and nft.

Prints for each robot: the error (m, deg) and the probability of the pose at which it meets the other, with the bytes of
the outline; the bytes of the other map with which both maps were fused first; the time until both have both maps;
all bytes that it received, Ethernet's headers included, over the bytes of the other map's samples; then, while nothing
changes, bytes per second and CPU. Checks that both fused maps are that of map-fusion fuse.
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
    def __init__(self, program, folder, prefix, number):
        self.name, self.namespace, self.folder = f"r{number}", f"{prefix}{number}", folder
        self.log = folder / f"{self.name}.log"
        self.process = subprocess.Popen(
            ["ip", "netns", "exec", self.namespace, program, "join", "--robot", self.name, "--map",
             f"{self.name}.ot", "--domain", "7", "-o", f"fused_{self.name}.ot"],
            cwd=folder, stdout=open(self.log, "w"), stderr=subprocess.STDOUT)

    def received(self):
        return int(subprocess.run(["ip", "netns", "exec", self.namespace, "cat",
                                   "/sys/class/net/eth0/statistics/rx_bytes"],
                                  check=True, capture_output=True, text=True).stdout)

    def cpu(self):
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", type=Path, metavar="DIR")
    parser.add_argument("--loss", action="append", type=int)
    parser.add_argument("--rate", default="256kbit")
    parser.add_argument("--build", type=Path, default=PROJECT / "build")
    args = parser.parse_args()
    for pair in args.pairs:
        for loss in args.loss or [0]:
            run(args.build.resolve() / "bin/map-fusion", pair, loss, args.rate)


if __name__ == "__main__":
    main()
