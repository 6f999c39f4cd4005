# SPDX-License-Identifier: MIT
"""The first picture of the report: where the load stands, and the error that its title states."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from pysprings.core.path_kinds import PARTS
from pysprings.core.text import percent
from pysprings.results.parts import path_data
from pysprings.results.plots.ground import CAISSON
from pysprings.results.plots.picture import View
from tests.support import synthetic, tiny

PULL = synthetic.Path("pull", arm=6.0)


def view(factor: float) -> View:
    """Return the view of a pull, with springs whose loads are a share of the full model's."""
    result = synthetic.make_result((PULL,))
    result.attrs["scene_toml"] = tiny.sand().to_toml()
    path = path_data(result, "pull")
    answer = path[["u", "H", "M", "rotation"]].assign(converged=path["converged"])
    return View(result, None, None, path, {"fan": answer.assign(H=factor * answer["H"])})


@pytest.mark.parametrize("factor", [1.03, 0.9, -0.98])
def test_load_height_and_error_of_the_springs(factor: float) -> None:
    drawn = CAISSON.draw(view(factor))
    left, right = drawn.axes
    assert {text.get_text() for text in left.texts} >= {"H at 6 m"}
    assert right.get_title(loc="left") == f"largest error of the springs in H: {percent(100 * abs(factor - 1))}"
    low, high = left.get_ylim()
    assert high < -6.0 < low  # the load is on the picture, depth down


def test_the_load_is_drawn_in_its_sense() -> None:
    pushed, pulled = view(1.0), view(1.0)
    pulled = replace(pulled, path=-pulled.path.drop_vars("converged").assign(V=-pulled.path["V"]))
    pulled = replace(
        pulled, path=pulled.path.assign(converged=pushed.path["converged"]).assign_attrs(pushed.path.attrs)
    )
    for each, sign in ((pushed, 1.0), (pulled, -1.0)):
        arrow = next(text for text in CAISSON.draw(each).axes[0].texts if text.get_text() == "")
        assert np.sign(arrow.xy[0] - arrow.xyann[0]) == sign


def test_a_rotation_alone_has_no_arrow_of_a_motion() -> None:
    whole = view(1.0)
    for u, kind, words in ((1e-12, "rotation", "rotation alone"), (1.0, "translation", "motion of the lid")):
        path = whole.path.assign(u=u * whole.path["u"]).assign_attrs(kind=kind)
        texts = [text.get_text() for text in CAISSON.draw(replace(whole, path=path)).axes[0].texts]
        assert words in texts and texts.count("") == 1 + (kind != "rotation")  # of V, of the motion


def test_springs_that_do_not_follow_the_whole_path_have_no_error_of_it() -> None:
    for states, words in ((0, "not known, first 0 of 21"), (8, "3 %, first 8 of 21")):
        whole = view(1.03)
        part = replace(whole, predictions={"fan": whole.predictions["fan"].isel(step=slice(states))})
        title = CAISSON.draw(part).axes[1].get_title(loc="left")
        assert title == f"largest error of the springs in H: {words} states alone"


def test_a_path_that_turns_back_has_the_error_of_the_comparison_and_springs_with_memory() -> None:
    """Where H passes zero a relative error has no meaning: it is one of the largest H, as `compare` states it."""
    whole = view(1.0)
    path = whole.path.assign(H=whole.path["H"] * np.cos(np.linspace(0.0, 6.0, whole.path.sizes["step"])))
    path = path.assign_attrs({PARTS: 1})
    largest = float(np.abs(path["H"]).max())
    answers = {name: whole.predictions["fan"].assign(H=path["H"] + off * largest)
               for name, off in (("fan", 0.5), ("memory", 0.02))}  # fmt: skip
    right = CAISSON.draw(replace(whole, path=path, predictions=answers)).axes[1]
    assert right.get_title(loc="left") == "largest error of the springs in H: 2 %"
    assert right.get_lines()[1].get_label() == "springs with memory"


def test_it_needs_a_scene_and_springs() -> None:
    whole = view(1.0)
    assert CAISSON.applies(whole)
    assert not CAISSON.applies(replace(whole, predictions={}))
    assert not CAISSON.applies(replace(whole, result=xr.DataTree()))
