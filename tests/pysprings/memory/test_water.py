# SPDX-License-Identifier: MIT
"""The water's part of p: relaxation in closed form, springs of coupled paths, with a fan and with memory."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from pysprings.macro.batch import predict_batch
from pysprings.macro.cycles import follow_path, reaction_errors
from pysprings.macro.fan import FanTable, build_fan
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import predict, sequence
from pysprings.memory.build import build_memory, digest, has_elements, memory_dataset, with_memory
from pysprings.memory.mixture import ChangingLoad, mixed as together
from pysprings.memory.model import MemorySprings
from pysprings.memory.shares import elastic_motions
from pysprings.memory.stepper import MemoryStepper
from pysprings.memory.water import TIMES, Water, water_of
from pysprings.springs.springs import Springs
from tests.support import wet, winkler
from tests.support.fans import DEPTH, LENGTH
from tests.support.wet import RATE, TIME, maxwell
from tests.support.winkler import REACH, element, elements_of, mixed

THERE_AND_REST = REACH * np.array([[0.1, 0.0], [0.2, -0.1], [0.2, -0.1]]) / [1.0, LENGTH]


def one(times: float) -> Water:
    """Water of one elastic element with one relaxation time, that follows u alone."""
    return Water(np.array([[[1.0, 0.0]]]), np.array([[times]]))


@cache
def table() -> FanTable:
    return build_fan(wet.coupled())


@cache
def model(seed: int = 1) -> MemorySprings:
    """Mixed elements on the fan of coupled paths, with water of any size that drains in 3 to 300 s."""
    rows, random = mixed(n=6, seed=seed), np.random.default_rng(seed)
    elements = elements_of(rows, table())
    factors = random.normal(size=(int(table().wet.sum()), 3, 2 * len(rows)))
    water = Water(factors, np.repeat([[3.0], [30.0], [300.0]], len(rows), axis=1))
    return winkler.remembering(replace(elements, shares=replace(elements.shares, water=water)), table(), rate=RATE)


def test_a_way_without_states_has_no_reactions_and_no_water() -> None:
    """As under a first load that the elements do not carry."""
    assert model().reactions(np.zeros((0, 2))).shape == (len(table().name), 0)


def test_pressure_builds_up_and_drains_as_a_maxwell_body() -> None:
    """At a speed v: v T (1 - exp(-t/T)); in a rest it decays with exp(-t/T); without drainage it is the motion."""
    v, T = 2e-4, 5.0
    time = np.array([1.0, 7.0, 20.0, 22.0, 40.0])
    u = v * np.minimum(time, 20.0)
    e = np.stack([u, 0.0 * u], axis=1)[:, None]
    built = v * T * (1.0 - np.exp(-np.minimum(time, 20.0) / T))
    expected = built * np.exp(-np.maximum(time - 20.0, 0.0) / T)
    np.testing.assert_allclose(one(T).along(e, time, np.zeros((1, 2)), np.zeros((1, 2)))[0], expected, rtol=1e-9)
    np.testing.assert_allclose(one(np.inf).along(e, time, np.zeros((1, 2)), np.zeros((1, 2)))[0], u, rtol=1e-12)


def test_a_relaxation_time_of_the_fit_is_found() -> None:
    """Pressure of u and the rotation with one T; a loop that no way has, within 3 %."""
    longest, rows = TIME / TIMES[2], np.array([element(d=1e3)])

    def way(*corners: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        ends = REACH * np.array([(0.0, 0.0), *corners])
        motions = np.concatenate([np.linspace(a, b, 60)[1:] for a, b in pairwise(ends)])
        time = longest * np.hypot(*np.diff(motions, axis=0, prepend=0.0).T).cumsum() / REACH
        first = np.concatenate([np.zeros((1, 2)), motions]).T
        pressure = maxwell(first, np.append(0.0, time))[:, 1:]
        return elastic_motions(rows, motions, 1e9)[0], np.stack([pressure[0], pressure[0] - 2.0 * pressure[1]]), time

    ways = [
        way((1.0, 0.0)),
        way((0.0, 1.0)),
        way((0.7, -0.7)),
        way((0.4, 0.0), (-0.4, 0.0)),
        way((0.0, 0.4), (0.0, 0.0)),
    ]
    water = water_of(*zip(*ways, strict=True), longest)
    e, known, time = way((0.3, -0.2), (-0.3, 0.1), (0.2, 0.2))
    found = water.along(e, time, np.zeros((1, 2)), water.rest)
    assert np.abs(found - known).max() < 0.03 * np.abs(known).max()


def test_a_fan_has_the_pressure_of_its_rays_as_a_part_of_p() -> None:
    """On a ray that of the path, by side; the answer without it is the same."""
    springs = wet.coupled()
    path = springs.paths["ray_3"]
    motions = np.stack([path.u, path.rotation], axis=1)[[5, 20]]
    answer = sequence(springs, motions, control="state", springs_kind="fan")
    assert answer["p_water"].dims == ("side", "depth", "step") and list(answer["side"].values) == ["outside", "inside"]
    assert np.abs(path.water[:, :, 0]).min() > 0.0
    np.testing.assert_allclose(answer["p_water"], path.water[:, :, [5, 20]] - path.water[:, :, :1], rtol=1e-9)
    dry = sequence(Springs.of(winkler.springs()), motions, control="state", springs_kind="fan")
    assert "p_water" not in dry and "side" not in dry.coords
    np.testing.assert_allclose(answer["p"], dry["p"], rtol=1e-9)
    np.testing.assert_allclose(answer["H"], dry["H"], rtol=1e-12)
    assert "p_water" in predict(springs, H=1e4, springs_kind="fan")
    cases = predict_batch(springs, H=np.array([1e4, 1e12]), arm=0.0, springs_kind="fan")
    assert "p_water" not in cases and "depth" not in cases.dims


def test_a_sequence_drains_in_its_time() -> None:
    """At the rate of the elements without a time; a rest of an hour leaves none; H, M and other reactions stay."""
    way = REACH * np.array([[0.1, 0.0], [0.2, -0.1], [-0.1, 0.1], [-0.1, 0.1]]) / [1.0, LENGTH]
    time = np.hypot(*np.diff(way * [1.0, LENGTH], axis=0, prepend=0.0).T).cumsum() / RATE
    wet_rows = table().wet
    plain, timed = model().reactions(way), model().reactions(way, time)
    np.testing.assert_allclose(plain, timed, rtol=1e-12)
    rested = model().reactions(way, time + [0.0, 0.0, 0.0, 36e3])
    np.testing.assert_array_equal(rested[~wet_rows], plain[~wet_rows])
    assert np.abs(rested[wet_rows, 3]).max() < 1e-9 * np.abs(plain[wet_rows, 2]).max()
    np.testing.assert_array_equal(rested[wet_rows, :3], plain[wet_rows, :3])
    slow = model().reactions(way, 100.0 * time)
    assert (np.abs(slow[wet_rows, 1]).max() < 0.5 * np.abs(plain[wet_rows, 1]).max()) and np.ptp(slow[wet_rows])


def test_long_steps_drain_on_the_way() -> None:
    """One row and forty on the same straight way: the same pressure at its end."""
    end = REACH * np.array([0.4, -0.2 / LENGTH])
    rows = [model().reactions(np.linspace(0.0, 1.0, n + 1)[1:, None] * end)[table().wet, -1] for n in (1, 40)]
    np.testing.assert_allclose(rows[0], rows[1], rtol=1e-3)


def test_a_stepper_has_the_pressure_of_the_sequence_and_drains_in_the_duration_of_a_step() -> None:
    random = np.random.default_rng(3)
    way = np.cumsum(random.normal(size=(40, 2)), axis=0) * 0.002 * REACH / [1.0, LENGTH]
    time = np.cumsum(random.uniform(1.0, 20.0, size=40))
    stepper, wet_rows = MemoryStepper(model()), table().wet
    for state, duration in zip(way, np.diff(time, prepend=0.0), strict=True):
        stepper.advance(motion=(3e-3, 0.0), duration=1.0)  # tried, and forgotten
        stepper.advance(motion=tuple(state), duration=duration)
        found = stepper.reactions
        stepper.commit()
    expected = model().reactions(way, time)[:, -1]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    stepper.advance(motion=tuple(way[-1]), duration=36e3)
    assert np.abs(stepper.reactions[wet_rows]).max() < 1e-9 * np.abs(found[wet_rows]).max()
    stepper.commit()
    again = stepper.reactions[wet_rows]
    assert np.abs(again).max() < 1e-9 * np.abs(found[wet_rows]).max()
    whole_step, parts = MemoryStepper(model()), MemoryStepper(model())
    whole_step.advance(motion=(4e-3, 0.0), duration=40.0)
    for part in range(1, 41):
        parts.advance(motion=(1e-4 * part, 0.0), duration=1.0)
        known = parts.reactions[wet_rows]
        parts.commit()
        np.testing.assert_allclose(parts.reactions[wet_rows], known, rtol=1e-9)
    np.testing.assert_allclose(whole_step.reactions[wet_rows], known, rtol=0.01)
    at_rate = MemoryStepper(model())
    for state in way:
        at_rate.advance(motion=tuple(state))
        found = at_rate.reactions
        at_rate.commit()
    np.testing.assert_allclose(found[wet_rows], model().reactions(way)[wet_rows, -1], rtol=1e-9)


def test_without_a_rate_nothing_drains() -> None:
    """Undrained springs: a time changes nothing, of a sequence or of a step."""
    undrained, way = replace(model(), rate=None), THERE_AND_REST
    time = np.array([1.0, 2.0, 3600.0])
    np.testing.assert_array_equal(undrained.reactions(way, time), undrained.reactions(way))
    stepper, wet_rows = MemoryStepper(undrained), table().wet
    stepper.advance(motion=tuple(way[0]), duration=1.0)
    stepper.commit()
    known = stepper.reactions[wet_rows]
    stepper.advance(motion=tuple(way[0]), duration=36e3)
    np.testing.assert_allclose(stepper.reactions[wet_rows], known, rtol=1e-12)


def test_a_prediction_drains_in_its_times() -> None:
    springs = wet.coupled()
    groups = {node.path: node.to_dataset(inherit=False) for node in springs.tree.subtree}
    groups["/memory"] = memory_dataset(springs, model().elements)
    stored, time = Springs.of(xr.DataTree.from_dict(groups, name="springs")), np.array([40.0, 80.0, 110.0])
    answer = sequence(stored, THERE_AND_REST, control="state", time=time, springs_kind="memory", extrapolate=True)
    expected = model().reactions(THERE_AND_REST, time)[table().wet].reshape(2, DEPTH.size, 3)
    np.testing.assert_allclose(answer["p_water"], expected, rtol=1e-9)


def test_under_a_v_that_changes_the_pressure_is_not_known() -> None:
    loads = np.array([1e6, 2e6])
    under = replace(model(), changing=ChangingLoad(loads, (model().elements, model().elements), 1e6, 1e6))
    rows = under.reactions(THERE_AND_REST, V=np.array([1e6, 2e6, 1.5e6]))
    assert np.isnan(rows[table().wet]).all() and np.isfinite(rows[~table().wet]).all()


def test_without_a_time_the_pressure_is_not_a_number() -> None:
    """A zero would look like drained soil."""
    bare = replace(model(), elements=elements_of(mixed(n=6), table()))
    rows = bare.reactions(np.array([[1e-3, 0.0]]))
    assert np.isnan(rows[table().wet]).all() and np.isfinite(rows[~table().wet]).all()
    stepper = MemoryStepper(bare)
    stepper.advance(motion=(1e-3, 0.0))
    stepper.commit()
    assert np.isnan(stepper.reactions[table().wet]).all()


def test_between_two_sets_pressure_is_that_of_both_by_their_shares() -> None:
    way = REACH * np.array([[0.1, 0.0], [0.2, -0.1], [-0.1, 0.1]]) / [1.0, LENGTH]
    both = [model(seed) for seed in (1, 2)]
    between = replace(both[0], elements=together([(both[0].elements, 0.3), (both[1].elements, 0.7)]))
    rows = [each.reactions(way)[table().wet] for each in both]
    np.testing.assert_allclose(between.reactions(way)[table().wet], 0.3 * rows[0] + 0.7 * rows[1], rtol=1e-9)
    assert np.abs(rows[0] - rows[1]).max() > 0.1 * np.abs(rows[0]).max()


def test_a_spring_file_keeps_the_water() -> None:
    springs, way = wet.coupled(), REACH * np.array([[0.1, 0.0], [-0.1, 0.01]])
    groups = {node.path: node.to_dataset(inherit=False) for node in springs.tree.subtree}
    groups["/memory"] = memory_dataset(springs, model().elements)
    stored = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    read = build_memory(stored)
    assert has_elements(stored) and has_elements(stored.at(rate=RATE))
    p = groups["/paths/ray_3"]["p_component"]
    wetter = groups["/paths/ray_3"].assign(p_component=p * xr.where(p.component == "water", 1.1, 1.0))
    other = groups | {"/paths/ray_3": wetter}
    assert not has_elements(Springs.of(xr.DataTree.from_dict(other, name="springs")))
    assert read.rate == pytest.approx(RATE)
    np.testing.assert_allclose(read.reactions(way)[table().wet], model().reactions(way)[table().wet], rtol=1e-9)


def test_elements_depend_on_the_water_at_all_rates() -> None:
    """What the digest of one rate has changes with the water of the other; springs at a rate are their own at it."""
    springs = wet.coupled(rates=(RATE, 0.1 * RATE))
    own = digest(springs.at(rate=RATE))
    assert own == digest(springs.at(rate=RATE).at_rate(RATE))
    groups = {node.path: node.to_dataset(inherit=False) for node in springs.tree.subtree}
    path = groups["/paths/ray_3_rate_1"]
    parts = path["p_component"] * xr.where(path.component == "water", 3.0, 1.0)
    net = parts.sum(("side", "component")).transpose("depth", "step").assign_attrs(path["p"].attrs)
    groups["/paths/ray_3_rate_1"] = path.assign(p_component=parts.assign_attrs(path["p_component"].attrs), p=net)
    assert own != digest(Springs.of(xr.DataTree.from_dict(groups, name="springs")).at(rate=RATE))


@pytest.mark.slow
@pytest.mark.usefixtures("few_offered")
def test_calibrated_springs_have_the_pressure_of_a_loop_that_was_held_back() -> None:
    """At half the rate of one set, within 30 % of its largest, which takes the rays at a tenth of that rate.

    With rays at one rate, and with a fan, which goes back on the same curve, it is more than 40 % off. Few elements
    are offered to the calibration.
    """
    found = {}
    for rates in ((RATE, 0.1 * RATE), (RATE,)):
        springs = Springs.of(with_memory(wet.tree(loops=((40.0, 3e-3),), rates=rates)))
        path, own = springs.paths["loop_40"], springs.at(rate=RATE)
        for kind in ("memory", "fan"):
            followed = follow_path(path, MacroModel.from_springs(own, kind))
            found[len(rates), kind] = reaction_errors(followed)["p_water_error_pct"]
        rest = build_memory(own)
        held = np.array([[3e-3, -5e-4], [3e-3, -5e-4]])
        pressure = rest.reactions(held, np.array([30.0, 1e5]))[rest.table.wet]
        assert np.abs(pressure[:, 1]).max() < 1e-3 * np.abs(pressure[:, 0]).max()
    assert found[2, "memory"] < 30.0 < 40.0 < min(found[1, "memory"], found[2, "fan"])
