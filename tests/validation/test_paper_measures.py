# SPDX-License-Identifier: MIT
"""Numbers read from a run of the paper's case: exact on curves and fields whose answers are known."""

import numpy as np
import pytest
import xarray as xr

from validation.paper import measures as m

DEPTH = np.array([0.0, 1.0, 2.0, 4.0])
AZIMUTH = np.linspace(0.0, np.pi, 5)
U = np.linspace(0.0, 20e-3, 201)


def path(load: np.ndarray | None = None, back: float = 0.0) -> xr.Dataset:
    """Stress 10 (1 + depth) kPa at first, growing by 100 %/mm in front; behind falling to `back` of it at 2 mm."""
    initial = 10e3 * (1.0 + DEPTH)
    factor = np.ones((U.size, 2, AZIMUTH.size))
    factor[:, 0, 0] = 1.0 + U / 1e-3
    factor[:, 0, -1] = np.maximum(1.0 - (1.0 - back) * U / 2e-3, back)
    stress = factor[..., None] * initial
    gap = np.zeros_like(stress)
    gap[:, 0, -1] = np.maximum(U - 2e-3, 0.0)[:, None] * (1.0 - DEPTH / 8.0)
    field = ("step", "side", "azimuth", "depth")
    data = {
        "u": ("step", U),
        "H": ("step", 1e9 * U if load is None else load),
        "normal_effective_stress": (field, stress),
        "gap": (field, gap),
        "y": (("depth", "step"), U * (1.0 - DEPTH[:, None] / 8.0)),
        "p": (("depth", "step"), 1e8 * U * (1.0 + DEPTH[:, None])),
        "depth_bounds": (("depth", "bound"), np.array([[0.0, 0.5], [0.5, 1.5], [1.5, 3.0], [3.0, 4.0]])),
    }
    return xr.Dataset(data, coords={"depth": DEPTH, "azimuth": AZIMUTH, "side": ["outside", "inside"]})


def test_between_steps_and_beyond_the_end() -> None:
    assert m.load(path(), 2.53e-3) == pytest.approx(2.53e6, rel=1e-12)
    assert np.isnan(m.load(path(), 25e-3))
    assert m.reached(path(), 20e-3)
    assert not m.reached(path(), 21e-3)


def test_front_and_back_over_initial_between_rings() -> None:
    assert m.stress_ratio(path(), 2.5e-3, m.FRONT, (0.25, 3.25)) == pytest.approx([3.5, 3.5])
    assert m.stress_ratio(path(back=0.25), 1e-3, m.BACK, (0.25, 3.25)) == pytest.approx([0.625, 0.625])
    assert m.stress_ratio(path(), 2.5e-3, m.FRONT, (1.0,), side="inside") == pytest.approx([1.0])


def test_gap_behind() -> None:
    assert m.rear_gap(path(), 10e-3) == pytest.approx(8e-3 * (1.0 - DEPTH / 8.0))
    assert m.rear_gap(path(), 1e-3) == pytest.approx(0.0)
    assert m.open_share(path(), 1e-3) == 0.0
    assert m.open_share(path(), 3e-3) == pytest.approx(1.0)
    assert m.open_share(path(back=0.1), 3e-3) == 0.0


def test_slopes() -> None:
    bent = path(load=np.where(U < 2e-3, 1e9 * U, 2e6 + 1e8 * (U - 2e-3)))
    assert m.tangent(bent, 0.3e-3) == pytest.approx(1e9)
    assert m.slope_ratio(bent) == pytest.approx(10.0)
    assert m.secant_share(bent, 1e-3) == pytest.approx(1.0)
    assert m.secant_share(bent, 4e-3) == pytest.approx(0.55)
    assert m.load_ratio(bent, path(), 4e-3) == pytest.approx(0.55)


@pytest.mark.parametrize("kink", [1.5e-3, 2e-3, 3e-3])
def test_the_sharpest_bend_is_at_the_kink(kink: float) -> None:
    place, sharpness = m.sharpest_bend(U, np.where(kink > U, U, kink + 0.2 * (U - kink)))
    assert place == pytest.approx(kink, rel=0.35)
    assert sharpness > 2.0


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_a_power_bends_alike_everywhere(power: float) -> None:
    u = np.geomspace(1e-5, 20e-3, 400)
    assert m.sharpest_bend(u, u**power)[1] == pytest.approx(1.0 - power, abs=0.02)


def test_a_curve_that_ends_early_or_falls_at_once_has_no_bend() -> None:
    assert np.isnan(m.sharpest_bend(U[:30], U[:30])).all()
    assert np.isnan(m.sharpest_bend(U, -U)).all()


def test_py_between_rings() -> None:
    y, p = m.py_curve(path(), 3.0)
    assert y == pytest.approx(U * (1.0 - 3.0 / 8.0))
    assert p == pytest.approx(1e8 * U * 4.0)
    assert m.p_at(path(), 0.25, 10e-3) == pytest.approx(1.25e6)
    assert m.y_at(path(), 4.0, 10e-3) == pytest.approx(5e-3)
    assert np.isnan(m.p_at(path(), 0.25, 30e-3))
