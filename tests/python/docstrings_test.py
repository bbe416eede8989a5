# SPDX-License-Identifier: BSD-3-Clause
"""Runs the examples in the docstrings, and checks that everything public has a docstring."""
import doctest
import inspect
import os
import re
from pathlib import Path

import mrpt_fusion as mf
import numpy as np
import pytest


def documented():
    """Name and docstring of the module and of everything public in it."""
    yield "mrpt_fusion", mf.__doc__
    for name in mf.__all__:
        thing = getattr(mf, name)
        yield name, thing.__doc__
        if inspect.isclass(thing) and not issubclass(thing, tuple):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    if isinstance(value, staticmethod):
                        value = value.__func__
                    yield f"{name}.{member}", value.__doc__


@pytest.mark.parametrize("name, text", [pytest.param(*one, id=one[0]) for one in documented()])
def test_has_a_docstring_whose_examples_hold(name, text):
    assert text and text.strip(), f"{name} has no docstring"
    example = doctest.DocTestParser().get_doctest(text, {"mf": mf}, name, None, None)
    runner = doctest.DocTestRunner()
    output = []
    runner.run(example, out=output.append)
    assert runner.failures == 0, "".join(output)


def test_functions_begin_with_their_signature():
    for name in mf.__all__:
        if inspect.isroutine(getattr(mf, name)):
            assert getattr(mf, name).__doc__.startswith(f"{name}("), name


def test_the_example_of_the_readme_runs():
    readme = (Path(os.environ["SOURCE_DIR"]) / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.S)
    names = {"points": np.random.default_rng(1).normal(size=(100, 3)), "pose": np.eye(4)}
    exec(compile(code, "README.md", "exec"), names)
    assert Path("fused.ot").stat().st_size > 0 and names["team"].robots == ["r1"]
