# SPDX-License-Identifier: BSD-3-Clause
"""Maps from and to files, bytes, pickles and arrays."""
import gzip
import pickle
import time
from pathlib import Path

import mrpt_fusion as mf
import numpy as np
import pytest


def test_keeps_all_bits_in_bytes_files_and_pickles():
    a = mf.load("a.ot")
    original = Path("a.ot").read_bytes()
    assert a.to_bytes() == original
    assert mf.Map.from_bytes(original).to_bytes() == original
    for data in (bytearray(original), memoryview(original), np.frombuffer(original, np.uint8)):
        assert mf.Map.from_bytes(data).to_bytes() == original
    with pytest.raises(TypeError):
        mf.Map.from_bytes("a.ot")
    again = pickle.loads(pickle.dumps(a))
    assert again.to_bytes() == original and again.sources == a.sources
    a.save("a.mrpt")
    assert mf.load("a.mrpt").to_bytes() == original


def test_writes_and_reads_maximum_likelihood():
    a = mf.load("a.ot")
    a.save("a.bt")
    assert Path("a.bt").read_bytes() == a.to_bytes("bt")
    likely = mf.load(b"a.bt")
    assert set(np.sign(likely.voxels("all").log_odds)) == {-1, 1}
    with pytest.raises(ValueError):
        a.to_bytes("ply")


def test_reads_data_without_a_header():
    a = mf.load("a.ot")
    data = Path("a.ot").read_bytes().split(b"data\n", 1)[1]
    with pytest.raises(mf.Error):
        mf.Map.from_bytes(data)
    assert mf.Map.from_bytes(data, resolution=0.1).to_bytes() == a.to_bytes()


def test_separates_occupied_from_free_space():
    a = mf.load("a.ot")
    occupied, free, both = (a.voxels(space) for space in ("occupied", "free", "all"))
    assert (occupied.log_odds >= 0).all() and (free.log_odds < 0).all()
    assert len(occupied.centres) + len(free.centres) == len(both.centres)
    assert both.sizes.min() == np.float32(0.1) and both.sizes.max() > 0.15
    low, high = a.bounds
    assert (both.centres > low).all() and (both.centres < high).all()
    with pytest.raises(ValueError):
        a.voxels("unknown")


def test_answers_the_probability_at_points():
    a = mf.load("a.ot")
    voxels = a.voxels("all")
    expected = 1 - 1 / (1 + np.exp(voxels.log_odds.astype(float)))
    assert np.allclose(a.probability_at(voxels.centres), expected, atol=1e-6)
    assert np.isnan(a.probability_at([[1e9, 0, 0], [0, 0, 3000]])).all()


def test_makes_the_same_map_of_its_cubes_in_any_order():
    a = mf.load("a.ot")
    voxels = a.voxels("all")
    order = np.random.default_rng(1).permutation(len(voxels.centres))
    again = mf.Map.from_voxels(*(values[order] for values in voxels), resolution=0.1)
    assert again.to_bytes() == a.to_bytes()


def test_takes_lists_and_other_types_of_arrays():
    m = mf.Map.from_voxels([[0, 0, 0], (1, 0, 0)], np.array([1, -2], dtype=np.int64), resolution=0.5)
    assert m.voxels("all").log_odds.tolist() == [1, -2]
    flipped = np.asfortranarray(mf.load("a.ot").voxels().centres)
    m = mf.Map.from_voxels(flipped[:, ::-1], np.ones(len(flipped)), resolution=0.1)
    assert len(m.voxels().centres) > 1000


@pytest.mark.parametrize("arguments, fault", [
    (([[0, 0]], [1]), ValueError),
    (([[0, 0, 0]], [1, 2]), mf.Error),
    (([[0, 0, 0]], [[1]]), ValueError),
    (([[0, 0, 0], [0, 0, 0]], [1, 2]), mf.Error),
    (([[0, 0, np.nan]], [1]), mf.Error),
    (([[0, 0, 0]], [np.inf]), mf.Error),
    (([[0, 0, 0]], [1], [0.15]), mf.Error),
])
def test_refuses_cubes_that_are_no_map(arguments, fault):
    with pytest.raises(fault):
        mf.Map.from_voxels(*arguments, resolution=0.1)


def test_arrays_outlive_their_map():
    centres = mf.load("a.ot").voxels().centres
    copy = centres.copy()
    mf.load("b.ot").voxels()
    assert (centres == copy).all()


def test_gives_five_million_voxels_to_numpy_within_a_third_of_a_second():
    side = 171
    keys = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
    log_odds = np.random.default_rng(3).uniform(0.1, 3.5, len(keys)).astype(np.float32)
    m = mf.Map.from_voxels((keys + 0.5) * 0.1, log_odds, resolution=0.1)
    seconds = []
    for _ in range(5):
        start = time.process_time()  # of all threads: other programs do not count
        voxels = m.voxels()
        seconds.append(time.process_time() - start)
    assert len(voxels.centres) == side ** 3
    assert min(seconds) < 0.3


@pytest.mark.parametrize("contents", [b"", b"no map", b"# Octomap OcTree file\nid OcTree\n",
                                      gzip.compress(b"x" * 1000), bytes(range(256)) * 9])
def test_names_the_file_that_is_no_map(contents):
    Path("bad.ot").write_bytes(contents)
    with pytest.raises(mf.Error, match="^bad.ot: ") as error:
        mf.load("bad.ot")
    assert "\n" not in str(error.value)
    with pytest.raises(mf.Error):
        mf.Map.from_bytes(contents)


def test_refuses_truncated_maps_and_keeps_existing_files():
    data = Path("a.ot").read_bytes()
    for size in (100, len(data) // 2, len(data) - 1):
        with pytest.raises(mf.Error):
            mf.Map.from_bytes(data[:size])
    Path("folder").mkdir()
    with pytest.raises(mf.Error):
        mf.load("a.ot").save("folder/missing/x.ot")
    assert not list(Path("folder").iterdir())


def test_builds_maps_from_recordings(map_fusion):
    import os
    recording = Path(os.environ["PAIR_DIR"]) / "robot_a.rawlog"
    assert mf.load(recording).to_bytes() == Path("a.ot").read_bytes()
    Path("map.ini").write_text("[MappingApplication]\nprobOctoMap_count = 1\n"
                               "[MappingApplication_probOctoMap_00_creationOpts]\nresolution = 0.4\n")
    assert mf.load(recording, config="map.ini").resolution == 0.4
    with pytest.raises(mf.Error, match=r"^a.ot: has no section \[MappingApplication\]"):
        mf.load(recording, config="a.ot")


def write_cloud(path, points, viewpoint="0 0 0 1 0 0 0"):
    """Writes a point cloud of PCL."""
    Path(path).write_text("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
                          f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT {viewpoint}\n"
                          f"POINTS {len(points)}\nDATA ascii\n" +
                          "".join("{} {} {}\n".format(*p) for p in points))


def test_loads_point_clouds_with_their_resolution_and_sensor():
    write_cloud("c.pcd", [[2.1, 0.1, 0.1], [0.1, 2.1, 0.1]])
    with pytest.warns(UserWarning, match="no free space"):
        assert mf.load("c.pcd").resolution == 0.1
    with pytest.warns(UserWarning, match="no free space"):
        m = mf.load("c.pcd", resolution=0.2)
    assert m.resolution == 0.2 and len(m.voxels("free").centres) == 0
    assert np.allclose(m.probability_at([[2.1, 0.1, 0.1]]), 0.7) and len(m.voxels().centres) == 2
    for origin in ([0.1, 0.1, 0.1], np.full(3, 0.1)):
        m = mf.load("c.pcd", resolution=0.2, sensor_origin=origin)
        assert m.probability_at([[1.1, 0.1, 0.1]]) < 0.5 < m.probability_at([[2.1, 0.1, 0.1]])


@pytest.mark.parametrize("arguments, fault", [
    ({"resolution": 0}, mf.Error), ({"resolution": "0.1 m"}, TypeError), ({"sensor_origin": [1, 2]}, ValueError),
    ({"sensor_origin": [1, 2, np.nan]}, ValueError), ({"sensor_origin": [[1, 2, 3]]}, ValueError),
    ({"sensor_origin": [1e6, 0, 0]}, mf.Error)])
def test_refuses_senseless_settings_of_point_clouds(arguments, fault):
    write_cloud("c.pcd", [[1, 0, 0]])
    with pytest.raises(fault):
        mf.load("c.pcd", **arguments)


@pytest.mark.parametrize("extension", [".ply", ".pcd", ".png", ".pgm", ".jpg", ".PLY"])
def test_writes_no_object_under_the_name_of_another_format(extension):
    with pytest.raises(mf.Error) as error:
        mf.load("a.ot").save("x" + extension)
    assert str(error.value) == (f"x{extension}: a map cannot be written as {extension.lower()}: "
                                "use .ot, .bt or .gridmap")
    assert not Path("x" + extension).exists()
    mf.load("a.ot").save("x.gridmap")
    assert mf.load("x.gridmap").to_bytes() == Path("a.ot").read_bytes()


def test_a_map_knows_the_hash_of_its_voxels(map_fusion):
    assert map_fusion("fuse", "a.ot", "b.ot", "-o", "cli.mrpt") == 0
    expected = {source["map"]: source["content_hash"] for source in mf.load("cli.mrpt").sources}
    for name in "ab":
        (source,) = mf.load(f"{name}.ot").sources
        assert source == {"robot": "", "map": name, "sequence": 0, "content_hash": expected[name]}
    assert expected["a"] != expected["b"] and 0 not in expected.values()
    map_fusion("edges", "b.ot", "-o", "edges.mrpt")
    assert all("content_hash" not in source for source in mf.load("edges.mrpt").sources)
