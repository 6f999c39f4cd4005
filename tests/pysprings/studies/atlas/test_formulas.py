# SPDX-License-Identifier: MIT
"""Formulas of springs: the conic of PISA, the choice of terms, files, springs and refusals."""

from __future__ import annotations

import json
import re

import numpy as np
import pandas as pd
import pytest

import pysprings
from pysprings.core.errors import UserInputError
from pysprings.macro.predict import impose
from pysprings.springs.checks import validate_springs
from pysprings.studies.atlas.formulas.curve import conic
from pysprings.studies.atlas.formulas.file import coefficients, read_formulas, write_formulas
from pysprings.studies.atlas.formulas.hyperbolic import chosen
from pysprings.studies.atlas.model import sums
from tests.support.place import ROOT


@pytest.mark.parametrize("curvature", [0.0, 0.2, 0.5, 0.9])
def test_the_conic_satisfies_its_equation_and_its_ends(curvature):
    top, k, reach = 2.0, 5.0, 3.0
    x = np.linspace(1e-6, reach, 50)
    y = conic(x, *(np.array(each) for each in (top, k, reach, curvature)))
    left = -curvature * (y / top - x / reach) ** 2 + (1.0 - curvature) * (y - x * k) / top * (y / top - 1.0)
    assert np.abs(left).max() < 1e-9
    assert y[-1] == pytest.approx(top)
    assert (np.diff(y) >= -1e-12).all()
    assert y[0] / x[0] == pytest.approx(k if curvature < 1.0 else top / reach, rel=1e-3)
    assert conic(-x, *(np.array(each) for each in (top, k, reach, curvature))) == pytest.approx(-y)
    assert float(conic(np.array(10.0), *(np.array(each) for each in (top, k, reach, curvature)))) == top


def test_terms_that_made_values_are_those_chosen():
    basis = np.random.default_rng(1).normal(size=(200, 12))
    y = 3.0 * basis[:, 4] - 0.5 * basis[:, 9]
    found = chosen(basis, y, 1e-3, 12)
    assert list(np.flatnonzero(found)) == [4, 9]
    assert found[[4, 9]] == pytest.approx([3.0, -0.5], rel=1e-6)


@pytest.mark.parametrize("name", ["clay-conic", "clay-hyperbolic", "sand-conic", "sand-hyperbolic"])
def test_shipped_formulas_resist_a_translation_at_all_of_their_full_models(name):
    made = pysprings.open_atlas(name)
    some = made.inputs[::8]
    H, _ = sums(made.form.values(made.terms, made.place(some)))
    assert H.shape == (len(some), len(made.rays), len(made.X))
    assert (H[:, 0] > 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [-46.5, -31.5, 61.5])
def test_a_spring_file_of_conics_carries_what_its_printed_coefficients_do(degrees):
    """Motions in the middle between two rays: the coefficients of the page in their conics, summed over depth."""
    D, L, top, gradient, ratio = 9.0, 6.0, 10e3, 2e3, 300.0  # su_m [Pa], k [Pa/m], G/su
    made = pysprings.open_atlas("clay-conic")
    table = coefficients(made)

    def reaction(spring, z, su, motion):
        own = table[table["spring"] == spring].assign(
            sum=lambda t: t["coefficient"] * (z / L) ** t["power of z/L"] * (L / D) ** t["power of L/D"]
        )
        parameters = own.groupby("parameter")["sum"].sum()
        names = ("ultimate", "stiffness", "reach", "curvature")
        return float(conic(np.array(motion * ratio), *(np.array(parameters[name]) for name in names))) * su

    def loads(u, turn):
        dz, at_tip = L / 8, top + gradient * L
        H = reaction("H_tip", L, at_tip, (u + turn * L) / D) * D**2
        M = L * H + reaction("M_tip", L, at_tip, turn) * D**3 + reaction("M_lid", 0.0, top, turn) * D**3
        H += reaction("H_lid", 0.0, top, u / D) * D**2
        for z in (np.arange(8) + 0.5) * dz:
            su = top + gradient * z
            p = reaction("p", z, su, (u + turn * z) / D) * D
            H, M = H + p * dz, M + (p * z + reaction("m", z, su, turn) * D**2) * dz
        return H, M

    springs = made.springs(made.scene(D, L))
    for rho in (0.001 * D, 0.01 * D):
        u, turn = rho * np.cos(np.radians(degrees)), rho * np.sin(np.radians(degrees)) / L
        answer = impose(springs, u=u, rotation=turn)
        H, M = loads(u, turn)
        size = np.hypot(H, M / L)
        assert float(answer["H"]) == pytest.approx(H, abs=0.01 * size)
        assert float(answer["M"]) / L == pytest.approx(M / L, abs=0.01 * size)


@pytest.mark.slow
def test_springs_of_formulas_are_near_those_of_the_atlas_and_a_spring_file():
    atlas, formulas = (pysprings.open_atlas(name) for name in ("clay", "clay-hyperbolic"))
    made = formulas.springs(formulas.scene(9.0, 6.0))
    validate_springs(made)
    assert made.attrs["source"] == "formulas clay hyperbolic"
    one = pysprings.predict(made, H=1e6, arm=9.0)
    other = pysprings.predict(atlas.springs(atlas.scene(9.0, 6.0)), H=1e6, arm=9.0)
    assert float(one["u"]) == pytest.approx(float(other["u"]), rel=0.05)
    assert float(one["rotation"]) == pytest.approx(float(other["rotation"]), rel=0.05)
    assert float(one["u_deviation"]) > 0.0


def test_springs_of_formulas_outside_their_range_are_refused():
    made = pysprings.open_atlas("clay-conic")
    with pytest.raises(UserInputError, match=r"L/D: 0\.25 is outside"):
        made.springs(made.scene(8.0, 2.0))


def test_files_of_formulas_come_back_and_a_broken_one_is_refused(tmp_path):
    made = pysprings.open_atlas("clay-conic")
    files = write_formulas(made, tmp_path / "mine.json")
    assert [file.suffix for file in files] == [".json", ".csv", ".md"]
    again = read_formulas(files[0])
    assert again.terms == made.terms
    assert len(coefficients(made)) == len(made.terms)
    assert "u + rotation z" in files[2].read_text(encoding="utf-8")
    content = json.loads(files[0].read_text(encoding="utf-8"))
    content["terms"][0][4] = "nan"
    files[0].write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(UserInputError, match="not finite"):
        pysprings.open_atlas(files[0])


@pytest.mark.parametrize("ground", ["clay", "sand"])
@pytest.mark.parametrize("form", ["conic", "hyperbolic"])
def test_what_shipped_formulas_miss_is_that_of_the_evidence(ground, form):
    fitted = pd.read_csv(ROOT / "data/evidence/atlas-formulas-fit.csv").query("ground == @ground and form == @form")
    held = pd.read_csv(ROOT / "data/evidence/atlas-formulas.csv").query("ground == @ground and form == @form")
    about = pysprings.open_atlas(f"{ground}-{form}").about
    assert len(fitted) and len(held)

    def said(key):
        """Percentages of a sentence: two figures."""
        return [float(each) for each in re.findall(r"(\S+) %", about[key])]

    assert said("fitted") == pytest.approx([fitted["rms_pct"].max()], rel=0.06)
    assert said("held back") == pytest.approx(held["largest_pct"].tolist(), rel=0.06)
