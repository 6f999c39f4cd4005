# SPDX-License-Identifier: MIT
"""The picture of a path that turns back."""

from dataclasses import replace

import numpy as np

from pysprings.macro.comparison import curves
from pysprings.results.plots.comparison import LOOPS
from pysprings.results.plots.picture import View
from pysprings.springs.springs import Springs
from tests.support import winkler


def view(name: str) -> View:
    tree = winkler.with_invented_memory()
    path = Springs.of(tree).paths[name]
    shown = path.dataset.assign_attrs(skirt_length_m=path.length)
    return View(tree, tree, path=shown, predictions=dict(curves(tree, name, "memory")))


def test_loops_show_both_models_with_stiffness_and_damping() -> None:
    shown = view("turning_0")
    assert LOOPS.applies(shown)
    loads, moments, stiffness, damping = LOOPS.draw(shown).axes
    full, macro = loads.get_lines()[:2]
    np.testing.assert_allclose(full.get_xdata(), 1e3 * shown.path["u"].values)
    np.testing.assert_allclose(np.ptp(macro.get_ydata()) / np.ptp(shown.predictions["memory"]["H"].values), 1e-6)
    assert moments.get_xlabel() == "u [mm]" and loads.get_legend() is not None  # no rotation: it is held
    np.testing.assert_array_equal(moments.get_lines()[0].get_xdata(), full.get_xdata())
    assert np.nanmax(damping.get_lines()[0].get_ydata()) < 0.96 * damping.get_ylim()[1]
    assert [len(line.get_xdata()) for line in stiffness.get_lines()] == [3, 3]
    u = 1e3 * shown.path["u"].values
    turns = u[1:-1][np.diff(np.sign(np.diff(u))) != 0.0]
    np.testing.assert_allclose(stiffness.get_lines()[0].get_xdata()[:2], [turns[0], 0.5 * abs(turns[1] - turns[0])])
    ratios = damping.get_lines()[0].get_ydata()
    assert np.isnan(ratios[:2]).all() and 0.05 < ratios[-1] < 0.64  # at most 2/pi, that of a rigid-plastic loop


def test_a_loop_of_the_rotation_has_its_motion_and_moment_in_words_and_units() -> None:
    shown = view("turning_0")
    turned = {name: data.assign(rotation=data["u"] / 4.0, u=0.0 * data["u"], M=2.0 * data["H"], H=0.0 * data["H"])
              for name, data in (("full", shown.path), ("memory", shown.predictions["memory"]))}  # fmt: skip
    path = turned["full"].assign_attrs(kind="rotation")
    *_, stiffness, damping = LOOPS.draw(replace(shown, path=path, predictions={"memory": turned["memory"]})).axes
    assert (
        stiffness.get_ylabel().startswith("secant stiffness dM/d(rotation) [") and "N m/rad]" in stiffness.get_ylabel()
    )
    assert stiffness.get_xlabel() == damping.get_xlabel() == "amplitude of rotation [mrad]"
    own = [axes.get_lines()[0] for axes in LOOPS.draw(shown).axes[2:]]
    np.testing.assert_allclose(stiffness.get_lines()[0].get_ydata(), 8.0 * np.asarray(own[0].get_ydata()), rtol=1e-9)
    np.testing.assert_allclose(damping.get_lines()[0].get_ydata(), own[1].get_ydata(), rtol=1e-9)


def test_loops_of_loads_given_in_pairs_turn_where_the_load_does() -> None:
    shown = view("turning_0")
    turn, u = int(np.argmax(shown.path["H"].values)), shown.path["u"].values.copy()
    u[turn + 1] = 1.01 * u[turn]  # it creeps on
    path = shown.path.assign(u=("step", u)).assign_attrs(kind="load", then_pairs=1)
    *_, stiffness, _ = LOOPS.draw(replace(shown, path=path)).axes
    np.testing.assert_allclose(np.asarray(stiffness.get_lines()[0].get_xdata())[0], 1e3 * u[turn])


def test_a_path_without_a_closed_cycle_has_no_damping() -> None:
    """There and back once: the work of both has stored energy in it."""
    shown = view("turning_0")
    u = shown.path["u"].values
    end = int(np.argmin(u)) + 1
    short = {name: data.isel(step=slice(end)) for name, data in shown.predictions.items()}
    *_, damping = LOOPS.draw(replace(shown, path=shown.path.isel(step=slice(end)), predictions=short)).axes
    assert np.isnan(damping.get_lines()[0].get_ydata()).all() and damping.get_ylim()[0] == 0.0


def test_loops_are_drawn_where_a_path_turns_back_and_springs_remember() -> None:
    assert not LOOPS.applies(replace(view("turning_0"), predictions={}))
    assert not LOOPS.applies(view("ray_0"))
