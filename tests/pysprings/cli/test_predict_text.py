# SPDX-License-Identifier: MIT
"""All that `predict` and `compare` print, with their warnings and notes, in the stored texts."""

import warnings
from pathlib import Path

import pytest
import xarray as xr

from pysprings.core.text import percent
from pysprings.macro.predict import predict
from pysprings.springs.checks import save_springs
from tests.support import stored, synthetic, vertical
from tests.support.commands import command
from tests.support.fans import fan_springs, potential

FAN = (
    synthetic.Path("push", "translation", size=8e-3, steps=8),
    synthetic.Path("turn", "rotation", size=2e-3, steps=8),
    synthetic.Path("back", "rotation", size=-2e-3, steps=8),
    synthetic.Path("check", arm=6.0, role="held-back", steps=8),
)
TABLE = "depth_m,depth_top_m,depth_bottom_m,y_m,p_N_per_m\n" + "".join(
    f"{z},{z - 1},{z + 1},{y},{p}\n"
    for z in (1.0, 3.0)
    for y, p in ((0.0, 0.0), (1e-3, 1e5), (2e-3, 1.5e5), (4e-3, 5e4))
)
QUESTIONS = (
    "predict one.nc --H 300kN --arm 8m --stiffness",
    "predict one.nc --H 20MN",
    "predict one.nc --H 20MN --extrapolate",
    "predict one.nc --u-max 4mm --points 4 --stiffness --springs py",
    "predict one.nc --u-max 4mm --points 4 --stiffness --springs py --extrapolate",
    "predict fan.nc --H 1MN --arm 2m --stiffness",
    "predict fan.nc --u 1mm --rotation 1mrad",
    "predict fan.nc --H -500kN --M -3MNm",
    "predict down.nc --V 6MN",
    "predict down.nc --V 60MN",
    "predict down.nc --H 1MN --V 3MN --stiffness",
    "predict py.csv --H 100kN --arm 1m --stiffness",
    "predict py.csv --u 3mm --rotation 0mrad",
    "predict fan.nc --sequence loads.csv",
    "compare one.nc",
    "compare fan.nc --springs fan",
    "compare down.nc",
)


@pytest.fixture
def _files(tmp_path: Path) -> None:
    one: xr.DataTree = synthetic.make_springs(
        (synthetic.Path("pull", steps=8), synthetic.Path("high", arm=8.0, steps=8))
    )
    for name, springs in (("one", one), ("fan", synthetic.make_springs(FAN)), ("down", vertical.vertical_springs())):
        save_springs(springs, f"{name}.nc")
    Path("py.csv").write_text(TABLE)
    Path("loads.csv").write_text("H_N,M_Nm\n0,0\n5e5,-1e6\n1e6,-2e6\n-5e5,1e6\n")


@pytest.mark.usefixtures("_files")
def test_all_that_is_printed() -> None:
    lines = []
    for question in QUESTIONS:
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            done = command(*question.split())
        lines += [f"--- {question} (exit code {done.code})", done.out.rstrip("\n"), *done.err.splitlines(), ""]
    about = "predictions with the springs of tests/support/invented_soil.py"
    stored.compare(lines, Path(__file__).parent / "texts" / "predict.txt", about)


def test_the_error_of_the_mesh_is_printed_of_load_and_motion() -> None:
    """Of the motion it is what a load that is off by it changes: a small one, for the tangent. Without one no line."""
    springs = fan_springs(potential)
    save_springs(springs, "none.nc")
    for path in springs["paths"].children.values():
        path.attrs["mesh_error_pct"] = 3.0
    save_springs(springs, "known.nc")
    question = "--H", "700kN", "--arm", "2m"
    lines = command("predict", "known.nc", *question).out.splitlines()
    plain, more = (predict(springs, H=H, arm=2.0) for H in (7e5, 7e5 * (1.0 + 1e-4)))
    shares = [3e4 * (float(more[name]) / float(plain[name]) - 1.0) for name in ("u", "rotation")]
    assert min(shares) > 3.5  # springs that soften
    u, rotation = map(percent, shares)
    assert lines[3] == (
        f"error of the mesh, estimated: load 3 %; under that load u {u}, rotation {rotation}, by the tangent"
    )
    assert command("predict", "known.nc", "--u", "3mm").out.splitlines()[3] == "error of the mesh, estimated: load 3 %"
    assert "mesh" not in command("predict", "none.nc", *question).out


def test_deviations_are_those_of_motions_that_there_are() -> None:
    """Under V alone no motion has one; near collapse it has no bound; an imposed motion has none, its load has."""
    clay = "predict", "--atlas", "clay", "--D", "9m", "--L", "6m"
    lines = [command(*clay, *question.split()).out for question in ("--V 1MN", "--H 1.6MN --arm 9m", "--u 5mm")]
    assert "standard deviation" not in lines[0]
    assert "standard deviation of the last state: u without a bound, rotation without a bound\n" in lines[1]
    assert "standard deviation of the last state: rotation " in lines[2] and "inf" not in "".join(lines)
    assert lines[1].splitlines()[2].split()[4] == "0"  # V: -0.09 N of the solver's tolerance
