# SPDX-License-Identifier: MIT
"""Every row by itself: no order, split, repetition or neighbour of a table changes an answer or a mark by one bit."""

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from pysprings import open_atlas
from pysprings.core.tables.load_cases import LoadCases
from pysprings.macro.batch import answer_loads, predict_batch
from pysprings.macro.predict import predict
from pysprings.scene.changes import read_changes
from pysprings.springs.springs import Springs
from pysprings.studies.design import answer_cases
from pysprings.studies.sizing import Search, Wanted, answered
from tests.support.fans import fan_springs, potential
from tests.support.vertical import REST, fan_with_vertical, vertical_springs

LOADS = np.array([0.5, 1.0, 1.004, 1.3, 2.0, 3.1, 4.0, 4.2, -0.3]) * REST


@cache
def springs(name: str) -> tuple[Springs, dict]:
    """Return springs under several vertical loads, under one, without vertical paths, and of one path."""
    made = {
        "loads": lambda: vertical_springs(heavier=(2 * REST, 4 * REST)),
        "fan": fan_with_vertical,
        "bare": lambda: fan_springs(potential, held_back=(2.0,)),
        "path": lambda: fan_springs(potential, held_back=(2.0,)),
    }
    return Springs.of(made[name]()), {"path": "pull_2", "springs_kind": "full"} if name == "path" else {}


def table(random: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return loads (n, 2) and vertical loads (n,) as a user mixes them: blank V, V close to each other, directions."""
    H = random.choice([0.0, 2e4, -3e5, 1e6, 5e6], n) * random.choice([1.0, 1.0 + 1e-10, 1.2], n)
    M = H * random.choice([-2.0, -40.0, 3.0, 0.0], n) + random.choice([0.0, 0.0, 1e6], n)
    V = random.choice(LOADS, n) * random.choice([1.0, 1.0 + 1e-12, 0.995, 1.0005], n)
    return np.stack([H, M], axis=1), np.where(random.random(n) < 0.2, np.nan, V)


@pytest.mark.parametrize("kind", ["loads", "fan", "bare", "path"])
def test_no_answer_depends_on_its_neighbours(kind: str) -> None:
    """60 random tables of each set of springs: a part of 40 rows in any order, some twice, is answered as alone."""
    given, choice = springs(kind)
    random = np.random.default_rng(11)
    loads, V = table(random, n=40)
    for extrapolate in (False, True):
        each = [answer_loads(given, loads[[k]], V[[k]], extrapolate, **choice) for k in range(len(V))]
        alone = {name: np.concatenate([answer[name].values for answer in each]) for name in each[0].data_vars}
        for _ in range(30):
            rows = random.integers(0, len(V), random.integers(4, 16))
            answer = answer_loads(given, loads[rows], V[rows], extrapolate, **choice)
            assert set(answer.data_vars) == set(alone)
            for name, values in alone.items():
                np.testing.assert_array_equal(answer[name].values, values[rows], err_msg=str(name))


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 0, 2), (2, 0, 1)])
def test_a_v_without_springs_is_marked_in_every_order(order: tuple[int, ...]) -> None:
    """Of springs at one V a case at another V is supported in part, whatever stands in the middle of the table."""
    V = np.array([REST, 1.5 * REST, 0.1 * REST])[list(order)]
    batch = predict_batch(springs("fan")[0], H=1e5, arm=2.0, V=V)
    np.testing.assert_array_equal(batch["off_load"], (V != REST).astype(int))


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
def test_every_v_has_its_own_springs() -> None:
    """V that differ by less than 1 % are answered as `predict` answers each of them."""
    given = springs("loads")[0]
    V = np.array([2.6, 2.61, 2.62]) * 1e6
    batch = predict_batch(given, H=3e5, arm=2.0, V=V)
    alone = [float(predict(given, H=3e5, arm=2.0, V=float(each))["u"]) for each in V]
    np.testing.assert_allclose(batch["u"], alone, rtol=1e-9)
    assert len(set(batch["u"].values)) == 3
    assert not batch["off_load"].any()


def cases_of(random: np.random.Generator, n: int) -> LoadCases:
    """Return load cases with blanks, moments across, torsion, and some that are equal but for their name."""
    loads, V = table(random, n)
    T, across = random.choice([0.0, 0.0, 2e5], n), random.choice([0.0, 0.0, -4e5], n)
    tilt, nothing = random.choice([np.nan, 1e-4], n), np.zeros(n)
    names = tuple(f"case {k}" for k in range(n))
    return LoadCases("", names, ("",) * n, np.arange(n), *loads.T, V, nothing, tilt, across, T, ("",) * n)


def part(cases: LoadCases, rows: np.ndarray) -> LoadCases:
    """Return some of the cases, in another order."""
    values = {each.name: getattr(cases, each.name) for each in fields(cases)}
    chosen = {name: tuple(np.array(x, dtype=object)[rows]) for name, x in values.items() if isinstance(x, tuple)}
    return LoadCases(**values | {name: x[rows] for name, x in values.items() if isinstance(x, np.ndarray)} | chosen)


@pytest.mark.parametrize("kind", ["loads", "fan"])
def test_design_judges_a_row_by_itself(kind: str) -> None:
    """60 random tables of each: the answer, mark, bound and verdict of a row are those of the row alone."""
    random = np.random.default_rng(12)
    cases = cases_of(random, n=25)
    alone = pd.concat([answer_cases(springs(kind)[0], part(cases, np.array([k])), 1e-3) for k in range(len(cases))])
    for _ in range(60):
        rows = random.integers(0, len(cases), random.integers(4, 16))
        found, wanted = answer_cases(springs(kind)[0], part(cases, rows), 1e-3), alone.iloc[rows]
        pd.testing.assert_frame_equal(found, wanted.reset_index(drop=True), check_exact=True)


def test_size_judges_a_row_by_itself() -> None:
    """40 random tables: the answers of an atlas to a caisson, and what governs, in any order and any part."""
    atlas, random = open_atlas("clay"), np.random.default_rng(13)
    cases = cases_of(random, n=16)
    cases = replace(cases, V=random.choice([np.nan, 1e6, 1.004e6], 16))
    wanted = Wanted(cases, 5e-3, 0.8, tuple(read_changes(["su=20 kPa", "gradient=1.5 kPa/m"])))
    alone = pd.concat([answered(atlas, replace(wanted, cases=part(cases, np.array([k]))), 8.0, 8.0) for k in range(16)])
    for turn in range(40):
        rows = random.permutation(16)[: random.integers(1, 4)]
        of_rows = replace(wanted, cases=part(cases, rows))
        found = answered(atlas, of_rows, 8.0, 8.0)
        pd.testing.assert_frame_equal(found, alone.iloc[rows].reset_index(drop=True), check_exact=True)
        if turn < 4:
            turned = replace(wanted, cases=part(cases, rows[::-1]))
            assert Search(atlas, of_rows).at(8.0, 8.0) == Search(atlas, turned).at(8.0, 8.0)
