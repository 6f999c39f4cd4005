# SPDX-License-Identifier: MIT
"""The macro-model in plain Python, as the command uses it for one answer: the same numbers, without Numba."""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest

from pysprings.core import jit
from pysprings.macro import solver
from pysprings.macro.predict import MacroModel
from pysprings.springs.checks import save_springs
from tests.support.commands import environment
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import make_springs


@pytest.fixture
def plain():
    """The solver once more, undecorated."""
    spec = importlib.util.spec_from_file_location("plain_solver", solver.__file__)
    module = importlib.util.module_from_spec(spec)
    before = jit.PLAIN.set(True)
    try:
        spec.loader.exec_module(module)
    finally:
        jit.PLAIN.reset(before)
    return module


@pytest.mark.parametrize("spring_set", ["full", "fan"])
def test_plain_python_says_the_same(plain, spring_set):
    springs = fan_springs(potential) if spring_set == "fan" else make_springs()
    model = MacroModel.from_springs(springs, spring_set)
    law = plain.FAN if spring_set == "fan" else plain.ROWS
    states = np.array([[1e-3, -1e-4], [-2e-3, 3e-4], [0.0, 0.0], [8e-3, -1e-3]])
    for state in states:
        force, tangent = np.zeros(2), np.zeros((2, 2))
        plain.reactions(plain.SpringArrays(law, *model.table.solver_arrays), *state, force, tangent)
        expected = model.reactions(*state)
        np.testing.assert_allclose(force, expected[0], rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(tangent, expected[1], rtol=1e-12, atol=1e-3)
    assert not hasattr(plain.reactions, "py_func")
    assert hasattr(solver.reactions, "py_func")


def test_which_commands_do_without_numba():
    before = jit.PLAIN.set(False)
    for arguments, plain in (
        (["predict", "x.nc", "--H", "1 MN"], True),
        (["--debug", "predict", "x.nc", "--u-max", "1 mm"], True),
        (["predict", "x.nc", "--points=5000"], False),
        (["predict", "x.nc", "--sequence", "s.csv"], False),
        (["compare", "predict"], False),
        (["run", "scene.toml"], False),
    ):
        jit.choose_for_command(arguments)
        assert jit.PLAIN.get() is plain, arguments
    jit.PLAIN.reset(before)


@pytest.mark.slow
def test_the_command_loads_no_numba_and_finds_the_same(tmp_path):
    file = save_springs(make_springs(), tmp_path / "springs.nc")
    code = (
        "import sys; from pysprings.cli.app import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "assert sys.modules.get('dask') is None and 'pint.registry' not in sys.modules\n"
        "from pysprings.core.units import read\n"
        "assert abs(read('1 ft', 'm') - 0.3048) < 1e-12 and 'pint.registry' in sys.modules\n"
        "print('numba' in sys.modules, file=sys.stderr)"
    )
    env = environment()
    command = [sys.executable, "-c", code, "predict", str(file), "--H", "1 MN", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, env=env, timeout=60, check=True)
    assert done.stderr.split()[-1] == "False"
    (state,) = json.loads(done.stdout)["states"]
    from pysprings.macro.predict import predict

    assert state["u"] == pytest.approx(float(predict(make_springs(), H=1e6)["u"]), rel=1e-9)
