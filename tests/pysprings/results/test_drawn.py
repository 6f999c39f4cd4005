# SPDX-License-Identifier: MIT
"""All that is drawn in each picture: panels, axes, curves, marks, keys, colours and words, in the stored texts."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from pysprings.results import parts, plots
from pysprings.results.plots import files
from pysprings.results.plots.picture import View
from tests.support import stored, synthetic, vertical
from tests.support.drawn import describe

TEXTS = Path(__file__).parent / "drawn"
PATHS = (synthetic.Path("pull", size=8e-3, steps=12), synthetic.Path("turn", "rotation", size=-2e-3, steps=6))


@pytest.fixture(scope="module")
def result() -> xr.DataTree:
    return synthetic.make_result(PATHS)


def predictions(path: xr.Dataset) -> dict[str, xr.Dataset]:
    """Curves of two sets of springs, one of them softer, the last state of the other without an answer."""
    softer = path.assign(H=0.4 * path["H"], rotation=1.8 * path["rotation"], u_at_load=1.25 * path["u"])
    full = path.assign(u_at_load=path["u"].where(path["step"] < path.sizes["step"] - 1))
    return {"full": full, "py": softer}


def of_a_run(result: xr.DataTree) -> Iterator[tuple[str, Figure]]:
    """Every picture of a pull, of its last state; two of a rotation."""
    view, plane = View(result, synthetic.make_springs(PATHS)), plots.section_data(result)
    assert plane is not None
    pull, turn = (view.with_settings(plots.path_data(result, name)) for name in ("pull", "turn"))
    view = replace(view, section=view.with_settings(plane), path=pull, predictions=predictions(pull))
    for picture in files.PICTURES:
        shown = replace(view, step=parts.pick_step(pull))
        if picture.applies(shown):
            yield f"pull_{picture.name}", picture.draw(shown)
    yield "turn_load_displacement", plots.load_displacement(turn)
    yield "turn_py", plots.py_curves(turn)


def stopped(result: xr.DataTree) -> Iterator[tuple[str, Figure]]:
    """A path with two steps that did not converge, stopped before its end, of small loads."""
    tree = result.copy(deep=True)
    path = tree["paths/pull"]
    path["converged"][[6, 12]] = 0
    path.attrs["status"] = "partial"
    for name in ("H", "H_outer", "H_inner", "H_lid", "H_tip"):
        path[name] = 1e-2 * path[name]
    data = plots.path_data(tree, "pull")
    view = View(tree, path=data, predictions=predictions(data.isel(step=data["converged"].values == 1)))
    for picture in files.PICTURES:
        if picture.scope == "path" and picture.applies(view):
            yield picture.name, picture.draw(view)
    yield "gap", plots.gap_map(view.path, step=6)


def wet(result: xr.DataTree) -> Iterator[tuple[str, Figure]]:
    path, plane = plots.path_data(result, "pull"), plots.section_data(result)
    assert plane is not None
    inside = xr.where(path["side"] == "inside", -8e3, 1e3) * (1.0 + 0.2 * np.cos(path["azimuth"]))
    path["pore_pressure"] = (inside * xr.ones_like(path["pore_pressure"])).transpose(*path["pore_pressure"].dims)
    steps, nodes = path.sizes["step"], plane.sizes["section_node"]
    path["section_pore_pressure"] = (("step", "section_node"), np.linspace(-8e3, 5e2, steps * nodes).reshape(steps, -1))
    yield "pressure", plots.pressure_rose(path)
    yield "pressure over the initial stress", plots.pressure_rose(path, depths=[1.0], normalised=True)
    yield "shear", plots.shear_rose(path, step=8)
    yield "section", plots.section_pressure(plane, path)


def others(result: xr.DataTree) -> Iterator[tuple[str, Figure]]:
    """Vertical springs down and up; an elastic caisson; rings without an initial stress, nothing open."""
    springs = vertical.vertical_springs()
    for name in ("down", "up"):
        yield name, plots.vertical_springs(plots.path_data(springs, name))
    path, plane = plots.path_data(result, "pull"), plots.section_data(result)
    assert plane is not None
    change = 1e-3 * path["y"].transpose("depth", "step")
    path = path.assign(diameter_change_x=change, diameter_change_y=-0.5 * change)
    settings = parts.settings(synthetic.make_springs(PATHS))
    path, plane = path.assign_attrs(settings, caisson_behaviour="elastic"), plane.assign_attrs(settings)
    yield "ovalisation", plots.ovalisation(path, displacement=2.5e-3)
    yield "elastic section", plots.section_displacement(plane, path, displacement=2.5e-3)
    yield "section at rest", plots.section_displacement(plane, path, step=0)
    field = path["normal_effective_stress"].transpose("step", "side", "azimuth", "depth").copy(deep=True)
    field[0, :, :, :6] = 0.0
    yield "no initial stress", plots.stress_rose(path.assign(normal_effective_stress=field), side="inside")
    yield "closed", plots.gap_map(path, step=0)


@pytest.mark.parametrize("pictures", [of_a_run, stopped, wet, others])
def test_all_that_is_drawn(result: xr.DataTree, pictures) -> None:
    lines = [line for name, figure in pictures(result) for line in (f"{name}", *describe(figure), "")]
    assert len(lines) > 50
    about = "pictures of the caisson of tests/support/invented_soil.py"
    stored.compare(lines, TEXTS / f"{pictures.__name__}.txt", about)
