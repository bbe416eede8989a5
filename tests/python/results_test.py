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
    assert defaults["VerdictModel"]["version"] == 2
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
    (lambda: mf.match("a.ot", "b.ot", np.eye(4), (1, 0)), mf.Error),
    (lambda: mf.match("a.ot", mf.MapBuilder().map()), mf.Error),
    (lambda: mf.fuse(["a.ot"]), ValueError),
    (lambda: mf.fuse({"a": "a.ot"}), ValueError),
    (lambda: mf.fuse([]), ValueError),
    (lambda: mf.load("a\0.ot"), (mf.Error, ValueError)),
    (lambda: mf.load_mission("a.ot"), mf.Error)])
def test_refuses_wrong_calls(call, fault):
    with pytest.raises(fault):
        call()


@pytest.mark.parametrize("call, message", [
    (lambda: mf.fuse("a.ot", "b.ot"), r"maps is a list or a dict: fuse\(\[a, b\]\)"),
    (lambda: mf.fuse(mf.load("a.ot"), mf.load("b.ot")), r"maps is a list or a dict: fuse\(\[a, b\]\)"),
    (lambda: mf.match("a.ot", "b.ot", guess="[1 2 0 30 0 0]"), "guess is a 4x4 matrix: .*"),
    (lambda: mf.fuse(["a.ot", "b.ot"], guess=mf.load("b.ot")), "guess is a 4x4 matrix: .*"),
    (lambda: mf.evaluate("a.ot", "b.ot", "T.txt"), "pose is a 4x4 matrix: .*"),
    (lambda: mf.merge("a.ot", "b.ot", {}), "pose is a 4x4 matrix: .*"),
    (lambda: mf.MapTeam().set("a", "a.ot", pose="here"), "pose is a 4x4 matrix: .*"),
    (lambda: mf.match("a.ot", "b.ot", np.eye(4), 3), "guess_sigma is a pair: .*"),
    (lambda: mf.match("a.ot", "b.ot", np.eye(4), (1, 2, 3)), "guess_sigma is a pair: .*")])
def test_says_what_an_argument_is(call, message):
    with pytest.raises(TypeError, match=f"^{message}$"):
        call()


@pytest.mark.parametrize("again", ["a.ot", "./a.ot", b"a.ot", "link.ot"])
def test_a_file_that_is_given_twice_counts_once(again):
    Path("link.ot").symlink_to("a.ot")
    name = again.decode() if isinstance(again, bytes) else again
    with pytest.warns(UserWarning, match=f"^{name}: is given twice, and counts once$"):
        result = mf.fuse(["a.ot", "b.ot", again])
    once = mf.fuse(["a.ot", "b.ot"])
    assert result.map.to_bytes() == once.map.to_bytes() and list(result.poses) == ["a", "b"]


def test_an_object_that_is_given_twice_counts_once():
    a, b = (mf.Map.from_bytes(Path(f"{name}.ot").read_bytes()) for name in "ab")
    with pytest.warns(UserWarning, match=r"^maps\[2\]: is given twice, and counts once$"):
        result = mf.fuse([a, b, a])
    assert result.map.to_bytes() == mf.fuse([a, b]).map.to_bytes()
    with pytest.warns(UserWarning, match="^a.ot: is given twice, and counts once$"):
        mf.fuse([mf.load("a.ot"), b, "a.ot"])
    with pytest.warns(UserWarning), pytest.raises(ValueError, match="at least two maps"):
        mf.fuse([a, a, a])


def test_reasons_have_a_sign(part_of):
    good, bad = mf.match("a.ot", "b.ot"), mf.evaluate("a.ot", "b.ot", np.eye(4))
    for match in (good, bad):
        verdict = match.figures()["match"]
        assert match.reasons_against == verdict["reasons_against"]
        assert match.reasons == verdict["reasons"]
        assert match.against == match.reasons[:match.reasons_against]
    assert good.reasons_against == 0 and 0 < bad.reasons_against <= len(bad.reasons)
    a = mf.load("a.ot")
    low, high = a.bounds
    c = part_of(a, low, [high[0] - 4, high[1], high[2]])
    lone = mf.Map.from_voxels([[x, y, 0] for x in range(9) for y in range(9)], np.ones(81), resolution=0.1)
    team = mf.fuse({"a": a, "lone": lone, "c": c})
    against = [f"{m.robot}: {reason}" for m in team.members for reason in m.reasons[:m.reasons_against]]
    assert any(reason.startswith("lone: ") for reason in against)
    assert team.reasons[:team.reasons_against] == team.against == against
    assert sorted(team.reasons) == sorted(f"{m.robot}: {r}" for m in team.members for r in m.reasons)
    assert mf.fuse(["a.ot", "b.ot"]).reasons_against == 0


def test_misspelt_options_name_the_nearest():
    with pytest.raises(mf.Error, match="'serch_yaw_deg'; the nearest is 'search_yaw_deg'$"):
        mf.match("a.ot", "b.ot", options={"serch_yaw_deg": 5})
    with pytest.raises(mf.Error, match=r"^\[VerdictModel\] .* 'log_overlp'; the nearest is 'log_overlap'$"):
        mf.MapTeam({"VerdictModel": {"log_overlp": 1}})
    with pytest.raises(mf.Error, match="'qqqqqq'$"):
        mf.match("a.ot", "b.ot", options={"qqqqqq": 5})
    Path("o.ini").write_text("[ProbabilisticMapMatching]\nkapa = 1\n")
    with pytest.raises(mf.Error, match="^o.ini: .* 'kapa'; the nearest is 'kappa'$"):
        mf.match("a.ot", "b.ot", options="o.ini")
    assert mf.match("a.ot", "b.ot", options={"KAPPA": 0.5}).accepted


@pytest.mark.parametrize("maps", ["a.ot", b"a.ot", Path("a.ot"), 1, None])
def test_names_what_fuse_takes(maps):
    with pytest.raises(TypeError, match=r"^maps is a list or a dict: fuse\(\[a, b\]\)$"):
        mf.fuse(maps)


def test_results_of_a_team_show_what_they_are(part_of):
    a = mf.load("a.ot")
    c = part_of(a, *(a.bounds + [[0, 0, 0], [-4, 0, 0]]))
    team = mf.fuse({"a": a, "b": mf.load("b.ot"), "c": c})
    first, second, _ = team.members
    assert repr(first) == "<mrpt_fusion.Member 'a', joined>"
    assert first.accepted and not first.ambiguous and first.reasons == first.against == []
    assert (first.pose == np.eye(4)).all() and first.probability is first.overlap is first.deviation is None
    figures = team.figures()["robots"]
    assert figures[0]["probability"] is None and figures[0]["pose"]["matrix"] == np.eye(4).tolist()
    assert figures[1]["probability"] == second.probability > 0.85
    assert repr(second).startswith("<mrpt_fusion.Member 'b', joined, matched with 'a', probability 0.")
    assert re.fullmatch(r"<mrpt_fusion.Pair 'a', 'b', holds, probability [0-9.]+>", repr(team.pairs[0]))
    best = mf.match(a, "b.ot").hypotheses[0]
    shown = re.fullmatch(r"<mrpt_fusion.Hypothesis, agreement (\S+), at \((.*)\) m, yaw (\S+) deg>",
                         repr(best))
    assert np.isclose(float(shown[1]), best.agreement, rtol=1e-4)
    assert np.allclose([float(x) for x in shown[2].split(",")], best.pose[:3, 3], atol=0.006)
    yaw = np.degrees(np.arctan2(best.pose[1, 0], best.pose[0, 0]))
    assert np.isclose(float(shown[3]), yaw, atol=0.06)


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
