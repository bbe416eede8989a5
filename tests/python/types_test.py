# SPDX-License-Identifier: BSD-3-Clause
"""The type stubs know all of the module, and nothing else."""
import ast
import inspect
import subprocess
import sys
from pathlib import Path

import mrpt_fusion as mf

STUB = Path(mf.__file__).with_suffix(".pyi")
USE = """
import mrpt_fusion as mf
import numpy as np

m = mf.match(mf.load("a.ot"), "b.ot", np.eye(4), (1, 5), options={"kappa": 0.5})
if m.accepted:
    merged = mf.merge("a.ot", "b.ot", m.pose)
    merged.save("fused.ot")
fusion = mf.fuse({"a": "a.ot", "b": mf.load("b.ot")})
if fusion.map:
    centres = fusion.map.voxels("all").centres[:, 0]
team = mf.MapTeam()
team.set("r1", mf.Map.from_scans([(np.zeros((3, 3)), None)], 0.1))
cloud = mf.load("cloud.pcd", resolution=0.2, sensor_origin=(0, 0, 1))
both = mf.fuse([cloud, mf.Map.from_bytes(bytearray(b""))], independent=True)
told = both.reasons[:both.reasons_against] + m.reasons[m.reasons_against:] + [mf.__version__]
names = [member.robot.upper() for member in team.state().members]
"""


def test_stubs_name_what_the_module_has():
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert {name for name in classes if not name.startswith("_")} | functions == set(mf.__all__)

    def members(node):
        own = {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
        return own.union(*(members(classes[base.id]) for base in node.bases if base.id in classes))

    for name in mf.__all__:
        thing = getattr(mf, name)
        if inspect.isclass(thing) and not issubclass(thing, (tuple, Exception)):
            in_module = {m for m in vars(thing) if not m.startswith("_")}
            assert {m for m in members(classes[name]) if not m.startswith("_")} == in_module, name


def test_signatures_of_docstrings_are_those_of_the_stubs():
    """By names and defaults of the parameters."""
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    for node in (n for n in tree.body if isinstance(n, ast.FunctionDef)):
        said = getattr(mf, node.name).__doc__.splitlines()[0].split(" -> ")[0]
        documented = ast.parse(f"def {said}: ...").body[0].args
        assert [a.arg for a in documented.args] == [a.arg for a in node.args.args], node.name
        assert [a.arg for a in documented.kwonlyargs] == [a.arg for a in node.args.kwonlyargs], node.name
        assert len(documented.defaults) == len(node.args.defaults), node.name


def test_mypy_accepts_stubs_and_a_program_that_uses_them():
    Path("use.py").write_text(USE, encoding="utf-8")
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir=cache", "use.py"],
                         check=False, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout
    Path("use.py").write_text(USE + "mf.match(1, 2)\n", encoding="utf-8")
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir=cache", "use.py"],
                         check=False, capture_output=True, text=True)
    assert run.returncode == 1
