# SPDX-License-Identifier: BSD-3-Clause
"""The module gives the bits of the command line."""
import json
import os
import subprocess
from pathlib import Path

import mrpt_fusion as mf
import numpy as np
import pytest


def without_times(report):
    """The figures of a run, without those that differ from run to run."""
    for key in ("seconds", "tool", "version"):
        report.pop(key, None)
    for one in report["maps"]:
        one.pop("path")
    return report


def test_fuses_two_maps_to_the_same_file(map_fusion):
    assert map_fusion("fuse", "a.ot", "b.ot", "-o", "cli.ot", "--json", "cli.json") == 0
    result = mf.fuse(["a.ot", "b.ot"])
    result.map.save("python.ot")
    assert Path("python.ot").read_bytes() == Path("cli.ot").read_bytes()
    assert without_times(result.figures()) == without_times(json.loads(Path("cli.json").read_text()))


def test_saves_the_same_mrpt_object_with_its_sources(map_fusion):
    map_fusion("fuse", "a.ot", "b.ot", "-o", "cli.mrpt")
    mf.fuse(["a.ot", "b.ot"]).map.save("python.mrpt")
    assert Path("python.mrpt").read_bytes() == Path("cli.mrpt").read_bytes()
    assert len(mf.load("python.mrpt").sources) == 2


def test_matches_near_a_guess(map_fusion, truth):
    guess = truth.copy()
    guess[:3, 3] += [0.6, -0.4, 0]
    np.savetxt("guess.txt", guess, fmt="%.17g")
    for sigma in (None, (0.5, 4)):
        arguments = [] if sigma is None else ["--init-sigma", *sigma]
        assert map_fusion("match", "a.ot", "b.ot", "--init", "guess.txt", *arguments, "--json",
                          "cli.json") == 0
        match = mf.match("a.ot", "b.ot", guess, sigma)
        cli = json.loads(Path("cli.json").read_text())
        assert without_times(match.figures()) == without_times(cli)
        assert match.pose.tolist() == cli["pose"]["matrix"]


def test_takes_the_options_of_the_settings_file(map_fusion):
    options = {"merge_policy": "average", "voxel_spacing": 0.3, "search_hypotheses": 5}
    Path("o.ini").write_text("[ProbabilisticMapMatching]\n" +
                             "".join(f"{key} = {value}\n" for key, value in options.items()))
    assert map_fusion("fuse", "a.ot", "b.ot", "--config", "o.ini", "-o", "cli.ot") == 0
    for given in (options, "o.ini", Path("o.ini")):
        result = mf.fuse(["a.ot", "b.ot"], options=given)
        assert result.map.to_bytes() == Path("cli.ot").read_bytes()
    assert mf.fuse(["a.ot", "b.ot"]).map.to_bytes() != Path("cli.ot").read_bytes()


def test_evaluates_and_merges_at_a_pose_from_a_file(map_fusion):
    map_fusion("match", "a.ot", "b.ot", "--pose-out", "T.txt")
    assert map_fusion("evaluate", "a.ot", "b.ot", "--pose", "T.txt", "--json", "cli.json") == 0
    assert map_fusion("merge", "a.ot", "b.ot", "--pose", "T.txt", "-o", "cli.ot") == 0
    pose = np.loadtxt("T.txt")
    judged = mf.evaluate("a.ot", "b.ot", pose)
    assert without_times(judged.figures()) == without_times(json.loads(Path("cli.json").read_text()))
    assert mf.merge("a.ot", "b.ot", pose).to_bytes() == Path("cli.ot").read_bytes()


def test_fuses_a_team(map_fusion, part_of):
    a = mf.load("a.ot")
    low, high = a.bounds
    part_of(a, low, [high[0] - 4, high[1], high[2]]).save("c.ot")
    code = map_fusion("fuse", "a.ot", "b.ot", "c.ot", "-o", "cli.ot", "--json", "cli.json")
    team = mf.fuse(["a.ot", "b.ot", "c.ot"])
    assert team.accepted == (code == 0)
    assert team.map.to_bytes() == Path("cli.ot").read_bytes()
    assert without_times(team.figures()) == without_times(json.loads(Path("cli.json").read_text()))
    assert [m.joined for m in team.members] == [True, True, True] and len(team.pairs) == 3


def test_a_map_and_itself_are_the_map(map_fusion):
    code = map_fusion("fuse", "a.ot", "a.ot", "-o", "cli.ot", "--json", "cli.json")
    for maps in (["a.ot", "a.ot"], [mf.load("a.ot"), "a.ot"]):
        with pytest.warns(UserWarning, match="^a.ot: is given twice, and counts once$"):
            result = mf.fuse(maps)
        assert result.accepted == (code == 0)
        assert result.map.to_bytes() == Path("cli.ot").read_bytes() == Path("a.ot").read_bytes()
        cli = json.loads(Path("cli.json").read_text())
        assert "same voxels" in cli.pop("notes")[0]
        assert without_times(result.figures()) == without_times(cli)


def test_independent_maps_all_count(map_fusion):
    Path("copy.ot").write_bytes(Path("a.ot").read_bytes())
    for maps in (["a.ot", "copy.ot"], ["a.ot", "copy.ot", "b.ot"]):
        assert map_fusion("fuse", *maps, "--independent", "-o", "cli.ot") == 0
        fused = mf.fuse(maps, independent=True).map.to_bytes()
        assert fused == Path("cli.ot").read_bytes() != mf.fuse(maps).map.to_bytes()
    assert map_fusion("merge", "a.ot", "copy.ot", "--pose", "[0 0 0 0 0 0]", "--independent", "-o",
                      "cli.ot") == 0
    merged = mf.merge("a.ot", "copy.ot", np.eye(4), independent=True)
    assert merged.to_bytes() == Path("cli.ot").read_bytes() != Path("a.ot").read_bytes()


def test_has_the_version_of_the_command_line():
    run = subprocess.run([os.environ["MAP_FUSION"], "--version"], check=True, capture_output=True, text=True)
    assert run.stdout == f"map-fusion {mf.__version__}\n"


def test_loads_missions(map_fusion):
    assert map_fusion("pack", "a.ot", "b.ot", "-o", "mission.rawlog") == 0
    mission = mf.load_mission("mission.rawlog")
    assert list(mission) == ["a", "b"]
    assert mission["a"].to_bytes() == Path("a.ot").read_bytes()
    assert map_fusion("fuse", "mission.rawlog", "-o", "cli.ot") == 0
    assert mf.fuse(mission).map.to_bytes() == Path("cli.ot").read_bytes()


def test_matches_edges_alone(map_fusion):
    map_fusion("edges", "b.ot", "-o", "edges.mrpt")
    assert map_fusion("match", "a.ot", "edges.mrpt", "--json", "cli.json") == 3
    match = mf.match("a.ot", "edges.mrpt")
    assert match.by_edges and not match.accepted
    assert without_times(match.figures()) == without_times(json.loads(Path("cli.json").read_text()))
