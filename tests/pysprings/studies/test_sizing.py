# SPDX-License-Identifier: MIT
"""Sizing on the atlas that ships: what is just met, what steel weighs, what cannot be met."""

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import pysprings
from pysprings.core.errors import RunIncomplete, UserInputError
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.full_model.run_record import RunRecord
from pysprings.scene.changes import read_changes
from pysprings.studies import sizing
from pysprings.studies.atlas.model import Atlas
from pysprings.studies.sizing import (
    EDGE,
    Candidate,
    Search,
    Wanted,
    answered,
    bounds_of,
    confirmed,
    correction_of,
    least_confirmed,
    mass_of,
    remarks_on,
    scenes_of,
    table_of,
)
from tests.support.commands import command


@pytest.fixture(scope="module")
def atlas():
    return pysprings.open_atlas("clay")


@pytest.fixture
def search(atlas, tmp_path):
    file = tmp_path / "cases.csv"
    file.write_text("name,H [kN],arm [m],tilt [deg]\nextreme,1500,10,\nservice,800,12,0.05\n", encoding="utf-8")
    changes = tuple(read_changes(["su=20 kPa", "gradient=1.5 kPa/m"]))
    return Search(atlas, Wanted(read_load_cases(file), math.radians(0.5), 0.8, changes, (4.0, 15.0), (1.0, 1.2)))


def test_the_caisson_of_a_ratio_is_just_large_enough(search):
    found = search.just_met(1.0)
    assert found is not None and 0.98 < found.use <= 1.0 and found.L == found.D
    assert search.at(0.99 * found.D, 0.99 * found.L).use > 1.0
    assert len(search.tried) > 3


def test_steel_is_that_of_a_tube_and_a_plate(atlas):
    skirt, lid = math.pi / 4 * (8.0**2 - 7.84**2) * 6.0, math.pi * 4.0**2 * 0.08
    assert mass_of(atlas, 8.0, 6.0) == pytest.approx(7850.0 * (skirt + lid), rel=1e-9)


def test_what_no_caisson_meets_is_refused(atlas, search):
    small = Search(atlas, Wanted(search.wanted.cases, 1e-4, 0.8, search.wanted.changes, (3.0, 4.0), (1.0, 1.1)))
    with pytest.raises(UserInputError, match="no caisson up to D = 4 m"):
        small.least()
    with pytest.raises(UserInputError, match="the atlas has L/D"):
        bounds_of(atlas, (0.1, 0.3))


def test_a_caisson_in_which_torsion_governs_is_no_result(atlas, search, tmp_path):
    """T/R is no bound of a T above half of R times (H, M/D): a larger caisson is, or the cases are refused."""
    found = {}
    for T in (0.0, 6.0, 1e3):
        file = tmp_path / f"{T}.csv"
        rows = f"extreme,1500,10,0.5,{T}\nservice,800,12,0.05,0\n"
        file.write_text(f"name,H [kN],arm [m],tilt [deg],T [MN m]\n{rows}", encoding="utf-8")
        found[T] = Search(atlas, replace(search.wanted, cases=read_load_cases(file)))
    free, twisted = (found[T].just_met(1.1) for T in (0.0, 6.0))
    assert free is not None and twisted is not None and twisted.D > 1.05 * free.D
    cases = found[6.0].wanted.cases
    assert cases.twisted(0.5 * free.D)[0] and not cases.twisted(0.5 * twisted.D).any()
    assert twisted.governs == "extreme: torsion" and twisted.answered and 0.98 < twisted.use <= 1.0
    with pytest.raises(UserInputError, match=r"extreme: torsion governs \(T above half of R times"):
        found[1e3].least()


def test_the_correction_is_what_the_full_model_turns_further():
    table = pd.DataFrame({"rotation_full_rad": [1.1e-3, 0.9e-3], "rotation_atlas_rad": [1.0e-3, 1.0e-3]})
    assert correction_of(table) == pytest.approx(1.1)
    assert correction_of(table.iloc[[1]]) == 1.0


@pytest.fixture
def narrow(search) -> Search:
    """Nearly one ratio: what is searched is searched several times."""
    return Search(search.atlas, replace(search.wanted, ratio=(1.0, 1.02)))


def turned(factor: float) -> Callable[..., pd.DataFrame]:
    """Return full models that turn `factor` times as far as the atlas predicts."""

    def confirmed(atlas: Atlas, wanted: Wanted, candidate: Candidate) -> pd.DataFrame:
        rotation = answered(atlas, wanted, candidate.D, candidate.L)["rotation"].to_numpy()
        tilt = np.where(np.isnan(wanted.cases.tilt), wanted.tilt, wanted.cases.tilt)
        rows = {"name": wanted.cases.name, "rotation_atlas_rad": rotation, "rotation_full_rad": factor * rotation}
        return pd.DataFrame(rows).assign(tilt_used=factor * np.abs(rotation) / tilt)

    return confirmed


@pytest.mark.slow
def test_what_is_returned_is_what_the_full_model_confirms(narrow, monkeypatch):
    monkeypatch.setattr(sizing, "confirmed", turned(1.2))
    best, checked = least_confirmed(narrow)
    assert narrow.correction == pytest.approx(1.2) and (checked["tilt_used"] <= 1.0).all()
    own = answered(narrow.atlas, narrow.wanted, best.D, best.L)["rotation"]
    assert checked["rotation_atlas_rad"].tolist() == own.tolist()


@pytest.mark.slow
def test_what_the_full_model_never_confirms_is_no_result(narrow, monkeypatch):
    monkeypatch.setattr(sizing, "confirmed", turned(np.nan))
    with pytest.raises(RunIncomplete, match=r"not confirmed: after 3 corrections .* 'extreme' at not reached"):
        least_confirmed(narrow)


@pytest.mark.slow
def test_the_full_model_states_the_error_of_its_own_mesh(search, tmp_path, monkeypatch):
    """One case on its extrapolated mesh: the estimate of the run in rotation, beside the error of the atlas."""
    records = []
    of = RunRecord.of
    monkeypatch.setattr(RunRecord, "of", lambda result: records.append(of(result)) or records[-1])
    file = tmp_path / "one.csv"
    file.write_text("name,H [kN],arm [m]\nservice,800,12\n", encoding="utf-8")
    wanted = replace(search.wanted, cases=read_load_cases(file))
    (row,) = confirmed(search.atlas, wanted, Candidate(7.0, 7.0, 0.0, 1.0, "", True)).to_dict("records")
    own = records[-1].error_estimate["by_path"]["case_1"]
    assert row["rotation_mesh_error_pct"] == own["rotation_pct"]
    assert 0.0 < row["rotation_mesh_error_pct"] < 20.0
    assert abs(row["rotation_error_pct"]) < 3.0 * row["rotation_deviation_pct"] + row["rotation_mesh_error_pct"]


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """Two load cases with a V each, in sand."""
    file = tmp_path_factory.mktemp("cases") / "cases.csv"
    text = "name,H [kN],arm [m],V [MN],tilt [deg]\nextreme,1500,10,3,0.5\nservice,800,12,2,0.05\n"
    file.write_text(text, encoding="utf-8")
    wanted = Wanted(read_load_cases(file), math.radians(0.5), 0.8, (), (3.0, 12.0), (1.1, 1.2))
    return Search(pysprings.open_atlas("sand"), wanted)


def test_every_load_case_is_answered_at_its_own_vertical_load(loaded):
    found = answered(loaded.atlas, loaded.wanted, 8.0, 9.0)
    for row, V in enumerate(("3 MN", "2 MN")):
        alone = replace(loaded.wanted.cases, V=np.full(2, np.nan))
        at = replace(loaded.wanted, cases=alone, changes=tuple(read_changes([f"V={V}"])))
        own = answered(loaded.atlas, at, 8.0, 9.0)
        pd.testing.assert_series_equal(found.loc[row], own.loc[row])
    other = replace(loaded.wanted, changes=tuple(read_changes(["V=2.5 MN"])))
    pd.testing.assert_frame_equal(answered(loaded.atlas, other, 8.0, 9.0), found)
    assert len(scenes_of(loaded.atlas, loaded.wanted, 8.0, 9.0)) == 2


def test_diameters_end_where_the_atlas_covers_a_vertical_load_no_more(loaded):
    low, high = loaded.covered(1.15)
    share = loaded.atlas.box[:, 4]  # of V over gamma' D^3
    assert 3e6 / (1e4 * low**3) == pytest.approx(share[1], rel=0.01)
    assert 2e6 / (1e4 * high**3) >= share[0] and low < high
    easy = replace(loaded.wanted, tilt=1.0, utilisation=1.0, cases=replace(loaded.wanted.cases, tilt=np.ones(2)))
    small = replace(easy.cases, H=1e-3 * easy.cases.H, M=1e-3 * easy.cases.M)
    edge = Search(loaded.atlas, replace(easy, cases=small)).just_met(1.15)
    assert edge is not None and (edge.D, edge.governs) == (low, EDGE)


def test_a_range_of_few_diameters_between_two_vertical_loads_is_found(loaded):
    """The atlas covers 1.9 MN up to 9.86 m and 8.5 MN from 9.60 m on."""
    share = loaded.atlas.box[:, 4]
    apart = replace(loaded.wanted, D=(3.0, 20.0), cases=replace(loaded.wanted.cases, V=np.array([1.9e6, 8.5e6])))
    low, high = Search(loaded.atlas, apart).covered(0.6)
    assert low == pytest.approx((8.5e6 / (1e4 * share[1])) ** (1 / 3), rel=1e-3)
    assert high == pytest.approx((1.9e6 / (1e4 * share[0])) ** (1 / 3), rel=1e-3)


def test_a_refusal_names_the_inputs_that_bound_the_diameter(loaded):
    """With E 60 MPa E/(gamma' D) is 640 at D 9.4 m; V of 3 MN asks for D of 7 m."""
    soft = replace(loaded.wanted, tilt=1e-9, cases=replace(loaded.wanted.cases, tilt=np.full(2, 1e-9)))
    soft = replace(soft, changes=tuple(read_changes(["E=60 MPa"])), ratio=(1.1, 1.11))
    with pytest.raises(UserInputError, match=r"where E/\(gamma' D\) and V/\(gamma' D\^3\) leave it"):
        Search(loaded.atlas, soft).least()


def test_a_value_that_no_diameter_covers_is_named(loaded):
    faults = {"mu=0.9": "mu: 0.9 is outside the atlas", "soil.poisson_ratio=0.2": "the atlas holds for 0.3"}
    for value, named in faults.items():
        outside = replace(loaded.wanted, changes=tuple(read_changes([value])), ratio=(1.1, 1.11))
        with pytest.raises(UserInputError, match=named):
            Search(loaded.atlas, outside).least()


def test_remarks_name_the_vertical_load_that_cases_do_not_give_and_what_is_not_judged(atlas, loaded, tmp_path):
    """V of the scene decides in sand; a corner of the atlas and V alone are marked, as answers of `predict` are."""
    file = tmp_path / "cases.csv"
    file.write_text("name,H [kN],arm [m],V [MN]\na,1500,10,\nb,0,0,3\n", encoding="utf-8")
    search = Search(loaded.atlas, replace(loaded.wanted, cases=read_load_cases(file)))
    texts = remarks_on(search, Candidate(7.0, 10.0, 1e5, 0.9, "a: tilt", True), True)
    assert "cases without V are at that of the scene, 2 MN" in texts
    assert [text[:30] for text in texts[:3:2]] == ["V 3 MN: in a corner of the atl", "V 2 MN: in a corner of the atl"]
    assert "b: no lateral load: an atlas judges no V alone" in texts
    assert texts[-1].startswith("the full model confirms the tilt, not the utilisation, on mesh 'coarse'")
    heavy = Search(loaded.atlas, replace(search.wanted, changes=tuple(read_changes(["gamma=25 kN/m^3", "E=200 MPa"]))))
    texts = remarks_on(heavy, Candidate(6.0, 6.0, 1e5, 0.9, "", True), False)
    assert len([text for text in texts if "25 kN/m^3 is outside the common range" in text]) == 1
    inside = Candidate(8.0, 6.0, 1e5, 0.9, "extreme: tilt", True)
    assert remarks_on(replace(loaded, tried=[]), inside, False) == []


def test_a_moment_alone_is_refused_before_the_search(search, tmp_path):
    """Full models are pulled by H. A torsion alone has a bound with an H."""
    file = tmp_path / "cases.csv"
    file.write_text("name,H [kN],M [MN m],T [MN m]\nturned,0,5,0\ntwisted,0,0,1\n", encoding="utf-8")
    apart = replace(search, wanted=replace(search.wanted, cases=read_load_cases(file)), tried=[])
    with pytest.raises(UserInputError, match="load case 'turned' has none"):
        least_confirmed(apart)
    assert apart.tried == []


def test_a_size_that_is_given_is_no_size_to_be_found(search):
    """It had no effect, and no message."""
    own = (*search.wanted.changes, *read_changes(["caisson.outer_diameter=4 m"]))
    with pytest.raises(UserInputError, match="outer_diameter: has a value already"):
        Search(search.atlas, replace(search.wanted, changes=own)).least()


def test_a_use_that_is_not_known_is_blank():
    tried = [Candidate(8.0, 4.0, 1e5, use, "", known) for use, known in ((0.9, True), (15.9, False), (10.0, True))]
    assert table_of(tried)["use"].isna().tolist() == [False, True, True]


def test_the_json_of_the_command_has_units_in_its_keys(tmp_path):
    file = tmp_path / "cases.csv"
    file.write_text("name,H [kN],arm [m]\na,500,2\n", encoding="utf-8")
    best = json.loads(command("size", file, "--atlas", "clay", "--D-min", "7 m", "--D-max", "8 m", "--json").out)[
        "best"
    ]
    assert 7.0 <= best["D_m"] <= 8.0 and best["steel_t"] < 200.0 and best["governs"]
