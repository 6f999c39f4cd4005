# SPDX-License-Identifier: MIT
"""What a scene leaves out: the model that carries it gives the same answer, and its cost is the one that is told."""

from typing import Any

import numpy as np
import pytest

from fe_engine.assembly.system import System
from fe_engine.linear.backends import available_backends
from fe_engine.state import State, initial_fields
from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.model.build import build_model
from pysprings.model.forecast.omissions import left_out, saved_text, symmetric_factors
from pysprings.model.forecast.resources import memory_bytes, size_of
from tests.support import carried, tiny
from tests.support.carried import SMOOTH, difference, push
from tests.support.files import record_of

# of the largest value of each quantity; tolerances of the solver are 1e-9 of the contact forces here
SAME = 1.0e-6
LOADS = ("H", "V", "M", "u", "w", "rotation")
needs_pardiso = pytest.mark.skipif("pardiso" not in available_backends(), reason="pypardiso is not installed")


def close(
    one: carried.Pushed, other: carried.Pushed, tolerance: float = SAME, names: tuple[str, ...] = (), last: bool = False
) -> None:
    found = difference(one, other, names, last)
    assert {name: value for name, value in found.items() if not value <= tolerance} == {}


# --- what is listed ---


def test_every_omission_names_what_and_why() -> None:
    paper = [omission.what.split(" (")[0] for omission in left_out(tiny.paper())]
    assert paper == [
        "steel elements", "half of the domain", "pore pressure of the soil", "film of water in the interface",
        "the whole model at every step, and its ParaView files",
    ]  # fmt: skip
    steel = [omission.what for omission in left_out(tiny.paper(caisson={"behaviour": "elastic"}))]
    assert "steel elements" not in " ".join(steel) and steel[0] == "yield and buckling of the steel"
    output = {"interface_fields": False, "section": False, "figures": False, "paraview": True}
    less = left_out(tiny.paper(**SMOOTH, output=output))
    halved = (
        ["the tangent is symmetric: elastic soil, no friction, drained"]
        if symmetric_factors(tiny.paper(**SMOOTH))
        else []
    )
    assert [omission.why for omission in less if not omission.what.startswith(("steel", "half", "pore", "film"))] == [
        "the soil is elastic", "interface.friction_coefficient = 0: smooth",
        *halved, "output.interface_fields = false", "output.section = false", "output.figures = false",
    ]  # fmt: skip
    wet = [omission.what for omission in left_out(tiny.paper(drainage={"mode": "undrained"}))]
    assert "water pressure on the caisson's side of the interface" in wet
    assert not any(what.startswith(("pore", "film")) for what in wet)


@pytest.mark.parametrize("sections", [{}, SMOOTH, {"drainage": {"mode": "undrained"}}])
def test_savings_are_positive_and_say_where_they_come_from(sections: dict) -> None:
    noted = [omission.saved for omission in left_out(tiny.paper(**sections)) if omission.saved is not None]
    assert len(noted) >= 2  # steel and half of the domain at least
    for saved in noted:
        assert saved.basis and saved.unknowns >= 0 and saved.memory_bytes >= 0
        assert saved.unknowns or saved.memory_bytes or saved.time_share
        assert 0.0 <= saved.time_share < 1.0


def saved(scene: Scene, what: str) -> Any:
    (found,) = [omission.saved for omission in left_out(scene) if omission.what.startswith(what)]
    return found


def unknowns_of(built: Any) -> int:
    return System(built.model).pattern.n_free + 3


def test_saved_unknowns_are_those_of_the_models_that_carry_them() -> None:
    drained, coupled = carried.scene(), carried.scene(drainage={"mode": "undrained"})
    elastic = drained.replace(caisson={"behaviour": "elastic"})
    n, wet = unknowns_of(build_model(drained)), unknowns_of(build_model(coupled))
    steel = unknowns_of(build_model(elastic))
    assert saved(drained, "steel").unknowns == steel - n
    assert saved(drained, "pore").unknowns + saved(drained, "film").unknowns == wet - n
    assert saved(drained, "half").unknowns == unknowns_of(carried.whole_model(drained)) - n
    assert saved(coupled, "half").unknowns == unknowns_of(carried.whole_model(coupled)) - wet
    assert saved(elastic, "half").unknowns == unknowns_of(carried.whole_model(elastic)) - steel
    film = build_model(coupled).model.water.film.n_nodes
    assert saved(coupled, "water pressure").unknowns == film - len(build_model(coupled).caisson.azimuth)


def test_saved_memory_is_what_the_law_says() -> None:
    scene = carried.scene()
    n, m = size_of(scene).unknowns, size_of(scene, whole=True).unknowns
    assert saved(scene, "half").memory_bytes == round(memory_bytes(m) - memory_bytes(n))


def test_saved_bytes_of_history_are_those_of_its_copies() -> None:
    scene = carried.scene(**SMOOTH)
    with_it = initial_fields(carried.with_history(scene).model).history
    assert initial_fields(build_model(scene).model).history.size == 0
    assert saved(scene, "plastic strain").memory_bytes == 3 * with_it.nbytes > 0


def test_the_record_of_a_run_says_the_same() -> None:
    assert record_of(tiny.result())["left_out"] == [omission.record() for omission in left_out(tiny.scene())]


# --- the symmetry half ---


@pytest.mark.parametrize("mode", ["drained", pytest.param("coupled", marks=pytest.mark.slow)])
def test_half_of_the_domain_is_the_whole(mode: str) -> None:
    scene = carried.scene(rate=0.05e-3, drainage={"mode": mode})
    half, whole = push(scene), push(scene, carried.whole_model(scene))
    mine, theirs = half.rows, whole.rows
    n, state, other = half.run.state.committed.displacement.shape[0], half.run.state, whole.run.state
    for name in ("H", "V", "M"):  # rows are twice the model's: the whole model carries twice of it
        np.testing.assert_allclose(2.0 * mine[name], theirs[name], rtol=SAME, atol=SAME * np.abs(theirs["H"]).max())
    for name in ("p_component", "m", "t"):
        np.testing.assert_allclose(2.0 * mine[name], theirs[name], rtol=0.0, atol=SAME * np.abs(theirs[name]).max())
    for name in ("u", "w", "rotation"):
        np.testing.assert_allclose(mine[name], theirs[name], rtol=SAME, atol=1e-14)
    moved = state.committed.displacement
    np.testing.assert_allclose(moved, other.committed.displacement[:n], rtol=0.0, atol=SAME * np.abs(moved).max())
    stress = state.committed.stress
    np.testing.assert_allclose(
        stress, other.committed.stress[: len(stress)], rtol=0.0, atol=SAME * np.abs(stress).max()
    )


# --- water ---


def test_no_water_is_water_that_flows_at_once() -> None:
    """Drained is the limit of a slow pull in a permeable soil."""
    soil = {"hydraulic_conductivity": 0.1}
    dry = push(carried.scene(rate=1e-9, soil=soil))
    wet = push(carried.scene(rate=1e-9, soil=soil, drainage={"mode": "coupled"}))
    assert wet.unknowns > 1.2 * dry.unknowns
    names = (*LOADS, "m", "t", "p", "normal_effective_stress", "shear_lateral", "shear_vertical", "gap", "section_ux")
    close(dry, wet, names=names)
    assert np.abs(wet.run.state.committed.pressure).max() < 1e-3  # Pa, of 10 kPa


def test_an_impervious_side_of_the_film_needs_no_pressure_of_its_own() -> None:
    """Pressures of the steel's faces are added: nothing flows on from them, and they are the film's."""
    scene = carried.scene(rate=0.5e-3, drainage={"mode": "coupled"}, caisson={"behaviour": "elastic"})
    without, built = push(scene), carried.with_water_in_steel(scene)
    with_it = push(scene, built)
    assert with_it.unknowns > without.unknowns
    close(without, with_it, names=tuple(name for name in without.rows if not name.startswith("water_")))
    stations, film = built.model.stations, built.model.water.film
    pressure, n = with_it.run.state.committed.pressure, built.model.mesh.n_nodes
    inside = np.einsum("sc,sc->s", film.weight, pressure[n:][film.nodes])
    side_2 = -np.sum(np.minimum(stations.weight, 0.0) * pressure[stations.nodes], axis=1)
    assert np.abs(inside).max() > 10.0  # Pa: there is something to compare
    np.testing.assert_allclose(side_2, inside, rtol=0.0, atol=SAME * np.abs(inside).max())


# --- steel ---


def test_a_rigid_caisson_is_one_of_stiff_steel() -> None:
    """The answer goes to that of the rigid one as 1/E, and its limit from two moduli is that to the tolerance."""
    scene = carried.scene()
    rigid, steel = push(scene), {"behaviour": "elastic", "lid_thickness": 1.0}
    soft, stiff = (push(scene.replace(caisson=steel | {"young_modulus": young})) for young in (1e14, 1e15))
    assert stiff.unknowns > rigid.unknowns
    for name in (*LOADS, "p_component", "m", "t", "normal_effective_stress"):
        wanted = rigid.rows[name]
        size = np.abs(rigid.rows["H" if name in "HVM" else name]).max()
        limit = stiff.rows[name] + (stiff.rows[name] - soft.rows[name]) / 9.0
        assert np.abs(limit - wanted).max() < SAME * size, name


# --- soil, friction, symmetric factors ---


def test_elastic_soil_is_soil_that_does_not_yield() -> None:
    scene = carried.scene(soil=SMOOTH["soil"])
    without, with_it = push(scene), push(scene, carried.with_history(scene))
    close(without, with_it, 1e-9)
    assert with_it.run.state.committed.history.shape[2] == 1


def test_a_smooth_interface_is_one_of_no_friction() -> None:
    """In elastic soil, where the end does not depend on the way there: next to no friction is cut back on it."""
    scene = carried.scene(**SMOOTH)
    close(push(scene), push(scene, carried.with_shear(scene)), last=True)


@needs_pardiso
@pytest.mark.parametrize("caisson", ["rigid", "elastic"])
def test_half_of_the_factors_are_the_factors(caisson: str) -> None:
    scene = carried.scene(**SMOOTH, caisson={"behaviour": caisson})
    half, full = push(scene), push(scene, symmetric=False)
    assert half.factorisations == full.factorisations
    close(half, full, 1e-9)


CASES = {
    "elastic, smooth": SMOOTH,
    "friction": {"soil": SMOOTH["soil"]},
    "plastic": {"interface": SMOOTH["interface"]},
    "water": SMOOTH | {"drainage": {"mode": "undrained"}},
    "steel": SMOOTH | {"caisson": {"behaviour": "elastic"}},
}


@pytest.mark.parametrize("case", CASES)
def test_the_tangent_is_symmetric_where_the_model_says_so_and_nowhere_else(case: str) -> None:
    """At the end of a push, where something slips, yields and opens."""
    scene = carried.scene(2e-3, **CASES[case])
    built = build_model(scene)
    pushed = push(scene, built, symmetric=False)
    system, state = System(built.model), State(built.model)
    state.committed.copy_from(pushed.run.state.committed)
    state.reset_trial()
    # the last increment once more, from where it began: loading, not unloading
    system.time_step = 1.0
    last = pushed.run.driver.position.last
    system.apply(state, last[1], last[2])
    _, _, tangent = system.linearise(state, True)
    matrix = tangent.matrix
    asymmetry = abs(matrix - matrix.T).max() / abs(matrix).max()
    assert (asymmetry < 1e-12) == built.model.symmetric == (case in ("elastic, smooth", "steel"))


def test_symmetric_factors_are_those_of_the_model() -> None:
    for sections in CASES.values():
        scene = carried.scene(**sections)
        expected = build_model(scene).model.symmetric and "pardiso" in available_backends()
        assert symmetric_factors(scene) == expected
        assert not symmetric_factors(scene.replace(solver={"linear": "superlu"}))


# --- outputs ---


def test_what_is_not_kept_changes_no_number() -> None:
    kept = {"interface_fields": False, "section": False, "paraview": False, "figures": False}
    all_of_it = dict.fromkeys(("interface_fields", "section", "paraview"), True)
    less, more = (run(tiny.scene(output=kept | part))["paths/pull"] for part in ({}, all_of_it))
    assert set(less.data_vars) < set(more.data_vars)
    for name in less.data_vars:
        np.testing.assert_array_equal(less[name].values, more[name].values, err_msg=str(name))
    assert less.to_dataset().nbytes < more.to_dataset().nbytes


# --- savings in words; what is no saving says nothing ---


@pytest.mark.parametrize(
    ("saved", "text"),
    [
        ({"basis": "laws", "unknowns": 1234, "time_share": 0.616}, "1,234 unknowns, 62 % of the time (laws)"),
        ({"basis": "b", "memory_bytes": 1.1e9, "disk_bytes": 32.4e6}, "1.1 GB of memory, 32 MB on disk (b)"),
        ({"basis": "b", "memory_bytes": 5e3, "disk_bytes": 12}, "5 kB of memory, 12 bytes on disk (b)"),
        ({"basis": "b", "unknowns": 0, "memory_bytes": 0, "time_share": None}, ""),
        (None, ""),
        ("much", ""),
        ({"unknowns": "many", "memory_bytes": float("nan"), "disk_bytes": True, "time_share": -1.0}, ""),
        ({"basis": "b", "unknowns": 10**400, "memory_bytes": float("inf")}, ""),
    ],
)
def test_savings_in_words(saved: Any, text: str) -> None:
    assert saved_text(saved) == text
