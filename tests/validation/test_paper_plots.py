# SPDX-License-Identifier: MIT
"""The paper's curves and signed rose diagrams show the dataset's numbers."""

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from pysprings.results import plots
from pysprings.results.plots import rose
from tests.support import synthetic
from validation.paper import curves
from validation.paper.measures import py_curve


@dataclass(frozen=True)
class Case:
    rate: float | None
    friction: float


@pytest.fixture(scope="module")
def path() -> xr.Dataset:
    tree = synthetic.make_result((synthetic.Path("pull", size=20e-3, steps=20),))
    found = plots.path_data(tree, "pull")
    water = 1e3 * np.cos(found["azimuth"]) + 0.0 * found["normal_effective_stress"]
    return found.assign(pore_pressure=water, F_pw=-2e6 * found["u"]).assign_attrs(rate_m_per_s=5e-5)


def line(figure: Figure, gid: str, panel: int = 0) -> tuple[np.ndarray, np.ndarray]:
    found = next(each for each in figure.axes[panel].get_lines() if each.get_gid() == gid)
    return np.asarray(found.get_xdata()), np.asarray(found.get_ydata())


def test_shear_goes_outward_over_the_initial_stress(path: xr.Dataset) -> None:
    figure = plots.shear_rose(path, step=10, depths=[1.0])
    x, y = line(figure, "shear_outside")
    ring = int(np.argmin(np.abs(path["depth"].values - 1.0)))
    shear = path["shear_lateral"].isel(step=10, depth=ring).transpose("side", "azimuth").values
    ratio = shear / path["normal_effective_stress"].isel(step=0, depth=ring).transpose("side", "azimuth").values
    quarter = int(np.argmin(np.abs(np.arctan2(y, x) - np.pi / 2)))
    side = ratio[0, path.sizes["azimuth"] // 2]
    assert np.hypot(x, y)[quarter] - 1.0 == pytest.approx(rose.SHEAR.reach * side / np.abs(ratio).max(), rel=1e-6)
    assert np.hypot(x, y)[0] == pytest.approx(1.0, abs=1e-12)  # none at the front


def test_suction_goes_inward(path: xr.Dataset) -> None:
    for normalised in (False, True):
        figure = plots.pressure_rose(path, step=10, depths=[1.0], normalised=normalised)
        x, y = line(figure, "pressure_outside")
        back = int(np.argmax(np.abs(np.arctan2(y, x))))
        assert np.hypot(x, y)[0] == pytest.approx(1.0 + rose.SHEAR.reach)
        assert np.hypot(x, y)[back] == pytest.approx(1.0 - rose.SHEAR.reach, rel=1e-6)
    ring = int(np.argmin(np.abs(path["depth"].values - 1.0)))
    initial = float(path["normal_effective_stress"].isel(step=0, side=0, depth=ring).mean())
    assert f"{1e3 / initial:.2g} front" in figure.axes[0].get_title(loc="center")


def test_zones_without_contact_are_shaded_where_they_are(path: xr.Dataset) -> None:
    stress = path["normal_effective_stress"][0] + 0.0 * path["normal_effective_stress"]
    stress[{"step": 10, "side": 0, "azimuth": -1}] = 0.0
    figure = plots.shear_rose(path.assign(normal_effective_stress=stress), step=10, depths=[1.0])
    wedges = [patch for patch in figure.axes[0].patches if isinstance(patch, Wedge)]
    assert len(wedges) == 2
    assert all(170.0 < 0.5 * (wedge.theta1 + wedge.theta2) < 190.0 for wedge in wedges)
    assert any("no contact" in text.get_text() for text in figure.legends[0].get_texts())
    clear = plots.shear_rose(path.assign(normal_effective_stress=stress), step=1, depths=[1.0])
    assert not any("no contact" in text.get_text() for text in clear.legends[0].get_texts())


def test_components_are_changes_from_the_start(path: xr.Dataset) -> None:
    shifted = path.assign(F_in=path["F_in"] + 5e5)
    figure = curves.load_components(shifted, path)
    drawn = {str(each.get_label()).split(",")[0]: np.asarray(each.get_ydata()) for each in figure.axes[0].get_lines()}
    assert drawn[r"$\Delta F_{in}$"] == pytest.approx(1e-3 * (path["F_in"] - path["F_in"][0]).values)
    assert drawn[r"$\Delta F_{pw}$"] == pytest.approx(-2e3 * path["u"].values)
    labels = [str(each.get_label()) for each in figure.axes[0].get_lines()]
    assert r"$\Delta F_{tot}$, drained" in labels


def test_open_markers_are_drained_and_filled_ones_are_not(path: xr.Dataset) -> None:
    other = path.assign(p=1.2 * path["p"])
    figure = curves.py_by_drainage(path, other, (0.25, 3.25), py_curve)
    lines = {each.get_gid(): each for each in figure.axes[0].get_lines() if each.get_gid()}
    assert set(lines) == {"open 0.25", "open 3.25", "filled 0.25", "filled 3.25"}
    assert lines["open 3.25"].get_markerfacecolor() == "white"
    assert tuple(lines["filled 3.25"].get_markerfacecolor()) == tuple(lines["filled 3.25"].get_color())
    y, p = py_curve(path, 3.25)
    assert np.asarray(lines["open 3.25"].get_xdata()) == pytest.approx(1e3 * y)
    assert np.asarray(lines["filled 3.25"].get_ydata()) == pytest.approx(1.2e-3 * p)
    assert "0.05 mm/s" in figure.get_suptitle()


def test_one_colour_a_rate_and_dashes_without_friction(path: xr.Dataset) -> None:
    runs = {"a": (path, Case(None, 0.5)), "b": (path, Case(None, 0.0)), "c": (path, Case(5e-5, 0.5))}
    drawn = {str(each.get_label()): each for each in curves.rates_and_friction(runs).axes[0].get_lines()}
    assert drawn["a"].get_color() == drawn["b"].get_color() != drawn["c"].get_color()
    assert (drawn["a"].get_linestyle(), drawn["b"].get_linestyle()) == ("-", "--")
    assert np.asarray(drawn["c"].get_ydata()) == pytest.approx(1e-3 * path["H"].values)
