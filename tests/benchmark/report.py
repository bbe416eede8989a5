#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Turns the CSV files of a benchmark run into the tables and figures of the paper (Sec. VI).

Writes RESULTS_DIR/tables.md and RESULTS_DIR/figures/. With --page, a markdown page gets its tables
(between `<!-- table NAME -->` and `<!-- end NAME -->`) and, beside it, the figures it links to.
"""
import argparse
import csv
import re
import shutil
import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.cbook import boxplot_stats
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FormatStrFormatter, LogLocator, MaxNLocator, NullLocator

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)

COLUMNS = {
    "data": "dataset voxels_a voxels_b edges_a edges_b overlap size_x_m size_y_m size_z_m"
            " resolution_m truth",
    "starts": "dataset method start dx_m dy_m dyaw_deg error_paper_m error_paper_deg"
              " error_centre_m cpu_s wall_s mean_mahalanobis inlier_threshold verdict",
    "methods": "dataset method preprocess_cpu_s preprocess_wall_s peak_rss_mb",
    "inliers": "dataset method threshold inlier_ratio_mean inlier_ratio_q25 inlier_ratio_q75",
    "edge_iterations": "dataset method start iteration error_m error_deg mse_m2",
    "overlap": "dataset method cut_m overlap start error_m error_deg verdict",
    "anywhere": "dataset band overlap start error_m error_deg cpu_s verdict",
    "verdicts": "dataset guess overlap case error_m error_deg probability nees verdict"
                " matched_overlap conflict_ratio runner_up inlier_ratio",
    "mixes": "dataset mix start error_m error_deg verdict",
    "merging": "dataset policy size entropy_occupied entropy_known log_loss brier f1"
               " building_log_loss building_brier building_f1",
    "ablation": "dataset variant starts success strict median_m median_deg median_cpu_s",
}
TEXT_COLUMNS = {"dataset", "method", "band", "guess", "case", "mix", "start", "verdict", "truth", "policy", "variant"}
NAMES = {
    "icp": "PCL ICP", "icp_plane": "PCL point-to-plane", "gicp": "PCL GICP", "ndt": "PCL NDT",
    "first_level": "PMM, first level", "pmm_paper": "PMM as published",
    "no_search": "mrpt-fusion, no search", "default": "mrpt-fusion (default)", "edge_icp": "ICP on edges",
    "relative_entropy": "relative entropy", "bayes": "Bayes"}
COLOURS = {
    "icp": "#8c8c8c", "icp_plane": "#56b4e9", "gicp": "#009e73", "ndt": "#e69f00",
    "first_level": "#0072b2", "pmm_paper": "#222222", "no_search": "#b8860b",
    "default": "#d55e00", "edge_icp": "#cc79a7",
    "stitch": "#8c8c8c", "average": "#56b4e9", "relative_entropy": "#0072b2", "bayes": "#d55e00"}
SPARE_COLOURS = ["#7f4f24", "#5d3a9b", "#a3a500", "#004d40"]
LOOSE, STRICT = (0.6, 6.0), (0.1, 1.0)  # metres, degrees
LOOSE_TITLE, STRICT_TITLE = "≤ 0.6 m, 6°", "≤ 0.1 m, 1°"
MAX_POINTS = 400  # of a Fig. 11, which keeps its SVG below 60 kB
STYLE = {
    "font.size": 8.5, "font.sans-serif": "DejaVu Sans",
    "svg.fonttype": "none", "svg.hashsalt": "mrpt-fusion", "lines.solid_capstyle": "butt",
    "axes.titlesize": 9,
    "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
    "grid.color": "#dddddd", "grid.linewidth": 0.6,
    "legend.frameon": False, "hatch.linewidth": 0.7}


class ReportError(Exception):
    """What is wrong with the input, in one line."""


def read_csv(path, columns):
    """The rows of a CSV file as dicts; numbers as floats, empty ones as NaN."""
    with path.open(newline="", encoding="utf-8", errors="replace") as file:
        reader = csv.DictReader(file)
        missing = [name for name in columns if name not in (reader.fieldnames or [])]
        if missing:
            raise ReportError(f"{path}: no column {', '.join(missing)}")
        try:
            rows = [{name: typed(name, row[name]) for name in columns} for row in reader]
        except ValueError as error:
            raise ReportError(f"{path}, line {reader.line_num}: {error}") from None
    if not rows:
        raise ReportError(f"{path}: no rows")
    return rows


def typed(name, text):
    """A field as text or number."""
    if text is None or name == "verdict" and text not in ("", "accepted", "rejected"):
        raise ValueError(f"{name} is missing" if text is None else f"unknown verdict {text}")
    return text if name in TEXT_COLUMNS else float(text or "nan")


def read_results(folder):
    """All files of a run by name. Starts also hold what methods.csv says of their method; methods
    without a colour of their own get a spare one."""
    results = {name: read_csv(folder / f"{name}.csv", columns.split())
               for name, columns in COLUMNS.items()}
    costs = group(results["methods"], "dataset", "method")
    for row in results["starts"]:
        key = (row["dataset"], row["method"])
        if key not in costs:
            raise ReportError(f"{folder / 'methods.csv'}: no row for {', '.join(key)}")
        row.update(costs[key][0])
    used = [row.get("method") or row.get("policy") for rows in results.values() for row in rows]
    unknown = [name for name in dict.fromkeys(used) if name and name not in COLOURS]
    for i, name in enumerate(unknown):
        COLOURS[name] = SPARE_COLOURS[i % len(SPARE_COLOURS)]
    return results


def group(rows, *keys):
    """Rows by the value of one key, or the tuple of several, in order of appearance."""
    groups = {}
    for row in rows:
        value = tuple(row[key] for key in keys)
        groups.setdefault(value if len(keys) > 1 else value[0], []).append(row)
    return groups


def given(rows, name):
    """The rows that have a value of a column; it is an error if none has."""
    having = [row for row in rows if not np.isnan(row[name])]
    if not having:
        raise ReportError(f"the column {name} is empty throughout")
    return having


def column(rows, name):
    """A column as an array."""
    return np.array([row[name] for row in rows])


def statistic(function, rows, name):
    """A statistic, such as np.median, of the values that are given; NaN if none is."""
    values = [row[name] for row in rows if not np.isnan(row[name])]
    return function(values) if values else np.nan


def median(rows, name):
    """The median of the values that are given."""
    return statistic(np.median, rows, name)


def within(rows, limits, metres="error_centre_m", degrees="error_paper_deg"):
    """Which rows are at most so far off; a row without an error is not."""
    return (column(rows, metres) <= limits[0]) & (column(rows, degrees) <= limits[1])


def number(value, form=None):
    """A cell, (value, text): a dash where the number does not apply, else (without a format) three
    significant digits."""
    if np.isnan(value):
        return None, "–"
    if form is None:
        form = ".0f" if abs(value) >= 99.95 else "#.3g"
    return value, format(value, form)


def count(mask):
    """A cell, (value, text): how many of all."""
    return np.mean(mask), f"{np.sum(mask)}/{len(mask)}"


def first(name, form=None):
    """For a column of a table: the value in the first row of a group."""
    return lambda rows: number(rows[0][name], form)


def typical(name, form=None, function=np.median):
    """For a column of a table: the median, or another statistic, over a group of rows."""
    return lambda rows: number(statistic(function, rows, name), form)


def good(limits, *names):
    """For a column of a table: how many of a group of rows are within the limits."""
    return lambda rows: count(within(rows, limits, *names))


def embolden(cells, best=None):
    """The texts of cells, the best (min or max) in bold unless all are equal."""
    texts = {value: text for value, text in cells if value is not None}
    if not best or len(set(texts.values())) < 2:
        return [text for _, text in cells]
    return [f"**{text}**" if text == texts[best(texts)] else text for _, text in cells]


def markdown(titles, lines):
    """A GitHub table; a dataset is named in its first line only."""
    left = ("Dataset", "Method", "Policy", "Variant", "Truth", "Verdict", "Step")
    rows = [titles, ["---" if title in left else "---:" for title in titles]]
    for before, line in zip([[""]] + lines, lines):
        rows.append([line[0] if line[0] != before[0] else "", *line[1:]])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def summary(rows, keys, columns):
    """A table with a line per group of rows. A column is (title, rows -> cell) or, to have the best
    in bold, (title, rows -> cell, min or max); lines that differ in the last key only compete."""
    lines = []
    for peers in group(rows, "dataset", *keys[:-1]).values():
        groups = group(peers, keys[-1])
        cells = [embolden([cell(of_line) for of_line in groups.values()], *best)
                 for _, cell, *best in columns]
        for (name, of_line), *texts in zip(groups.items(), *cells):
            labels = [of_line[0][key] for key in keys[:-1]] + [NAMES.get(name, name)]
            lines.append([format(label, "" if label == str(label) else "g") for label in labels]
                         + texts)
    titles = [key.capitalize().replace("_m", ", m") for key in keys]
    return markdown(titles + [title for title, *_ in columns], lines)


def total(rows, clock):
    """Seconds for preprocessing and (median) registration by a clock, cpu or wall."""
    return np.nan_to_num(rows[0][f"preprocess_{clock}_s"]) + median(rows, f"{clock}_s")


def verdicts(*names):
    """Columns that count verdicts on poses right (within 0.6 m and 6°) and wrong."""
    def counted(verdict, right):
        return lambda rows: number(
            np.sum((column(rows, "verdict") == verdict) & (within(rows, LOOSE, *names) == right))
            if any(column(rows, "verdict")) else np.nan, ".0f")

    return [(f"{verdict.capitalize()}, {'right' if right else 'wrong'}", counted(verdict, right))
            for verdict in ("accepted", "rejected") for right in (True, False)]


def part_of_starts(name):
    """For a column of a table: a count beside the number of starts."""
    return lambda rows: (rows[0][name], f"{rows[0][name]:.0f}/{rows[0]['starts']:.0f}")


def ratio_to_ours(results):
    """For a column of a table: total CPU time as a multiple of the default method's."""
    ours = group((row for row in results["starts"] if row["method"] == "default"), "dataset")

    def ratio(rows):
        dataset = rows[0]["dataset"]
        return number(total(rows, "cpu") / total(ours[dataset], "cpu") if dataset in ours
                      else np.nan)

    return ratio


def nees_of_right(function):
    """A column: a statistic of the normalised estimation errors squared of the right poses."""
    def of_right(rows):
        right = column(rows, "nees")[within(rows, LOOSE, "error_m", "error_deg")]
        return number(function(right) if right.size else np.nan, ".1f")
    return of_right


def by_probability(rows):
    """The rows in order of their probability, each with the range that it lies in."""
    bounds = [0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 1]

    def named(row):
        i = min(np.searchsorted(bounds, row["probability"], "right"), len(bounds) - 1)
        return {**row, "dataset": "all", "stated": f"{bounds[i - 1]:g} to {bounds[i]:g}"}

    return [named(row) for row in sorted(rows, key=lambda row: row["probability"])]


def simple_tables(results):
    """The tables that summarise rows: by name, (caption, rows, keys, columns)."""
    starts, by_method, errors = results["starts"], ["dataset", "method"], ("error_m", "error_deg")
    several = len(group(starts, "dataset")) > 1
    everywhere = [{**row, "dataset": "all"} for row in starts if several]
    judged = [row for rows in group(starts, *by_method).values()
              if any(column(rows, "verdict")) for row in rows]
    return {
        "data": ("Table II: the pairs of maps.", results["data"], ["dataset"], [
            ("Voxels A", first("voxels_a", ".0f")), ("Voxels B", first("voxels_b", ".0f")),
            ("Edges A", first("edges_a", ".0f")), ("Edges B", first("edges_b", ".0f")),
            ("Overlap", first("overlap", ".0%")),
            ("Size, m", lambda rows: (None, " × ".join(f"{rows[0][f'size_{axis}_m']:.3g}"
                                                       for axis in "xyz"))),
            ("Voxel, m", first("resolution_m", "g")),
            ("Truth", lambda rows: (None, rows[0]["truth"]))]),
        "success": (
            "Fig. 13 in numbers: successes by the displacement of map B's middle, and by the"
            " paper's ΔT.", starts + everywhere, by_method, [
                (LOOSE_TITLE, good(LOOSE), max), (STRICT_TITLE, good(STRICT), max),
                (f"ΔT {LOOSE_TITLE}", good(LOOSE, "error_paper_m"), max),
                (f"ΔT {STRICT_TITLE}", good(STRICT, "error_paper_m"), max)]),
        "errors": ("Table III: errors of the starts that gave a pose.", starts, by_method, [
            ("Poses", lambda rows: count(~np.isnan(column(rows, "error_centre_m")))),
            ("Mean, m", typical("error_centre_m", ".3f", np.mean), min),
            ("Median, m", typical("error_centre_m", ".3f"), min),
            ("ΔT, mean, m", typical("error_paper_m", ".3f", np.mean), min),
            ("ΔT, median, m", typical("error_paper_m", ".3f"), min),
            ("Rotation, mean, °", typical("error_paper_deg", ".2f", np.mean), min),
            ("Rotation, median, °", typical("error_paper_deg", ".2f"), min)]),
        "time": ("Table IV: medians over the starts.", starts, by_method, [
            ("Registration, CPU s", typical("cpu_s")),
            ("Preprocessing, CPU s", first("preprocess_cpu_s")),
            ("Total, CPU s", lambda rows: number(total(rows, "cpu")), min),
            ("Total / ours", ratio_to_ours(results)),
            ("Total, wall s", lambda rows: number(total(rows, "wall")), min),
            ("Peak, MB", first("peak_rss_mb", ".0f"), min)]),
        "verdicts": ("Verdicts on poses right (within 0.6 m and 6°) and wrong.", judged, by_method,
                     verdicts()),
        "overlap": (
            "Fig. 11 in numbers: errors and verdicts as the maps share less and less.",
            results["overlap"], ["dataset", "cut_m", "method"], [
                ("Overlap", typical("overlap", ".0%")),
                ("Median, m", typical("error_m", ".3f"), min),
                ("Median, °", typical("error_deg", ".2f"), min),
                (LOOSE_TITLE, good(LOOSE, *errors), max), *verdicts(*errors)]),
        "anywhere": (
            "Without a guess: errors, verdicts and the time of a whole match.",
            results["anywhere"], ["dataset", "band"], [
                ("Overlap", typical("overlap", ".0%")),
                (LOOSE_TITLE, good(LOOSE, *errors)), (STRICT_TITLE, good(STRICT, *errors)),
                ("Median, m", typical("error_m", ".3f")), ("Median, °", typical("error_deg", ".2f")),
                ("CPU, s", typical("cpu_s", ".2f")), *verdicts(*errors)]),
        "judged": (
            "Verdicts on matches of random parts of both maps and of a mirror image.",
            results["verdicts"], ["dataset", "guess"], [
                ("Matches", lambda rows: number(len(rows), ".0f")),
                ("Right", good(LOOSE, *errors)), *verdicts(*errors),
                ("NEES of right ones, mean", nees_of_right(np.mean)), ("Median", nees_of_right(np.median))]),
        "mixes": (
            "Maps that differ, from every fifth of the 125 starts.",
            results["mixes"], ["dataset", "mix"], [
                (LOOSE_TITLE, good(LOOSE, *errors)), (STRICT_TITLE, good(STRICT, *errors)),
                ("Median, m", typical("error_m", ".3f")), ("Median, °", typical("error_deg", ".2f")),
                *verdicts(*errors)]),
        "reliability": (
            "What the probability of being right is worth: matches by what it was, and how many"
            " of them were right.", by_probability(results["verdicts"]), ["stated"], [
                ("Matches", lambda rows: number(len(rows), ".0f")),
                ("Mean probability", typical("probability", ".3f", np.mean)),
                ("Right", good(LOOSE, *errors))]),
        "merging": (
            "Table V, and the merged maps against the truth; entropies and log-loss in nats.",
            results["merging"], ["dataset", "policy"], [
                ("Size, voxels", first("size", ".0f"), min),
                ("Entropy, occupied", first("entropy_occupied", ".4f"), min),
                ("Entropy, known", first("entropy_known", ".4f"), min),
                ("Log-loss", first("log_loss", ".4f"), min),
                ("Brier", first("brier", ".4f"), min), ("F1", first("f1", ".3f"), max),
                ("Building: log-loss", first("building_log_loss", ".4f"), min),
                ("Brier", first("building_brier", ".4f"), min),
                ("F1", first("building_f1", ".3f"), max)]),
        "ablation": ("What each part brings.", results["ablation"], ["dataset", "variant"], [
            (LOOSE_TITLE, part_of_starts("success"), max),
            (STRICT_TITLE, part_of_starts("strict"), max),
            ("Median, m", first("median_m", ".3f"), min),
            ("Median, °", first("median_deg", ".2f"), min),
            ("Median, CPU s", first("median_cpu_s"), min)]),
    }


def steps_to_converge(rows):
    """The iteration from which on the error stays within 0.01 m and 0.1° of its last value."""
    away = ((abs(column(rows, "error_m") - rows[-1]["error_m"]) > 0.01)
            | (abs(column(rows, "error_deg") - rows[-1]["error_deg"]) > 0.1))
    return rows[np.max(np.flatnonzero(away), initial=-1) + 1]["iteration"]


def edge_iterations(results):
    """Median iterations to converge, over the starts both methods solve and over all."""
    lines = []
    for dataset, of_set in group(results["edge_iterations"], "dataset").items():
        runs = group(sorted(of_set, key=lambda row: row["iteration"]), "method", "start")
        every = [s for m, s in runs if m == "edge_icp" and ("first_level", s) in runs]
        both = [s for s in every if within([runs[m, s][-1] for m in ("edge_icp", "first_level")],
                                           LOOSE, "error_m", "error_deg").all()]
        line = [dataset]
        for starts in (both, every):
            icp, ours = (np.median([steps_to_converge(runs[m, s]) for s in starts])
                         if starts else np.nan for m in ("edge_icp", "first_level"))
            cells = (number(icp, "g"), number(ours, "g"), number(ours / (icp or np.nan), ".2f"))
            line += [str(len(starts)), *(text for _, text in cells)]
        lines.append(line)
    return markdown(["Dataset", "Starts both solve", "ICP on edges", "First level", "Ratio",
                     "All starts", "ICP on edges, all", "First level, all", "Ratio, all"], lines)


def failures(results, limit=40):
    """Counts and a list of failures; the list, if not of all, takes from each dataset in turn."""
    ours = [row for row in results["starts"] if row["method"] == "default"]
    if not ours:
        raise ReportError("starts.csv: no row of the method default")
    counts = summary(ours, ["dataset"], [
        ("> 0.1 m or 1°", lambda rows: count(~within(rows, STRICT))),
        ("> 0.6 m or 6°", lambda rows: count(~within(rows, LOOSE)))])
    missed = [pair for rows in group(ours, "dataset").values() for pair in enumerate(
        row for row, strict in zip(rows, within(rows, STRICT)) if not strict)]
    listed = [row for _, row in sorted(missed, key=lambda pair: pair[0])[:limit]]
    forms = {"dx_m": "g", "dy_m": "g", "dyaw_deg": "g", "error_centre_m": ".3f",
             "error_paper_m": ".3f", "error_paper_deg": ".2f"}
    lines = [[dataset, row["start"], *(number(row[name], forms[name])[1] for name in forms),
              row["verdict"] or "–"]
             for dataset, rows in group(listed, "dataset").items() for row in rows]
    titles = ["Dataset", "Start", "dx, m", "dy, m", "dyaw, °", "Error, m", "ΔT, m",
              "Rotation, °", "Verdict"]
    return "\n\n".join([counts, markdown(titles, lines)] if lines else [counts])


def all_tables(results):
    """Caption and text of every table by its name."""
    tables = {name: (caption, summary(*rows_keys_columns)) for name, (caption, *rows_keys_columns)
              in simple_tables(results).items()}
    tables["edge_iterations"] = (
        "Fig. 10 in numbers: median iterations until the error stays within 0.01 m and 0.1° of its"
        " last value, over the starts both methods solve (0.6 m, 6°) and over all.",
        edge_iterations(results))
    tables["failures"] = ("Starts from which the default does not come within 0.1 m and 1°.",
                          failures(results))
    return tables


def panels(number_of, across=3, height=2.1, **options):
    """A figure with axes in rows of `across`, each with a grid of horizontal lines."""
    across = min(across, number_of)
    down = -(-number_of // across)
    figure, grid = plt.subplots(down, across, figsize=(9, height * down + 0.7), squeeze=False,
                                **options)
    for axes in grid.flat[number_of:]:
        axes.remove()
    for axes in grid.flat[:number_of]:
        axes.grid(axis="y")
    return figure, grid.flat[:number_of]


def legend_below(figure, names, others=(), across=5):
    """A legend, read line by line, of methods and other handles below all axes."""
    handles = [Patch(color=COLOURS[name], label=NAMES.get(name, name)) for name in names]
    handles += others
    across = min(across, len(handles))
    inches = 0.1 + 0.19 * -(-len(handles) // across)
    figure.legend(handles=[handle for i in range(across) for handle in handles[i::across]],
                  loc="lower center", ncol=across)
    figure.tight_layout(rect=(0, inches / figure.get_figheight(), 1, 1))


def line(label, **style):
    """A black line or marker for a legend."""
    return Line2D([], [], label=label, **{"color": "k", **style})


def shade(label, **style):
    """A grey patch for a legend."""
    return Patch(label=label, **{"facecolor": "#666666", "edgecolor": "w", "lw": 0, **style})


def log_scale(axes):
    """A logarithmic y axis in plain numbers."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 3), numticks=20))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))


def by_dataset(rows, draw, unit, key="method", **options):
    """A panel per dataset, where `draw(axes, position, rows, colour)` adds a method (or policy).
    Returns the figure, its axes by dataset and the names of all methods."""
    names, sets = list(group(rows, key)), group(rows, "dataset")
    figure, grid = panels(len(sets), **options)
    for i, (axes, (dataset, of_set)) in enumerate(zip(grid, sets.items())):
        for name, of_name in group(of_set, key).items():
            draw(axes, names.index(name), of_name, COLOURS[name])
        axes.set(title=dataset, ylabel=unit if i % 3 == 0 else "")
    return figure, dict(zip(sets, grid)), names


def boxes(results, name, unit, least=0.0, limits=()):
    """Figs. 12 and 14: box plots as in the paper (middle half, median, rhombus for the mean). With
    limits, they are drawn, the axis is logarithmic and no value is drawn below `least`."""
    def draw(axes, position, rows, colour):
        values = np.maximum(column(rows, name), least)
        axes.boxplot(values, positions=[position], widths=0.7, patch_artist=True, showmeans=True,
                     showcaps=False, showfliers=False, manage_ticks=False,
                     whiskerprops={"color": colour}, medianprops={"color": colour, "lw": 2.5},
                     boxprops={"edgecolor": colour, "facecolor": to_rgba(colour, 0.3)},
                     meanprops={"marker": "D", "ms": 4, "mfc": "w", "mec": "k", "mew": 0.8})
        outliers = boxplot_stats(values)[0]["fliers"]  # as one path: a marker each makes large SVGs
        axes.plot(np.tile([position - 0.12, position + 0.12, np.nan], len(outliers)),
                  np.repeat(outliers, 3), color=colour, lw=0.8)

    figure, grid, methods = by_dataset(given(results["starts"], name), draw, unit, sharey=True)
    styles = [{"ls": dashes, "lw": 1, "color": "k"} for dashes in ("--", ":")]
    for axes in grid.values():
        axes.set_xticks([])
        if limits:
            log_scale(axes)
        else:
            axes.set_ylim(bottom=0)
        for limit, style in zip(limits, styles):
            axes.axhline(limit, **style)
    legend_below(figure, methods, [
        line("median", lw=2.5), line("mean", marker="D", ms=4, ls="", mfc="w", mew=0.8),
        line("outlier", marker="_", ms=6, ls=""),
        *(line(f"limit, {limit:g} {unit.split()[-1]}", **style)
          for limit, style in zip(limits, styles))])
    return figure


def success_bars(results):
    """Fig. 13: success rates; per method by the error of map B's middle, then by the paper's."""
    def draw(axes, position, rows, colour):
        for shift, metres, hatch in ((-.2, "error_centre_m", ""), (.2, "error_paper_m", "////")):
            for limits, alpha in ((LOOSE, 0.4), (STRICT, 1)):
                axes.bar(position + shift, 100 * np.mean(within(rows, limits, metres)), 0.38,
                         color=colour, alpha=alpha, hatch=hatch, edgecolor="w", lw=0)

    figure, grid, methods = by_dataset(results["starts"], draw, "starts, %", sharey=True)
    for axes in grid.values():
        axes.set(xticks=[], ylim=(0, 100))
    legend_below(figure, methods, [
        shade("within 0.6 m and 6°", alpha=0.4), shade("within 0.1 m and 1°"),
        shade("by the paper's ΔT", hatch="////")])
    return figure


def time_bars(results):
    """Table IV as bars."""
    def draw(axes, position, rows, colour):
        seconds = total(rows, "cpu")
        axes.bar(position, seconds, 0.75, color=colour, alpha=0.4, lw=0)
        axes.bar(position, median(rows, "cpu_s"), 0.75, color=colour)
        axes.text(position, 1.1 * seconds, format(seconds, "#.2g" if seconds < 9.95 else ".0f"),
                  ha="center", fontsize=7)

    rows = given(results["starts"], "cpu_s")
    figure, grid, methods = by_dataset(rows, draw, "CPU time, s", sharey=True)
    seconds = [time for of_one in group(rows, "dataset", "method").values()
               for time in (median(of_one, "cpu_s"), total(of_one, "cpu"))]
    for axes in grid.values():
        axes.set(xticks=[], ylim=(min(seconds) / 2, 3 * max(seconds)))
        log_scale(axes)
    legend_below(figure, methods, [shade("registration (median)"),
                                   shade("with preprocessing", alpha=0.4)])
    return figure


def iteration_curves(dataset, of_set):
    """Fig. 10: edge matching over the iterations; a start that has ended keeps its last value."""
    figure, grid = panels(3)
    last = int(max(column(of_set, "iteration")))
    for axes, name, label in zip(grid, ("error_m", "error_deg", "mse_m2"), (
            "translation error, m", "rotation error, °", "mean squared distance, m²")):
        for method, rows in group(of_set, "method").items():
            curves = []
            for run in group(given(rows, name), "start").values():
                run.sort(key=lambda row: row["iteration"])
                curves.append(np.interp(range(last + 1), column(run, "iteration"),
                                        column(run, name), left=np.nan))
            low, mid, high = np.percentile(curves, (25, 50, 75), axis=0)
            axes.fill_between(range(last + 1), low, high, color=COLOURS[method], alpha=0.2,
                              lw=0)
            axes.plot(mid, color=COLOURS[method], lw=1.8)
        axes.set(xlabel="iteration", ylabel=label, title=dataset, xlim=(0, last))
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        log_scale(axes)
    legend_below(figure, group(of_set, "method"), [shade("middle half of the starts", alpha=0.3)])
    return figure


def overlap_scatter(dataset, of_set):
    """Fig. 11: results against overlap, hollow where rejected, with their median per cut."""
    methods = group(of_set, "method")
    figure, grid = panels(2, across=2, height=2.4)
    step = -(-2 * len(of_set) // MAX_POINTS)
    for axes, name, label in zip(grid, ("error_m", "error_deg"),
                                 ("translation error, m", "rotation error, °")):
        for shift, (method, rows) in enumerate(methods.items()):
            cuts = group(rows, "cut_m").values()
            axes.plot([100 * median(cut, "overlap") for cut in cuts],
                      [median(cut, name) for cut in cuts], color=COLOURS[method], lw=1.8)
            for rejected, fill in ((False, COLOURS[method]), (True, "none")):
                shown = [row for row in rows[::step] if (row["verdict"] == "rejected") == rejected]
                axes.plot([100 * row["overlap"] + 0.3 * shift for row in shown],
                          [row[name] for row in shown], "o", color=COLOURS[method], ms=3.5,
                          mfc=fill, mew=0.7)
        axes.set(title=dataset, ylabel=label, xlabel="overlap, %")
        log_scale(axes)
    dot = {"marker": "o", "ms": 4, "ls": ""}
    legend_below(figure, methods, [
        line("median", lw=1.8), line("rejected", mfc="none", **dot),
        line("one start" if step == 1 else f"one start in {step}", **dot)], 6)
    return figure


def inlier_curves(results):
    """Fig. 15: inliers against the distance that makes one, and the rate that is accepted."""
    thresholds = {dataset: median(rows, "inlier_threshold")
                  for dataset, rows in group(results["starts"], "dataset").items()}

    def draw(axes, _, rows, colour):
        mean, low, high = (100 * column(rows, f"inlier_ratio_{name}")
                           for name in ("mean", "q25", "q75"))
        axes.fill_between(column(rows, "threshold"), low, high, color=colour, alpha=0.15,
                          lw=0)
        axes.plot(column(rows, "threshold"), mean, color=colour, lw=1.8)

    figure, grid, methods = by_dataset(results["inliers"], draw, "inliers, %", sharey=True)
    needed, usual = {"color": "k", "lw": 1.2}, {"color": "k", "lw": 0.9, "ls": ":"}
    for dataset, axes in grid.items():
        if dataset not in thresholds:
            raise ReportError(f"starts.csv: no row for {dataset}")
        axes.axhline(100 * thresholds[dataset], **needed)
        axes.axvline(0.2, **usual)
        axes.set(xlabel="threshold, Mahalanobis distance", ylim=(0, 100))
    legend_below(figure, methods, [
        shade("middle half of the starts", alpha=0.3), line("least rate accepted (median)", **needed),
        line("threshold of the test, 0.2", **usual)], 4)
    return figure


def basin(dataset, of_set):
    """Where each method succeeds: starts within 0.6 m and 6 deg, over all turns at an offset."""
    methods = group(of_set, "method")
    figure, grid = panels(len(methods), across=4, height=2.5, sharey=True)
    dx, dy = (sorted({round(row[name], 3) for row in of_set}) for name in ("dx_m", "dy_m"))
    turns = max(len(rows) for rows in group(of_set, "method", "dx_m", "dy_m").values())
    for axes, (method, rows) in zip(grid, methods.items()):
        counts = np.zeros((len(dy), len(dx)), int)
        for row, good in zip(rows, within(rows, LOOSE)):
            counts[dy.index(round(row["dy_m"], 3)), dx.index(round(row["dx_m"], 3))] += good
        axes.imshow(counts, cmap="cividis", vmin=0, vmax=turns, origin="lower",
                    interpolation="nearest")
        for (y, x), cell in np.ndenumerate(counts):
            axes.text(x, y, cell, ha="center", va="center", fontsize=7,
                      color="k" if cell > 0.5 * turns else "w")
        axes.grid(False)
        axes.set_xticks(range(len(dx)), [f"{v:g}" for v in dx])
        axes.set_yticks(range(len(dy)), [f"{v:g}" for v in dy])
        axes.set(title=f"{NAMES.get(method, method)}: {counts.sum()}/{len(rows)}")
    figure.supxlabel(f"dx, m    ({dataset}: starts within 0.6 m and 6°, of {turns} turns at each"
                     " offset)", fontsize=8.5)
    figure.supylabel("dy, m", fontsize=8.5)
    figure.tight_layout()
    return figure


def merging_scatter(judged):
    """How sure the merged maps are, and how wrong, where the truth is known."""
    figure, grid, policies = by_dataset(judged, lambda axes, _, rows, colour: axes.plot(
        rows[0]["entropy_known"], rows[0]["log_loss"], "o", color=colour, ms=7),
        "log-loss against the truth, nats", "policy", height=2.4)
    for axes in grid.values():
        axes.margins(0.15)
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.set_xlabel("mean entropy of known voxels, nats")
    legend_below(figure, policies)
    return figure


def reliability_diagram(rows):
    """How often poses are right, by the probability that their matches stated."""
    figure, (axes,) = panels(1, height=3.2)
    axes.plot([0, 1], [0, 1], color="k", lw=0.8, ls=":")
    for of_range in group(by_probability(rows), "stated").values():
        stated = np.mean(column(of_range, "probability"))
        right = np.mean(within(of_range, LOOSE, "error_m", "error_deg"))
        axes.plot(stated, right, "o", color="#0072b2", ms=7)
        axes.annotate(f"{len(of_range)}", (stated, right), (6, -9), textcoords="offset points")
    axes.set_xlabel("stated probability, mean of a range")
    axes.set_ylabel("share of right poses")
    figure.tight_layout()
    return figure


def figures(results):
    """Names and figures, one at a time."""
    for dataset, rows in group(results["edge_iterations"], "dataset").items():
        yield f"fig10_{dataset}", iteration_curves(dataset, rows)
    for dataset, rows in group(results["overlap"], "dataset").items():
        yield f"fig11_{dataset}", overlap_scatter(dataset, rows)
    metres, degrees = zip(LOOSE, STRICT)
    yield "fig12_translation", boxes(results, "error_centre_m", "translation error, m", 1e-3,
                                     metres)
    yield "fig12_rotation", boxes(results, "error_paper_deg", "rotation error, °", 1e-2,
                                  degrees)
    yield "fig13", success_bars(results)
    yield "fig14", boxes(results, "mean_mahalanobis", "Mahalanobis distance")
    yield "fig15", inlier_curves(results)
    for dataset, rows in group(results["starts"], "dataset").items():
        yield f"fig_basin_{dataset}", basin(dataset, rows)
    yield "fig_reliability", reliability_diagram(results["verdicts"])
    yield "fig_time", time_bars(results)
    judged = [row for row in results["merging"] if not np.isnan(row["log_loss"])]
    if judged:
        yield "fig_merging", merging_scatter(judged)


def save(figure, stem):
    """Writes PNG and SVG without dates; the SVG also without needless decimals, names, spaces."""
    figure.savefig(f"{stem}.png", dpi=110, metadata={"Software": None})
    figure.savefig(f"{stem}.svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    plt.close(figure)
    text = Path(f"{stem}.svg").read_text(encoding="utf-8")
    for pattern, shorter in ((r"(\d\.\d)\d+", r"\1"), (r' id="[a-z0-9.]+_\d+"', ""),
                             (r"\n\s+", "\n"), (r"<g>\s*(<(?:use|path)[^>]*/>)\s*</g>", r"\1"),
                             (r"<g>\s*(<text.*?</text>)\s*</g>", r"\1")):
        text = re.sub(pattern, shorter, text)
    Path(f"{stem}.svg").write_text(text, encoding="utf-8")


def update_page(page, tables, folder):
    """Replaces the page's marked tables and copies the figures it links to."""
    def replaced(match):
        kind, name, end = match["kind"], match["name"], match["end"]
        if name not in tables:
            raise ReportError(f"{page}: unknown table in <!-- {kind} {name} -->")
        if not end:
            raise ReportError(f"{page}: <!-- {kind} {name} --> has no counterpart")
        return f"<!-- table {name} -->\n{tables[name][1]}\n{end}"

    text = page.read_text(encoding="utf-8")
    filled = re.sub(r"<!-- (?P<kind>table|end) (?P<name>\S+) -->"
                    r"(?:(?:(?!<!-- (?:table|end) ).)*(?P<end><!-- end (?P=name) -->))?",
                    replaced, text, flags=re.DOTALL)
    links = sorted(set(re.findall(r"\bbenchmarks/([\w.-]+\.svg)", text)))
    missing = [link for link in links if not (folder / link).is_file()]
    if missing:
        raise ReportError(f"{page}: no figure {', '.join(missing)}")
    for link in links:
        (page.parent / "benchmarks").mkdir(exist_ok=True)
        shutil.copyfile(folder / link, page.parent / "benchmarks" / link)
    page.write_text(filled, encoding="utf-8")


def report(folder, page):
    """Writes tables and figures into the folder, and the page if there is one."""
    results = read_results(folder)
    tables = all_tables(results)
    (folder / "tables.md").write_text("\n".join(
        f"## {name}\n\n{caption}\n\n{text}\n" for name, (caption, text) in tables.items()),
        encoding="utf-8")
    (folder / "figures").mkdir(exist_ok=True)
    for name, figure in figures(results):
        save(figure, folder / "figures" / name)
    if page:
        update_page(page, tables, folder / "figures")


def main():
    """The command line; 1 if something is missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, metavar="RESULTS_DIR", help="folder of CSV files")
    parser.add_argument("--page", type=Path, help="markdown page to put tables and figures into")
    arguments = parser.parse_args()
    plt.rcParams.update(STYLE)
    try:
        report(arguments.results, arguments.page)
    except (ReportError, OSError) as error:
        print(f"report.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
