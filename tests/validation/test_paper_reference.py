# SPDX-License-Identifier: MIT
"""The reference results in data/reference: they can be read, say where they come from, and are still what comes out."""

import numpy as np
import pytest
import xarray as xr

from pysprings.full_model.compute import run
from tests.support import synthetic
from tests.support.place import ROOT
from validation.paper import reference
from validation.paper.cases import Case
from validation.paper.runs import path_of

FOLDER = ROOT / "data" / "reference"
CASES = reference.reference_cases()
NAMES = [case.name for case in CASES]


@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_a_reference_says_where_it_comes_from_and_belongs_to_the_case(case: Case) -> None:
    kept = reference.read(case, FOLDER)
    assert {"command", "pysprings_version", "commit_date", "mesh_preset", "scene_toml"} <= set(kept.attrs)
    assert kept.attrs["scene_sha256"] == case.scene(reference.MESH).sha256, "make reference"
    assert all("units" in kept[name].attrs for name in kept.variables if name != "side")
    assert np.isfinite([float(kept[name].sum()) for name in kept.data_vars]).all()
    assert float(kept["H"][-1]) > float(kept["H"][0]) > 0.0


def test_references_are_small() -> None:
    assert sum(reference.file_of(case, FOLDER).stat().st_size for case in CASES) < 400_000


def test_a_deviation_is_over_the_largest_value() -> None:
    path = path_of(synthetic.make_result((synthetic.Path("pull", size=20e-3, steps=30),)))
    kept = reference.reduced(path)
    assert max(reference.deviations(path, kept).values()) < 1e-6
    moved = path.assign(H=path["H"] + 0.01 * float(path["H"].max()))
    found = reference.deviations(moved, kept)
    assert found.pop("H") == pytest.approx(0.01, rel=0.05)
    assert max(found.values()) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_the_papers_caisson_is_still_what_it_was(case: Case) -> None:
    kept = reference.read(case, FOLDER)
    path: xr.Dataset = path_of(run(case.scene(reference.MESH)))
    apart = reference.deviations(path, kept)
    worst = max(apart, key=lambda name: apart[name])
    assert apart[worst] < reference.TOLERANCE, f"{worst}: {apart[worst]:.2g}; where that is meant: make reference"
