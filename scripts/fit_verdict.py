#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""fit_verdict.py CSV... [--output FILE.ini] [--version N]: fits the verdict's model.

Reads the table "kinds" of the benchmark (fusion-benchmark kinds): matches of maps of all kinds, at right and
wrong poses, with their evidence. Fits the logistic regression of VerdictModel (mrpt/fusion/evaluation.h)
and prints its coefficients beside those of share/mrpt_fusion/config_files/verdict_model.ini, with the
log-loss and the number of wrong verdicts of both, in total and for each kind. The fit is cross-validated
by building: the data sets of each building are judged by a fit on all others. A building is the name of
a data set up to its last "_". --output writes the fit as an .ini file.
"""
import argparse
import configparser
import csv
import sys
from pathlib import Path

import numpy as np

KEYS = ("constant", "log_overlap", "conflict_ratio", "runner_up", "inlier_ratio")
COMMENTS = {
    "version": "Version of the fit",
    "constant": "Log-odds without any evidence",
    "log_overlap": "Log-odds per natural logarithm of the overlap",
    "conflict_ratio": "Log-odds per share of obstacles in the other map's free space",
    "runner_up": "Log-odds per agreement of the best other pose over this pose's",
    "inlier_ratio": "Log-odds per share of inliers",
    "min_overlap": "Overlaps below this count as this",
}
MIN_OVERLAP = 1e-3
MAX_RUNNER_UP = 1.0  # a rival that agrees better than the pose is no stronger evidence
MIN_RIVAL_SUPPORT = 0.05  # a rival that confirms less counts less
OTHER_SIDE_RIVAL = 0.25  # weight of a rival that is confirmed only from the other side
TOLERANCE_M, TOLERANCE_DEG = 0.6, 6  # a pose is right within both
MIN_PROBABILITY = 0.85  # of an accepted match
MODEL = Path(__file__).resolve().parent.parent / "share/mrpt_fusion/config_files/verdict_model.ini"
# Keeps coefficients finite where the evidence separates right from wrong completely: weight of the
# squared coefficients, of evidence with a standard deviation of 1.
RIDGE = 0.1


def rival_weight(row):
    """As Evaluation::rival_weight, at most 1."""
    runner_up = float(row["runner_up"])
    if runner_up > 1:
        return MAX_RUNNER_UP
    support, facing = (min(float(row[key]) / MIN_RIVAL_SUPPORT, 1)
                       for key in ("rival_support", "rival_same_side"))
    return runner_up * support * (facing + (1 - facing) * OTHER_SIDE_RIVAL)


def building_of(dataset):
    return dataset.rpartition("_")[0] or dataset


def read(paths):
    """Evidence (n x 5), whether each pose is right (n), building and kind of each (n)."""
    evidence, right, buildings, kinds = [], [], [], []
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                if "rival_same_side" not in row:
                    sys.exit(f"{path}: has no column rival_same_side: run fusion-benchmark kinds")
                evidence.append([1, np.log(max(float(row["matched_overlap"]), MIN_OVERLAP)),
                                 float(row["conflict_ratio"]), rival_weight(row),
                                 float(row["inlier_ratio"])])
                right.append(float(row["error_m"]) <= TOLERANCE_M * float(row["scale"]) and
                             float(row["error_deg"]) <= TOLERANCE_DEG)
                buildings.append(building_of(row["dataset"]))
                kinds.append(row["kind"])
    if not any(right) or all(right):
        sys.exit("the tables hold no right pose, or no wrong pose: there is nothing to fit")
    return np.array(evidence), np.array(right), np.array(buildings), np.array(kinds)


def fit(evidence, right):
    """Maximum likelihood with a slight ridge, by Newton's method."""
    scale = np.maximum(evidence.std(axis=0), 1e-9)
    scale[0] = 1
    x = evidence / scale
    w = np.zeros(x.shape[1])
    for _ in range(100):
        p = probability(x, w)
        penalty = RIDGE * np.eye(len(w))
        penalty[0, 0] = 1e-6  # the constant is free
        gradient = x.T @ (right - p) - penalty @ w
        hessian = (x * (p * (1 - p))[:, None]).T @ x + penalty
        step = np.linalg.solve(hessian, gradient)
        w += step
        if np.abs(step).max() < 1e-10:
            break
    return w / scale


def probability(evidence, coefficients):
    return 1 / (1 + np.exp(-np.clip(evidence @ coefficients, -500, 500)))


def log_loss(p, right):
    p = np.clip(p, 1e-9, 1 - 1e-9)
    return -np.mean(np.where(right, np.log(p), np.log(1 - p)))


def describe(name, p, right):
    accepted = p >= MIN_PROBABILITY
    print(f"{name:26} log-loss {log_loss(p, right):.4f}, accepted wrong "
          f"{np.sum(accepted & ~right)} of {np.sum(~right)}, rejected right "
          f"{np.sum(~accepted & right)} of {np.sum(right)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="+", metavar="CSV")
    parser.add_argument("--output", metavar="FILE.ini")
    parser.add_argument("--version", type=int, default=1)
    arguments = parser.parse_args()
    evidence, right, buildings, kinds = read(arguments.tables)

    current = configparser.ConfigParser(inline_comment_prefixes=("//",))
    current.read(MODEL, encoding="utf-8")
    in_use = np.array([float(current["VerdictModel"][key]) for key in KEYS])
    fitted = fit(evidence, right)
    print(f"{len(right)} matches, {np.sum(right)} right, of {len(set(buildings))} buildings")
    print(f"{'':16} {'in use':>10} {'fitted':>10}")
    for key, old, new in zip(KEYS, in_use, fitted):
        print(f"{key:16} {old:10.4g} {new:10.4g}")
    describe("model in use", probability(evidence, in_use), right)
    describe("fit, on its own data", probability(evidence, fitted), right)
    if len(set(buildings)) > 1:
        p = np.empty(len(right))
        for building in set(buildings):
            held_out = buildings == building
            p[held_out] = probability(evidence[held_out], fit(evidence[~held_out],
                                                              right[~held_out]))
        describe("fit, cross-validated", p, right)
        for kind in dict.fromkeys(kinds):
            describe("  " + kind, p[kinds == kind], right[kinds == kind])

    if arguments.output:
        values = {"version": arguments.version, **dict(zip(KEYS, fitted)),
                  "min_overlap": MIN_OVERLAP}
        lines = ["[VerdictModel]"] + [f"{key} = {value:.6g} // {COMMENTS[key]}"
                                      for key, value in values.items()]
        part = Path(arguments.output + ".part")
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
        part.replace(arguments.output)


if __name__ == "__main__":
    main()
