#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Turns RESULTS_DIR/speed.csv and steps.json into the tables of doc/performance.md.

Writes RESULTS_DIR/performance.md. With --page, a markdown page gets its tables, as by report.py.
"""
import argparse
import json
import sys
from pathlib import Path

import numpy as np

from report import (ReportError, column, group, markdown, median, number, read_csv, summary, typical,
                    update_page)

SPEED = ["dataset", "method", "round", "cpu_s", "wall_s", "error_m", "error_deg"]
OURS, OURS_ON_TWO = "default", "default_2_threads"
STEPS = {
    "parse": "read a map, from memory", "load": "read a map, from a file",
    "extract": "occupied voxels", "surfaces": "normals", "edges": "edges",
    "index": "index by place, thinning", "features": "all features of a map", "associate_0.2m": "association, gate 0.2 m",
    "associate_0.5m": "association, gate 0.5 m", "linearize": "one optimisation step",
    "search": "search for starts", "match": "whole match, features given",
    "evaluate": "evaluation", "merge": "merging",
    "insert": "insert scans, per beam", "insert_octomap": "insert scans, octomap, per beam", "save": "write a map"}


def read_steps(path):
    """The medians of each benchmark by step, then by pair: {"cpu_ns", "bytes", "ns_per_voxel"}."""
    try:
        runs = [run for run in json.loads(path.read_text(encoding="utf-8"))["benchmarks"]
                if run["run_type"] == "iteration"]
        scale = {"ns": 1, "us": 1e3, "ms": 1e6, "s": 1e9}
        rows = [{"step": name[0], "pair": name[1], "bytes": run["bytes"],
                 "cpu_ns": run["cpu_time"] * scale[run["time_unit"]],
                 "ns_per_voxel": run.get("ns_per_voxel", np.nan), "voxels": run.get("voxels", np.nan)}
                for run in runs for name in [run["run_name"].split("/")]]
    except (ValueError, KeyError) as error:
        raise ReportError(f"{path}: is not what step-benchmark writes: {error!r}") from None
    names = ("bytes", "cpu_ns", "ns_per_voxel", "voxels")
    # They ran in any order: by the page's and, of each step, the smallest pair first.
    order = list(STEPS)
    rows.sort(key=lambda row: (order.index(row["step"]) if row["step"] in STEPS else -1,
                               row["voxels"]))
    return {step: {pair: {name: median(of_pair, name) for name in names}
                   for pair, of_pair in group(of_step, "pair").items()}
            for step, of_step in group(rows, "step").items()}


def spread(name):
    """For a column of a table: the least and the largest value."""
    return lambda rows: (None, "–".join(number(value(column(rows, name)))[1] for value in (min, max)))


def match_table(rows):
    """Whole matches of all methods, on one thread."""
    ours = group((row for row in rows if row["method"] == OURS), "dataset")

    def ratio(of_method):
        reference = ours.get(of_method[0]["dataset"])
        return number(median(of_method, "cpu_s") / median(reference, "cpu_s") if reference else np.nan)

    return summary([row for row in rows if row["method"] != OURS_ON_TWO], ["dataset", "method"], [
        ("CPU, s", typical("cpu_s"), min), ("Least to most", spread("cpu_s")),
        ("Times ours", ratio), ("Error, m", typical("error_m")), ("Error, °", typical("error_deg"))])


def threads_table(rows):
    """Our own match on one thread and on two."""
    lines = []
    for dataset, of_set in group(rows, "dataset").items():
        walls = [median([row for row in of_set if row["method"] == name], "wall_s")
                 for name in (OURS, OURS_ON_TWO)]
        lines.append([dataset, *(number(value)[1] for value in (*walls, walls[0] / walls[1]))])
    return markdown(["Dataset", "One thread, s", "Two threads, s", "Speed-up"], lines)


def steps_table(steps, bandwidth):
    """Each step per voxel, how that grows, and what copying the step's bytes would take."""
    pairs = list(dict.fromkeys(pair for of_step in steps.values() for pair in of_step))
    lines = []
    for step, of_step in steps.items():
        times = [of_step.get(pair, {}).get("ns_per_voxel", np.nan) for pair in pairs]
        largest = of_step.get(pairs[-1])
        bound = largest["bytes"] / largest["voxels"] / bandwidth if largest else np.nan
        growth = times[-1] / times[-2] if len(times) > 1 else np.nan
        lines.append([STEPS.get(step, step), *(number(value)[1] for value in (
            *times, growth, bound, times[-1] / bound))])
    growth_title = f"Growth {pairs[-2]} → {pairs[-1]}" if len(pairs) > 1 else "Growth"
    return markdown(["Step", *(f"ns/voxel, {pair}" for pair in pairs), growth_title,
                     "Lower bound, ns/voxel", "Times the bound"], lines)


def sizes_table(steps, bandwidth):
    """How large the pairs are, and how fast the memory."""
    lines = [[pair, *(number(steps[step][pair]["voxels"], ".0f")[1] for step in ("extract", "match")),
              number(bandwidth)[1]] for pair in steps["match"]]
    return markdown(["Dataset", "Voxels A", "Voxels A and B", "Copying, GB/s read and written"], lines)


def all_tables(folder):
    """By name, (caption, table)."""
    speed = read_csv(folder / "speed.csv", SPEED)
    steps = read_steps(folder / "steps.json")
    copying = next(iter(steps.pop("copy", {}).values()), None)
    if not copying or "extract" not in steps or "match" not in steps:
        raise ReportError(f"{folder / 'steps.json'}: copy, extract or match is missing")
    bandwidth = copying["bytes"] / copying["cpu_ns"]  # bytes per ns are GB/s
    return {
        "match": ("Whole matches, preparation included, on one thread.", match_table(speed)),
        "threads": ("Our own match on two threads, wall time.", threads_table(speed)),
        "steps": ("CPU time of each step.", steps_table(steps, bandwidth)),
        "sizes": ("The pairs that the steps ran on.", sizes_table(steps, bandwidth))}


def main():
    """The command line; 1 if something is missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, metavar="RESULTS_DIR", help="folder of the two files")
    parser.add_argument("--page", type=Path, help="markdown page to put tables into")
    arguments = parser.parse_args()
    try:
        tables = all_tables(arguments.results)
        (arguments.results / "performance.md").write_text("\n".join(
            f"## {name}\n\n{caption}\n\n{text}\n" for name, (caption, text) in tables.items()),
            encoding="utf-8")
        if arguments.page:
            update_page(arguments.page, tables, arguments.results)
    except (ReportError, OSError) as error:
        print(f"performance.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
