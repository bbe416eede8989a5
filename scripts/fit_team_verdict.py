#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""fit_team_verdict.py CSV... [--check CSV...]: fits the probability that a map of a team is placed right.

Reads tables of scripts/benchmark_team.py --table: for each map of a mission the place that the team prefers, with its
evidence. Fits the logistic regression of PlaceModel (modules/fusion_team/graph/place_model.h) and prints its
coefficients. A place is right within 0.6 m and 6 deg. Each mission counts with and without false matches.
--check prints the reliability of the fit, and of the probabilities in the tables, on tables of other missions.
"""
import argparse
import csv
import math

import numpy as np

from fit_verdict import TOLERANCE_DEG, TOLERANCE_M, fit, log_loss, probability

KEYS = ("constant", "runner_up", "log_overlap")
MIN_OVERLAP = 0.01  # smaller overlaps count as this
BINS = (0, 0.05, 0.2, 0.5, 0.8, 0.9, 0.95, 0.98, 1)


def is_right(row, metres, degrees):
    return row[metres] != "" and float(row[metres]) <= TOLERANCE_M and float(row[degrees]) <= TOLERANCE_DEG


def team_rows(paths):
    """Lines of all maps but the first of each mission."""
    rows = []
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if row["method"] == "team" and row["robot"] != "robot_0"]
    return rows


def places(rows):
    """Evidence (n x 3) of the maps that have a place, and whether each place is right."""
    evidence, right = [], []
    for row in rows:
        if row["place_error_m"] == "":
            continue
        evidence.append([1, min(float(row["runner_up"]), 1), math.log(max(float(row["overlap"]), MIN_OVERLAP))])
        right.append(is_right(row, "place_error_m", "place_error_deg"))
    return np.array(evidence), np.array(right)


def print_reliability(p, right):
    print("| Stated | Maps | Mean probability | Right |\n| ---: | ---: | ---: | ---: |")
    for low, high in zip(BINS, BINS[1:]):
        inside = (p >= low) & ((p < high) | (high == 1))
        if inside.any():
            print(f"| {low:g} to {high:g} | {inside.sum()} | {p[inside].mean():.3f} | "
                  f"{right[inside].sum()}/{inside.sum()} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="+", metavar="CSV")
    parser.add_argument("--check", nargs="+", default=[], metavar="CSV")
    arguments = parser.parse_args()
    evidence, right = places(team_rows(arguments.tables))
    coefficients = fit(evidence, right)
    loss = log_loss(probability(evidence, coefficients), right)
    print(f"{len(right)} places, {right.sum()} right, log-loss {loss:.4f}")
    for key, value in zip(KEYS, coefficients):
        print(f"{key:16} {value:10.4g}")
    if arguments.check:
        rows = team_rows(arguments.check)
        evidence, right = places(rows)
        p = probability(evidence, coefficients)
        print(f"\nOther missions: {len(right)} places, {right.sum()} right, log-loss {log_loss(p, right):.4f}")
        print_reliability(p, right)
        print("\nProbabilities in the tables, of the poses that were reported:")
        print_reliability(np.array([float(row["probability"]) for row in rows]),
                          np.array([is_right(row, "error_m", "error_deg") for row in rows]))


if __name__ == "__main__":
    main()
