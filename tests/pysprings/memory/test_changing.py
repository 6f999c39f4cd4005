# SPDX-License-Identifier: MIT
"""Springs with memory under a vertical load that changes: relaxation, its fit, sequences, and steps."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.core.path_kinds import PARTS
from pysprings.macro.cycles import follow_path, reaction_errors
from pysprings.macro.fan import FanTable
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import MacroWarning, predict, sequence
from pysprings.memory import build
from pysprings.memory.build import CHANGE, build_memory, has_elements, with_memory
from pysprings.memory.calibration import ElementSet
from pysprings.memory.elements import FRICTIONAL, GAP, PLASTIC, REVERSIBLE, STATES, advance, relax
from pysprings.memory.mixture import ChangingLoad, fitted
from pysprings.memory.model import MemorySprings
from pysprings.memory.stepper import MemoryStepper
from pysprings.springs.checks import open_springs, save_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from tests.support import loaded
from tests.support.fans import LENGTH
from tests.support.loaded import HEAVY
from tests.support.vertical import REST, pressed
from tests.support.winkler import element, elements_of, mixed

VIRGIN, RELOADING = 0.8e6, 5e6  # N
LOADS = np.array([REST, HEAVY])
WAY = 1e-3 * np.array([[1.0, 0.2], [3.0, -0.4], [3.0, -0.4], [-1.0, 0.1], [-2.0, 0.3], [2.0, 0.0]]) / [1.0, LENGTH]
V_OF_WAY = np.array([1.0, 1.0, 1.8, 1.8, 1.6, 2.0]) * REST


@cache
def model() -> MemorySprings:
    """Invented elements at two vertical loads, whose forces a V that changes takes away."""
    at = [build_memory(loaded.springs().at(V=V)) for V in LOADS]
    return replace(at[0], changing=ChangingLoad(LOADS, tuple(each.elements for each in at), VIRGIN, RELOADING))


def on_which_v_changes() -> SpringPath:
    """A ray that turns back at rest load, with more V from its 31st state on."""
    path = loaded.springs().paths["turning_0_1"].recorded
    more = np.where(np.arange(path.sizes["step"]) > 30, HEAVY - REST, 0.0)
    given = {name: path[name].copy(data=path[name].values + more) for name in ("V", "V_lid")}
    return SpringPath("turning_0_loads", path.assign(given).assign_attrs({PARTS: 3}), LENGTH)


def alike(rows: list[list[float]], virgin: float = VIRGIN, reloading: float = RELOADING) -> ChangingLoad:
    """Return the same elements at both loads."""
    each = elements_of(np.array(rows), model().table)
    return ChangingLoad(LOADS, (each, each), virgin, reloading)


def test_elements_that_yield_lose_a_share_of_their_force_and_others_nearly_nothing() -> None:
    """exp(-0.5) at the limit, exp(-0.5/256) at half of it; walls that both press keep what both press."""
    lost = []
    for q in (5e-3, 5e-4):  # limits are 1e-3
        for kind, G, B in (
            (PLASTIC, (1.0, 0.0, 1.0), (1e8, 0.0, 1e8)), (GAP, (0.0, 0.0, 0.0), (1.0, 0.0, 1e8)),
            (FRICTIONAL, (1.0, 0.0, 0.5), (1.0, 0.0, 1e8)), (REVERSIBLE, (1.0, 0.0, 1.0), (1e8, 0.0, 1e8)),
        ):  # fmt: skip
            rows, at = np.array([element(kind, G, B, 1e-3)]), np.array([q, 0.0])
            state, F, K = np.zeros((1, STATES)), np.zeros(2), np.zeros((2, 2))
            advance(rows, np.zeros(2), at, state, F, K)
            before = F[0]
            relax(rows, state, at, 0.5)
            advance(rows, at, at, state, F, K)
            lost.append(F[0] / before)
    yields, half = np.exp(-0.5), np.exp(-0.5 / 256.0)
    np.testing.assert_allclose(lost[:2] + lost[3:6] + lost[7:], [yields, yields, 1.0, half, half, 1.0], rtol=1e-12)
    assert lost[2] < 0.75 and lost[6] < 1.0  # walls and friction of one element yield apart
    pressed_ = np.array([element(GAP, (1e-3, 0.0, 0.0), (1.0, 0.0, 1e8), 1e-3)])
    state, F, K = np.zeros((1, STATES)), np.zeros(2), np.zeros((2, 2))
    advance(pressed_, np.zeros(2), np.array([2e-4, 0.0]), state, F, K)
    both = (2e-4 + 1e-3 - state[0, 0]) + (state[0, 1] - 2e-4 + 1e-3)
    relax(pressed_, state, np.array([2e-4, 0.0]), 0.5)
    assert (2e-4 + 1e-3 - state[0, 0]) + (state[0, 1] - 2e-4 + 1e-3) == pytest.approx(both)


def test_a_load_relaxes_under_a_held_motion_where_v_has_not_been() -> None:
    """x^-8 = 1 + 8 dV/V_virgin above all V before, dV/V_reload below; nothing while V goes back and comes again."""
    one = alike([element(d=1e-3)])
    V = REST * np.array([1.0, 1.5, 1.2, 1.5, 2.0, 0.5])
    loads = one.loads_along(np.repeat([[3e-3, 0.0]], len(V), axis=0), V)
    changes = REST * np.array([0.0, 0.5 / VIRGIN, 0.0, 0.0, 0.5 / VIRGIN, 0.5 / RELOADING])
    expected = 1e5 * (1.0 + 8.0 * changes.cumsum()) ** -0.125
    np.testing.assert_allclose(loads[:, 0], expected, rtol=0.01)  # by the steps of V
    np.testing.assert_allclose(loads[2:4], loads[[1, 1]], rtol=1e-12)
    still = one.loads_along(np.repeat([[1e-4, 0.0]], len(V), axis=0), V)
    np.testing.assert_allclose(still[:, 0], 1e4, rtol=1e-6)  # a tenth of what it carries


def test_a_motion_lets_v_take_anew() -> None:
    """V between two loads that it has had takes again (reloading) once the caisson has yielded on, not by cycles."""
    one = alike([element(d=1e-3)])
    V = REST * np.array([1.0, 2.0, 1.0, 2.0, 1.0, 1.0, 2.0])
    u = 1e-3 * np.array([3.0, 3.0, 3.0, 3.0, 3.0, 23.0, 23.0])
    loads = one.loads_along(np.stack([u, 0.0 * u], axis=1), V)[:, 0]
    assert one.sets[0].reach == 0.02 and loads[1] < 0.8 * loads[0] and loads[5] == pytest.approx(loads[0])
    np.testing.assert_allclose(loads[2:5], loads[1], rtol=1e-9)
    assert loads[6] == pytest.approx(loads[5] * (1.0 + 8.0 * REST / RELOADING) ** -0.125, rel=0.01)


def test_strength_at_another_v_comes_with_a_motion_and_goes_at_once() -> None:
    """The heavy set carries twice the load: none of it under a held motion, all after a way; the other way at once."""
    weak, strong = (elements_of(np.array([element(d=1e-3), element(d=1e-3)][:n]), model().table) for n in (1, 2))
    springs = ChangingLoad(LOADS, (weak, strong), np.inf, np.inf)
    V, u = REST * np.array([1.0, 2.0, 2.0, 1.0]), 1e-3 * np.array([3.0, 3.0, 13.0, 13.0])
    loads = springs.loads_along(np.stack([u, 0.0 * u], axis=1), V)[:, 0]
    np.testing.assert_allclose(loads, 1e5 * np.array([1.0, 1.0, 2.0, 1.0]), rtol=1e-3)


def test_a_caisson_moves_on_under_a_held_load_and_comes_to_rest() -> None:
    """Along the load, where V has not been; 50 cycles of V add nothing; without relaxation elements stay."""
    drive, aims = model().equations("load", np.repeat([[2e5, -1e5]], 104, axis=0), 0.0)
    V = REST * np.array([1.0, 2.0, *[1.0, 2.0] * 50, 1.0, 0.5])
    rows = [element(d=1e-3, gain=10.0, over=1e-3), element(d=1.0, B=(1e6, 0.0, 1e6))]
    motions, loads, _ = alike(rows).follow(drive, aims, V)
    np.testing.assert_allclose(loads, aims, rtol=1e-6)
    ways = np.hypot(*motions.T)
    assert ways[1] > 1.2 * ways[0] and ways[-1] > 1.02 * ways[-2]
    np.testing.assert_allclose(ways[2:-1], ways[1], rtol=0.02)
    assert ways[-2] - ways[50] < 1e-3 * ways[1]
    np.testing.assert_allclose(motions[:, 0] / motions[:, 1], aims[:, 0] / aims[:, 1], rtol=1e-6)
    still, _, _ = alike(rows, np.inf, np.inf).follow(drive, aims, V)
    np.testing.assert_allclose(still, np.repeat(still[:1], 104, axis=0), rtol=1e-9)


def test_rows_on_the_way_between_two_loads_change_nothing() -> None:
    """H, M and V grow in proportion between rows: rows on the way lead to the state to which one does."""
    rows = np.array([[2e5, 6e5, 1.0], [-1e5, -3e5, 1.0], [3e5, 9e5, 1.6], [0.0, 0.0, 2.0], [1e5, 0.0, 1.2]])
    fine = np.concatenate([a + np.arange(1, 101)[:, None] / 100 * (b - a) for a, b in pairwise([[0, 0, 1.0], *rows])])
    once, often = (model().solve("load", each[:, :2], V=each[:, 2] * REST)[0] for each in (rows, fine))
    np.testing.assert_allclose(once, often[99::100], rtol=0.02)


def test_at_a_constant_v_they_are_the_elements_between_both_loads() -> None:
    """Motions, loads, reactions and tangents of the shares, though all sets follow; but for the division of steps."""
    changing, V, way = model().changing, 1.3 * REST, 0.1 * WAY  # in steps that are hardly divided
    assert changing is not None
    between, given = build_memory(loaded.springs().at(V=V)), np.full(len(way), V)
    motions, expected = way * between.to_motion, between.solve("state", way)[1] / between.to_motion
    loads, tangents = changing.loads_along(motions, given), changing.tangents(motions, given)
    np.testing.assert_allclose(loads, expected, atol=1e-3 * np.abs(expected).max())
    scaled = between.tangents(way) / between.to_motion / between.to_motion[:, None]
    np.testing.assert_allclose(tangents, scaled, atol=1e-3 * np.abs(scaled).max())
    found = changing.reactions(motions, given)
    np.testing.assert_allclose(found, between.reactions(way), atol=1e-3 * np.abs(found).max())
    drive, aims = between.equations("load", expected * between.to_motion, 0.0)
    np.testing.assert_allclose(changing.follow(drive, aims, given)[0], motions, atol=2e-3 * np.abs(motions).max())


def test_loads_that_a_motion_has_lead_back_to_it() -> None:
    """With V that changes: the motion is imposed, then its loads."""
    _, loads, _ = model().solve("state", WAY, V=V_OF_WAY)
    states, found, message = model().solve("load", loads, V=V_OF_WAY)
    assert not message
    np.testing.assert_allclose(found, loads, atol=1.0)
    np.testing.assert_allclose(states[:2], WAY[:2], atol=0.005 * np.abs(WAY[:, 0]).max())  # by the division of steps
    assert np.abs(model().solve("state", WAY)[1] - loads).max() > 0.05 * np.abs(loads).max()


def test_every_load_below_capacity_has_an_answer_while_v_changes() -> None:
    random = np.random.default_rng(5)
    for _ in range(30):
        way = np.cumsum(random.normal(scale=1e-3, size=(8, 2)), axis=0) / [1.0, LENGTH]
        V = REST * random.choice([1.0, 1.4, 2.0], size=8)
        loads = 0.8 * model().solve("state", way, V=V)[1]
        _, found, message = model().solve("load", loads, V=V)
        assert not message
        np.testing.assert_allclose(found, loads, atol=1.0)


def test_a_load_beyond_what_they_carry_ends_where_it_was_last_carried() -> None:
    """A perfectly plastic element: the states before it, and a sentence; a stepper refuses and stays."""
    weak = replace(model(), changing=alike([element(d=1e-3)]))
    loads, V = np.array([[5e4, 0.0], [8e4, 0.0], [3e5, 0.0], [5e4, 0.0]]), REST * np.array([1.0, 1.1, 1.2, 1.3])
    states, carried, message = weak.solve("load", loads, V=V)
    assert len(states) == 2 and "H = " in message
    np.testing.assert_allclose(carried, loads[:2], atol=1.0)
    stepper = MemoryStepper(weak)
    with pytest.raises(BeyondSprings, match="the elements carry no more than H = "):
        stepper.advance(load=(3e5, 0.0), V=1.2 * REST)
    np.testing.assert_allclose(stepper.advance(load=(8e4, 0.0)), [8e-4, 0.0], atol=1e-9)


def test_a_path_on_which_v_changes_is_followed_under_its_v() -> None:
    """Loads and errors of the reactions are those of elements that follow V."""
    path = on_which_v_changes()
    found = follow_path(path, whole())
    motions = np.stack([path.u, path.rotation], axis=1)
    np.testing.assert_allclose(found.macro[1], model().solve("state", motions, V=path.given_loads)[1], rtol=1e-12)
    p = model().table.name == "p"
    rows = model().reactions(motions, V=path.given_loads)[p]
    full = path.p - path.p[:, :1]
    error = 100.0 * np.abs(rows - full).max() / np.abs(full).max()
    assert reaction_errors(found)["p_error_pct"] == pytest.approx(error, rel=1e-9)


def test_a_fit_finds_what_paths_were_made_with() -> None:
    """V_virgin and V_reload within 5 %; where no V is larger than before both are V_reload."""
    changing = model().changing
    assert changing is not None
    motions = 1e-3 * np.array([[1.0, -0.5], [1.0, -0.5], [-1.0, 0.5], [-1.0, 0.5], [1.0, -0.5], [1.0, -0.5]])
    V = REST * np.array([1.0, 2.0, 2.0, 1.0, 1.0, 2.0])
    found = fitted(LOADS, changing.sets, [(motions, changing.loads_along(motions, V), V)])
    assert (found.virgin, found.reloading) == (pytest.approx(VIRGIN, rel=0.05), pytest.approx(RELOADING, rel=0.05))
    back = fitted(LOADS, changing.sets, [(motions[1:], changing.loads_along(motions[1:], V[1:]), V[1:])])
    assert back.virgin == back.reloading == pytest.approx(RELOADING, rel=0.05)


def whole() -> MacroModel:
    return replace(MacroModel.from_springs(loaded.springs(), "memory", V=REST), response=model())


def test_states_within_the_loads_are_not_marked_and_w_follows_v() -> None:
    """Beyond them they are, from there on; w is that of the vertical springs with a history beside the elements'."""
    answer = sequence(whole(), WAY, control="state", V=V_OF_WAY, extrapolate=True)
    assert not answer["off_load"].any() and answer.attrs["warnings"] == []
    assert "follow a V that changes: on sequences held back" in answer.attrs["remarks"][-1]
    np.testing.assert_allclose(answer["H"], model().solve("state", WAY, V=V_OF_WAY)[1][:, 0], rtol=1e-12)
    p = model().reactions(WAY, V=V_OF_WAY)[model().table.name == "p"]
    np.testing.assert_allclose(answer["p"], p, rtol=1e-12)
    np.testing.assert_allclose(answer["stiffness"][:, ::2, ::2], model().tangents(WAY, V_OF_WAY), rtol=1e-9)
    with pytest.warns(MacroWarning, match="4 of 6 states are under another V .* at the nearest load"):
        beyond = sequence(whole(), WAY, control="state", V=V_OF_WAY * [1, 1, 0.4, 1, 1, 1], extrapolate=True)
    np.testing.assert_array_equal(beyond["off_load"], [0, 0, 1, 1, 1, 1])
    still = np.repeat(1e-9 * WAY[:1], 3, axis=0)
    V, down = REST * np.array([1.0, 1.5, 1.0]), whole().vertical
    assert down is not None
    w = sequence(whole(), still, control="state", V=V, extrapolate=True)["w"]
    np.testing.assert_allclose(w, down.history(V)[0], atol=1e-12)


def test_the_utilisation_is_that_at_the_vertical_load_of_each_state() -> None:
    """The heavy springs carry twice the load; beyond all loads it is that at the nearest, which the words name."""
    load, V = np.array([[1e5, 1e5]]), np.array([REST, HEAVY, 1.04 * REST, 0.5 * REST, REST])
    with pytest.warns(MacroWarning):
        answer = sequence(whole(), np.repeat(load, 5, axis=0), V=V, extrapolate=True)
    alone = [predict(loaded.springs(), H=load[0, 0], M=load[0, 1], V=at) for at in (REST, HEAVY)]
    one, two = (float(each["utilisation"]) for each in alone)
    np.testing.assert_allclose(answer["utilisation"], [one, two, one, one, one], rtol=1e-2)  # of 1.04 what V leaves
    assert one == pytest.approx(2.0 * two, rel=1e-3)
    assert answer.attrs["capacity_H_N"] == pytest.approx(alone[0].attrs["capacity_H_N"])
    assert "not at this V" not in answer.attrs["capacity_from"] and answer["off_load"].values[-1] == 1
    with pytest.warns(MacroWarning):
        beyond = sequence(whole(), np.repeat(load, 4, axis=0), V=V[:4], extrapolate=True)
    assert "; at V = 2 MN of the springs, not at this V" in beyond.attrs["capacity_from"]


def test_a_stepper_follows_v_as_a_sequence_does() -> None:
    """Motions, loads and reactions; a trial leaves no trace; V stays where none is given."""
    stepper = MemoryStepper(model())
    _, loads, _ = model().solve("state", WAY, V=V_OF_WAY)
    rows = model().reactions(WAY, V=V_OF_WAY)
    for k, (state, V) in enumerate(zip(WAY, V_OF_WAY, strict=True)):
        stepper.advance(motion=(4e-3, 0.0), V=1.9 * REST)  # tried, and forgotten
        given = None if V == stepper.V else V
        np.testing.assert_allclose(stepper.advance(motion=tuple(state), V=given), loads[k], rtol=1e-9)
        found = stepper.reactions
        np.testing.assert_allclose(found, rows[:, k], atol=3e-3 * np.abs(rows).max())  # by the division of steps
        assert stepper.marks.off_load in (None, False)
        stepper.commit()
        assert pytest.approx(V) == stepper.V
    assert pytest.approx(2.0 * REST) == stepper.past.top and np.abs(stepper.offset).max() > 0.0
    np.testing.assert_allclose(stepper.reactions, found, atol=1e-9 * np.abs(rows).max())
    w = list(model().table.name).index("w")
    assert abs(found[w] - rows[w, -1]) < 0.02 * np.ptp(rows[w])
    stepper.advance(motion=tuple(WAY[-1]), V=3.0 * REST)
    assert stepper.marks.off_load is True


@pytest.mark.parametrize("step", [{"motion": (1e-3,)}, {"motion": (np.nan, 0.0)}, {"load": (1e5, 0.0, 0.0)}])
def test_a_step_of_other_than_two_numbers_is_refused(step) -> None:
    with pytest.raises(UserInputError, match=r"give two numbers|not a finite number"):
        MemoryStepper(model()).advance(**step)


def test_the_tangent_of_a_step_on_which_v_changes_is_its_derivative() -> None:
    stepper = MemoryStepper(model())
    stepper.advance(motion=(2e-3, -3e-4))
    stepper.commit()
    aim, change = stepper.motion + [1e-5, -2e-6], np.array([1e-9, 3e-10])
    for V, off in ((1.0001 * REST, 1e-4), (1.02 * REST, 0.1)):  # by the division of the step
        ends = [stepper.advance(motion=tuple(aim + sign * change), V=V) for sign in (1.0, -1.0)]
        stepper.advance(motion=tuple(aim), V=V)
        found = stepper.tangent @ (2.0 * change)
        np.testing.assert_allclose(ends[0] - ends[1], found, atol=off * np.abs(found).max())


def test_springs_keep_what_a_changing_v_does_until_their_paths_change(tmp_path, monkeypatch) -> None:
    """Fitted once to the path on which V changes, which is no ray of the elements; not without such a path."""
    made: list[int] = []

    def invented(_ways: object, table: FanTable, _stiffness: object, others: object) -> ElementSet:
        return elements_of(mixed(n=2), table)

    def fit(loads: np.ndarray, sets: tuple[ElementSet, ...], paths: list[tuple[np.ndarray, ...]]) -> ChangingLoad:
        made.append(len(paths))
        assert all(len(np.unique(V)) > 1 for _, _, V in paths)
        return ChangingLoad(loads, sets, VIRGIN, RELOADING)

    monkeypatch.setattr(build, "calibrate", invented)
    monkeypatch.setattr(build, "fitted", fit)
    bare = {
        node.path: node.to_dataset(inherit=False) for node in loaded.springs().tree.subtree if "memory" not in node.path
    }
    assert build_memory(Springs.of(xr.DataTree.from_dict(bare)).at(V=REST)).changing is None
    groups = bare | {"/paths/turning_0_loads": on_which_v_changes().recorded}
    tree = xr.DataTree.from_dict(groups, name="springs")
    assert [one.name for one in Springs.of(tree).at(V=REST).remembering] == ["turning_0_1", "turning_50_1"]
    stored = Springs.of(open_springs(save_springs(with_memory(tree), tmp_path / "springs.nc")))
    assert made == [1] and list(stored.memory) == ["memory", "memory_load_1", CHANGE]
    found = build_memory(stored.at(V=1.5 * REST)).changing
    assert found is not None and (found.virgin, found.reloading, made) == (VIRGIN, RELOADING, [1])
    kept = {node.path: node.to_dataset(inherit=False) for node in stored.tree.subtree}
    lacking = Springs.of(xr.DataTree.from_dict({name: data for name, data in kept.items() if CHANGE not in name}))
    assert has_elements(stored.at(V=REST)) and not has_elements(lacking.at(V=REST))
    timed = {name: data.assign(time=("step", np.arange(data.sizes["step"]) / 10.0)) if "step" in data.dims else data
             for name, data in kept.items()}  # fmt: skip
    timed["/"] = timed["/"].assign_attrs(drainage="coupled")
    at_rate = Springs.of(xr.DataTree.from_dict(timed, name="springs"))
    assert at_rate.rate_sets and build_memory(at_rate.at(V=REST)).changing is None
    path, ray = kept["/paths/turning_0_loads"], kept["/paths/ray_0_2"]
    for number, change in enumerate(
        (
            {"/paths/turning_0_loads": pressed(path, 1.1 * REST)},
            {
                "/paths/turning_0_loads": path.assign(
                    V=path["V"].copy(data=np.where(path["V"] > REST, 1.01, 1.0) * path["V"])
                )
            },
            {"/paths/ray_0_2": pressed(ray, 1.001 * REST).assign(V=ray["V"])},
        ),
        2,
    ):
        build_memory(Springs.of(xr.DataTree.from_dict(kept | change, name="springs")).at(V=REST))
        assert len(made) == number
    monkeypatch.setattr(build, "RENEWED", 0.2)  # of another law
    assert build_memory(stored.at(V=REST)).changing is not None and len(made) == number + 1


def test_a_stored_state_goes_on_as_the_stepper_that_it_is_from() -> None:
    """At another V than that of the model: state, motion, load, past, offset and way are all that it needs."""
    first, other = MemoryStepper(model()), MemoryStepper(model())
    first.advance(motion=(1e-3, -2e-4), V=1.6 * REST)
    first.commit()
    for name in ("state", "motion", "load", "past", "offset", "way"):
        setattr(other, name, getattr(first, name))
    for given in ({}, {"V": 1.6 * REST}, {"V": 1.2 * REST}):
        loads = [each.advance(motion=(2e-3, -1e-4), **given) for each in (first, other)]
        np.testing.assert_allclose(loads[0], loads[1], rtol=1e-12)
        np.testing.assert_allclose(first.reactions, other.reactions, rtol=1e-12)
    first.commit()
    still = first.tangent
    first.advance(motion=tuple(first.motion))
    np.testing.assert_allclose(first.tangent, still, rtol=1e-12)


def test_w_counts_from_the_vertical_load_that_a_sequence_starts_at() -> None:
    """Between both loads, at rest: w is that of the vertical springs, though the elements are those at rest load."""
    still, down = np.repeat(1e-9 * WAY[:1], 3, axis=0), whole().vertical
    assert down is not None
    for V in (REST * np.array([1.4, 1.7, 1.4]), REST * np.array([1.0, 1.3, 1.5])):
        w = sequence(whole(), still, control="state", V=V, extrapolate=True)["w"]
        np.testing.assert_allclose(w, down.history(V)[0], atol=1e-9)


def test_a_constant_v_of_a_model_at_another_one_is_followed() -> None:
    """The answer of the elements at that V, without a mark."""
    V = 1.5 * REST
    answer = sequence(whole(), WAY, control="state", V=V, extrapolate=True)
    expected = build_memory(loaded.springs().at(V=V)).solve("state", WAY)[1]
    np.testing.assert_allclose(answer["H"], expected[:, 0], atol=0.01 * np.abs(expected[:, 0]).max())
    assert not answer["off_load"].any() and answer.attrs["warnings"] == []
    assert "follow a V" not in " ".join(answer.attrs["remarks"])


def test_without_vertical_springs_states_that_follow_v_have_no_mark() -> None:
    """The elastic vertical stiffness answers w, and is named; beyond the loads the lateral springs are, too."""
    bare = replace(whole(), vertical=None)
    with pytest.warns(MacroWarning) as caught:
        answer = sequence(bare, WAY, control="state", V=V_OF_WAY, extrapolate=True)
    assert not answer["off_load"].any() and not any("lateral springs unchanged" in str(one.message) for one in caught)
    with pytest.warns(MacroWarning) as caught:
        beyond = sequence(bare, WAY, control="state", V=1.2 * V_OF_WAY, extrapolate=True)
    assert "lateral springs are those at the nearest load" in str(caught[-1].message)
    assert beyond["off_load"].values[-1] == 1 and "unchanged" not in str(caught[0].message)
