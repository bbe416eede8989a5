# SPDX-License-Identifier: BSD-3-Clause
"""Matches, fusions, teams, and their pages."""
import html
import json
import re
import threading
import time
from pathlib import Path

import mrpt_fusion as mf
import numpy as np
import pytest


def error_of(pose, truth):
    """Errors of a pose: m, deg."""
    rotation = pose[:3, :3].T @ truth[:3, :3]
    angle = np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1)))
    return np.linalg.norm(pose[:3, 3] - truth[:3, 3]), angle


def test_finds_the_true_pose(truth):
    match = mf.match("a.ot", "b.ot")
    metres, degrees = error_of(match.pose, truth)
    assert match.accepted and metres < 0.1 and degrees < 1
    assert 0.9 < match.probability <= 1 and 0 < match.overlap < 1
    assert match.reasons and all(isinstance(reason, str) for reason in match.reasons)
    covariance = match.covariance
    assert np.allclose(covariance, covariance.T) and (np.linalg.eigvalsh(covariance) > 0).all()
    assert match.hypotheses[0].agreement >= match.hypotheses[-1].agreement


def test_a_map_that_is_prepared_once_gives_the_same_result():
    a, b = mf.load("a.ot"), mf.load("b.ot")
    first, second = mf.match(a, b), mf.match(a, b)
    other = mf.match(a, b, options={"voxel_spacing": 0.4})
    third = mf.match(a, b)
    assert (first.pose == second.pose).all() and (first.pose == third.pose).all()
    assert (first.pose != other.pose).any()


def test_rejects_wrong_places_and_merges_nothing(part_of):
    a = mf.load("a.ot")
    low, high = a.bounds
    half = low[0] + (high[0] - low[0]) / 2
    left, right = part_of(a, low, [half - 3, high[1], high[2]]), part_of(a, [half + 3, low[1], low[2]], high)
    result = mf.fuse({"left": left, "right": right})
    assert not result.accepted and result.map is None and result.poses == {}
    assert result.reasons and result.pose.shape == (4, 4)
    wrong = np.eye(4)
    assert not mf.evaluate("a.ot", "b.ot", wrong).accepted
    assert mf.merge("a.ot", "b.ot", wrong).nodes > 0


def test_files_of_one_name_are_named_by_their_folders(tmp_path):
    for folder, file in [("one", "a.ot"), ("two", "b.ot")]:
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "map.ot").write_bytes(Path(file).read_bytes())
    result = mf.fuse([tmp_path / "one" / "map.ot", tmp_path / "two" / "map.ot"])
    assert result.accepted and list(result.poses) == ["one_map", "two_map"]


def test_copies_count_once():
    with pytest.warns(UserWarning, match="map B"):
        merged = mf.merge("a.ot", "a.ot", np.eye(4))
    assert merged.to_bytes() == Path("a.ot").read_bytes()


def test_a_team_is_that_of_fuse_while_its_maps_change(part_of):
    a = mf.load("a.ot")
    low, high = a.bounds
    c = part_of(a, low, [high[0] - 4, high[1], high[2]])
    maps = {"a": a, "b": mf.load("b.ot"), "c": c}
    team = mf.MapTeam()
    for robot in ("a", "c", "b"):
        team.set(robot, maps[robot])
    state = team.state()
    assert team.state() is state
    fused = mf.fuse({robot: maps[robot] for robot in team.robots})
    assert state.map.to_bytes() == fused.map.to_bytes()
    assert [m.robot for m in state.members] == ["a", "c", "b"]
    for ours, theirs in zip(state.members, fused.members):
        assert (ours.pose == theirs.pose).all() and ours.reasons == theirs.reasons
    assert len(state.pairs) == 3
    assert team.remove("c") and not team.remove("c")
    assert [m.robot for m in team.state().members] == ["a", "b"]
    assert len(state.members) == 3
    with pytest.raises(mf.Error, match="^d: the map has no occupied voxel"):
        team.set("d", mf.MapBuilder().map())


def test_poses_are_guesses_of_a_team(truth, part_of):
    a = mf.load("a.ot")
    c = part_of(a, *(a.bounds + [[0, 0, 0], [-4, 0, 0]]))
    maps = {"a": a, "b": mf.load("b.ot"), "c": c}
    team = mf.fuse(maps, poses={"a": np.eye(4), "b": truth, "c": np.eye(4)})
    assert team.accepted and error_of(team.poses["b"], truth)[0] < 0.1
    with pytest.raises(ValueError, match="no map 'x'"):
        mf.fuse(maps, poses={"x": truth})
    with pytest.raises(ValueError, match="two maps"):
        mf.fuse(maps, guess=truth)


def embedded(result):
    """The page in the frame that a notebook shows."""
    frame = result._repr_html_()
    assert frame.startswith("<iframe ") and frame.endswith("></iframe>")
    return html.unescape(re.search('srcdoc="([^"]*)"', frame).group(1))


def test_pages_have_the_figures_of_the_result():
    a, result = mf.load("a.ot"), mf.fuse(["a.ot", "b.ot"])
    for one in (a, result, result.match):
        one.save_page("page.html")
        page = Path("page.html").read_text(encoding="utf-8")
        assert embedded(one) == page and page.startswith("<!")
    result.save_page("page.html")
    page = Path("page.html").read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="report">(.*?)</script>', page, re.S)
    assert json.loads(found.group(1)) == json.loads(json.dumps(result.figures()))


def test_options_are_those_of_the_settings_file():
    defaults = mf.default_options()
    text = "[ProbabilisticMapMatching]\n"
    text += "".join(f"{k} = {v}\n" for k, v in defaults.items() if not isinstance(v, dict))
    Path("o.ini").write_text(text)
    match = mf.match("a.ot", "b.ot", options="o.ini")
    assert (match.pose == mf.match("a.ot", "b.ot", options=defaults).pose).all()
    assert defaults["VerdictModel"]["version"] == 1
    model = {"VerdictModel": {**defaults["VerdictModel"], "constant": -99}}
    assert not mf.match("a.ot", "b.ot", options=model).accepted


@pytest.mark.parametrize("options, fault", [
    ({"kappa": "much"}, mf.Error), ({"kappa": -1}, mf.Error), ({"kappa": None}, TypeError),
    ({"kappa": [1]}, (TypeError, ValueError)), ({"kap pa": 1}, ValueError), ({1: 1}, (mf.Error, ValueError)),
    ({"kappa": "0.5\n[x]"}, ValueError), ({"x": {"y": 1}}, TypeError), ("missing.ini", mf.Error),
    ("a.ot", mf.Error)])
def test_refuses_unknown_and_senseless_options(options, fault):
    with pytest.raises(fault):
        mf.match("a.ot", "b.ot", options=options)


@pytest.mark.parametrize("call, fault", [
    (lambda: mf.match("a.ot"), TypeError),
    (lambda: mf.match(1, 2), TypeError),
    (lambda: mf.match("a.ot", "b.ot", np.eye(3)), ValueError),
    (lambda: mf.match("a.ot", "b.ot", guess_sigma=(1, 1)), ValueError),
    (lambda: mf.match("a.ot", "b.ot", np.eye(4), (-1, 1)), mf.Error),
    (lambda: mf.match("a.ot", mf.MapBuilder().map()), mf.Error),
    (lambda: mf.fuse(["a.ot"]), ValueError),
    (lambda: mf.fuse(["a.ot", "a.ot"]), ValueError),
    (lambda: mf.fuse("ab"), mf.Error),
    (lambda: mf.fuse([]), ValueError),
    (lambda: mf.load("a\0.ot"), (mf.Error, ValueError)),
    (lambda: mf.load_mission("a.ot"), mf.Error)])
def test_refuses_wrong_calls(call, fault):
    with pytest.raises(fault):
        call()


def test_other_threads_run_while_maps_are_matched():
    done, steps = threading.Event(), []

    def count():
        while not done.is_set():
            steps.append(time.perf_counter())
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    begin = time.perf_counter()
    for _ in range(3):
        mf.match("a.ot", "b.ot")
    end = time.perf_counter()
    done.set()
    counter.join()
    longest = max(np.diff([begin] + [s for s in steps if begin < s < end] + [end]))
    assert longest < (end - begin) / 4


def test_threads_share_maps():
    a, b = mf.load("a.ot"), mf.load("b.ot")
    poses = []
    threads = [threading.Thread(target=lambda: poses.append(mf.match(a, b).pose)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(poses) == 4 and all((pose == poses[0]).all() for pose in poses)
