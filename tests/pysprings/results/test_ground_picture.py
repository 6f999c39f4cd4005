# SPDX-License-Identifier: MIT
"""Picture of the ground by depth: the data in its axes, and for which runs it is drawn."""

import numpy as np
import pytest
import xarray as xr

from pysprings import Scene
from pysprings.results.plots.ground import PICTURE
from pysprings.results.plots.picture import View
from pysprings.scene.sections import PAPER
from tests.support import tiny

LAYERS = [
    {"top": 0.0, "name": "sand", "friction_angle_final": 0.6, "young_modulus": 60e6},
    {"top": 2.0, "name": "clay", "law": "tresca", "undrained_shear_strength": {"top": 40e3, "bottom": 60e3},
     "rigidity_ratio": 100.0},
]  # fmt: skip
SCENE = tiny.sand(domain=PAPER, soil={"layers": LAYERS}, interface={"adhesion_factor": 0.5})


def view(scene: Scene) -> View:
    return View(xr.DataTree(xr.Dataset(attrs={"scene_toml": scene.to_toml()})))


def test_it_is_drawn_where_the_ground_varies_or_is_clay():
    clay = {"yield_surface": "tresca", "undrained_shear_strength": 20e3, "rigidity_ratio": 100.0}
    assert PICTURE.applies(view(SCENE))
    assert PICTURE.applies(view(tiny.sand(soil=clay, interface={"adhesion_factor": 0.5})))
    assert not PICTURE.applies(view(tiny.sand()))
    assert not PICTURE.applies(View(xr.DataTree()))


def test_its_lines_are_the_values_of_the_layers():
    figure = PICTURE.draw(view(SCENE))
    ground, lines = SCENE.ground, {}
    for axes in figure.axes:
        for line in axes.lines:
            lines.setdefault(line.get_gid(), []).append(line.get_xydata())
    assert [len(lines[name]) for name in ("vertical", "shear")] == [2, 2]
    assert [len(lines[name]) for name in ("friction_angle_final", "undrained_shear_strength")] == [1, 1]
    strength, depth = lines["undrained_shear_strength"][0].T
    np.testing.assert_allclose(strength[1:], 1e-3 * ground.strength(depth[1:]), rtol=1e-9)
    assert (depth.min(), depth.max()) == pytest.approx((2.0, 10.0))
    np.testing.assert_allclose(lines["shear"][0][:, 0], 60.0 / 2.6)
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert texts == ["sand", "clay"]
    (caisson,) = lines["caisson"]
    assert caisson[:, 1].max() == SCENE.caisson.skirt_length


def test_clay_after_cycles_has_its_own_strength_beside_su():
    contours = [[9.0, 0.0, 0.4, 0.0, 0.01], [9.0, 0.0, 0.5, 0.0, 0.1]]
    own = {"law": "iwan-clay", "direct_shear_factor": 0.9, "cyclic": {"contours": contours, "cycles": 9.0}}
    scene = SCENE.replace(soil={"layers": [LAYERS[0], LAYERS[1] | own]})
    axes = PICTURE.draw(view(scene)).axes[-1]
    su, after = (next(line for line in axes.lines if line.get_gid() == name).get_xdata() for name in
                 ("undrained_shear_strength", "cyclic_strength_Pa"))  # fmt: skip
    assert axes.get_xlabel() == "su [kPa]\ndotted: after cycles"
    np.testing.assert_allclose(after, 0.45 * su)
