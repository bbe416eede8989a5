# SPDX-License-Identifier: BSD-3-Clause
"""Maps from point clouds."""
import warnings

import mrpt_fusion as mf
import numpy as np
import octomap_twin
import pytest


def scan(seed):
    """Points of a ball around a sensor, with a few that are far away or equal."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(3000, 3))
    points *= random.uniform(0.5, 4, (3000, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    return np.concatenate([points, points[:50], [[30, 0, 0]]])


def pose(seed):
    random = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(random.normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, random.uniform(-3, 3, 3)
    return matrix


@pytest.mark.parametrize("max_range", [-1, 3.5])
def test_has_the_bits_of_octomap(max_range):
    builder = mf.MapBuilder(0.1, {"maxrange": max_range})
    twins = []
    for seed in range(4):
        points, sensor = scan(seed), pose(seed + 10)
        builder.insert(points, sensor)
        in_map = (points @ sensor[:3, :3].T + sensor[:3, 3]).astype(np.float32)
        twins.append((in_map, sensor[:3, 3].tolist()))
    ours = mf.Map.from_bytes(builder.map().to_bytes())
    assert ours.to_bytes() == octomap_twin.insert(twins, 0.1, max_range)


def test_grows_without_changing_maps_that_it_gave():
    builder = mf.MapBuilder(0.1)
    empty = builder.map()
    builder.insert(scan(1))
    one = builder.map()
    size = one.nodes
    builder.insert(scan(2), pose(3))
    assert empty.nodes == 0 and one.nodes == size < builder.map().nodes


def test_scans_make_the_same_map():
    builder = mf.MapBuilder(0.2, {"maxrange": 3})
    scans = [(scan(1), None), (scan(2), pose(2))]
    for points, sensor in scans:
        builder.insert(points, sensor)
    made = mf.Map.from_scans(iter(scans), 0.2, {"maxrange": 3})
    assert made.to_bytes() == builder.map().to_bytes()


def test_without_rays_no_space_becomes_free():
    builder = mf.MapBuilder(0.1)
    builder.insert(scan(1), rays=False)
    assert len(builder.map().voxels("free").centres) == 0
    assert len(builder.map().voxels().centres) > 1000


def test_leaves_out_points_that_are_not_numbers():
    builder = mf.MapBuilder(0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        builder.insert([[np.nan, 0, 0], [np.inf, 0, 0], [1, 0, 0]])
        builder.insert(np.zeros((0, 3)))
    assert len(builder.map().voxels().centres) == 1


LIMIT = 3276.8  # m, at voxels of 0.1 m


@pytest.mark.parametrize("rays", [False, True])
def test_warns_of_points_outside_of_the_grid(rays):
    builder = mf.MapBuilder(0.1)
    points = [[1, 0, 0], [LIMIT - 0.05, 0, 0], [0, LIMIT + 0.05, 0], [0, 0, -LIMIT - 0.05], [1e30, 0, 0]]
    with pytest.warns(UserWarning, match="^3 points are left out: outside of the grid .* 3276.8 m"):
        builder.insert(points, rays=rays)
    assert len(builder.map().voxels().centres) == 2
    with pytest.warns(UserWarning, match="^1 point is left out"):
        builder.insert([[2, 0, 0]] + points[3:4], rays=rays)


def test_warns_once_of_all_scans():
    far = [[5000, 0, 0], [1, 1, 1]]
    with pytest.warns(UserWarning) as warned:
        mf.Map.from_scans([(far, None), (far, np.eye(4))], 0.1)
    assert [str(w.message) for w in warned] == [
        "2 points are left out: outside of the grid of the map, which ends 3276.8 m from the origin"]


def test_beams_that_end_at_the_largest_range_leave_no_point_out():
    builder = mf.MapBuilder(0.1, {"maxrange": 3})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        builder.insert([[5000, 0, 0]])
    assert len(builder.map().voxels("free").centres) > 0


def test_refuses_a_sensor_outside_of_the_grid():
    builder = mf.MapBuilder(0.1)
    far = np.eye(4)
    far[1, 3] = 4000
    with pytest.raises(mf.Error, match="^the sensor is outside of the grid .* 3276.8 m"):
        builder.insert([[0, -2000, 0]], far)
    assert builder.map().nodes == 0
    builder.insert([[0, -2000, 0]], far, rays=False)
    assert len(builder.map().voxels().centres) == 1


@pytest.mark.parametrize("scans", [
    [np.zeros((5, 3))], [np.zeros((2, 3))], [[[1, 0, 0], [0, 2, 0]]], (np.zeros((5, 3)), np.eye(4)),
    [1], [(np.zeros((5, 3)), np.eye(4), 0.1)], ["ab"]])
def test_names_what_a_scan_is(scans):
    with pytest.raises(TypeError, match=r"^each scan is a pair \(points, pose\)$"):
        mf.Map.from_scans(scans, 0.1)


@pytest.mark.parametrize("arguments, fault", [
    (([[1, 2]],), ValueError),
    (([[1, 2, 3]], np.eye(3)), ValueError),
    (([[1, 2, 3]], 2 * np.eye(4)), ValueError),
    (([[1, 2, 3]], np.full((4, 4), np.nan)), ValueError),
    (("points",), (TypeError, ValueError)),
])
def test_refuses_what_are_no_points(arguments, fault):
    with pytest.raises(fault):
        mf.MapBuilder(0.1).insert(*arguments)


def test_refuses_unknown_options():
    with pytest.raises(mf.Error, match="unknown key 'max_range'; the nearest is 'maxrange'$"):
        mf.MapBuilder(0.1, {"max_range": 3})
    with pytest.raises(mf.Error):
        mf.MapBuilder(0)
