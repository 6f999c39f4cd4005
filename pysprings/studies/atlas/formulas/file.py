# SPDX-License-Identifier: MIT
"""Files of formulas: JSON that `--atlas` reads, a table of the coefficients (CSV), a page to quote (Markdown)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pysprings.core.errors import refused
from pysprings.core.files.storage import write_text
from pysprings.core.text import markdown_table
from pysprings.core.version import __version__
from pysprings.scene.load import SceneText
from pysprings.studies.atlas.families import FAMILIES
from pysprings.studies.atlas.formulas import FORMS
from pysprings.studies.atlas.formulas.base import LATERAL, Term
from pysprings.studies.atlas.formulas.model import FACTORS, Formulas

POOR = 10.0  # root mean square error [%] from which the page warns
SCHEMA = "pysprings-formulas-1"
_NUMBERS = ("X", "angles", "reach", "factor", "stiffness_rest")


def write_formulas(formulas: Formulas, file: Path, errors: pd.DataFrame | None = None) -> list[Path]:
    """Write FILE.json, FILE.csv and FILE.md; return their paths. `errors` are those of held-back caissons."""
    content: dict[str, Any] = {
        "schema": SCHEMA, "source": f"pysprings {__version__}", "family": formulas.family.name,
        "form": formulas.form.name, "about": dict(formulas.about), "rays": list(formulas.rays),
        "fan": list(formulas.fan), "inputs": formulas.inputs.tolist(), "rest": formulas.rest.tolist(),
    }  # fmt: skip
    content |= {name: np.asarray(getattr(formulas, name)).tolist() for name in _NUMBERS}
    content["terms"] = [
        [each.spring, each.ray, each.parameter, list(each.powers), float(f"{each.value:.8g}")]
        for each in formulas.terms
    ]
    content["scene_toml"] = formulas.text.text
    table = file.with_suffix(".csv")
    write_text(json.dumps(content) + "\n", file)
    write_text(coefficients(formulas).to_csv(index=False, float_format="%.8g", lineterminator="\n"), table)
    page = file.with_suffix(".md")
    write_text(page_text(formulas, errors, table.name), page)
    return [file, table, page]


def read_formulas(file: Path) -> Formulas:
    """Read formulas. Raises UserInputError for another or a broken file."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise refused(None, "there is no such file", file) from None
    except (OSError, ValueError) as error:
        raise refused(None, f"cannot be read as formulas (JSON): {error}", file) from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise refused(None, f"holds no formulas ({SCHEMA}); `pysprings atlas --form` makes them of a study", file)
    try:
        return _formulas(content, file)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise refused(None, f"broken formulas: {type(error).__name__} {error}", file) from None


def _formulas(content: dict[str, Any], file: Path) -> Formulas:
    form = FORMS.find(str(content["form"]), "form")
    family = FAMILIES.find(str(content["family"]), "family")
    inputs = np.array(content["inputs"], dtype=float).reshape(-1, len(family.labels))
    terms = tuple(Term(str(s), str(r), str(p), tuple(map(int, q)), float(v)) for s, r, p, q, v in content["terms"])
    rest = np.array(content["rest"], dtype=float).reshape(2, len(content["rays"]), len(content["X"]))
    if not all(np.isfinite(each).all() for each in (inputs, rest, [term.value for term in terms])):
        raise ValueError("a number is not finite")
    errors = [float(each) for each in content["stiffness_rest"]]
    return Formulas(
        family=family, text=SceneText(str(content["scene_toml"]), f"base scene of {file.name}"), inputs=inputs,
        rays=tuple(content["rays"]), angles=np.array(content["angles"], dtype=float),
        X=np.array(content["X"], dtype=float), reach=float(content["reach"]), rest=rest,
        factor=float(content["factor"]), fan=(float(content["fan"][0]), float(content["fan"][1])),
        about=content["about"], form=form, terms=terms, stiffness_rest=(errors[0], errors[1], errors[2]),
    )  # fmt: skip


def coefficients(formulas: Formulas) -> pd.DataFrame:
    """Return all terms, a row each: spring, ray, parameter, a power of each variable, value."""
    names = formulas.form.variables(len(formulas.family.labels))
    widest = ("z/L", "h", *(f"x{k + 1}" for k in range(len(formulas.family.labels))))
    rows = []
    for term in formulas.terms:
        own = names if term.spring in LATERAL else widest
        powers = dict(zip(own, term.powers, strict=True))
        rows.append({"spring": term.spring, "ray": term.ray, "parameter": term.parameter}
                    | {f"power of {name}": powers.get(name, 0) for name in dict.fromkeys((*names, *widest))}
                    | {"coefficient": term.value})  # fmt: skip
    return pd.DataFrame(rows)


def page_text(formulas: Formulas, errors: pd.DataFrame | None, table: str) -> str:
    """Return the page to quote: sizes, formulas, range, errors; coefficients in full where they are few."""
    words, family = formulas.family.symbols, formulas.family
    parts = [
        f"# Springs by formulas: {family.name}, {formulas.form.label}",
        f"{len(formulas.inputs)} full models; {formulas.about.get('title', '')}, "
        f"mesh {formulas.about.get('mesh', '')}. Made by pysprings {__version__}.",
        "## Sizes", _sizes(formulas),
        "## Formulas", "\n".join(formulas.form.formula), _stiffness_text(formulas),
        "## Range", "Outside it the formulas do not hold; pysprings refuses.",
        markdown_table(["input", "least", "largest", "even form", "x = -1 at", "x = 1 at"], _range(formulas)),
        f"Motions: {words.X} up to {formulas.X[-1]:.4g}, and rho = sqrt(u^2 + (rotation L)^2) up to "
        f"{formulas.reach:.3g} D.",
    ]  # fmt: skip
    parts += ["## Errors", *_errors(errors)]
    lateral = coefficients(formulas)
    few = lateral[lateral["spring"].isin(LATERAL)]
    parts += [
        "## Coefficients",
        f"All {len(lateral)} terms: `{table}`, columns spring, ray, parameter, powers, coefficient.",
    ]
    if len(few) <= 120:
        few = few.loc[:, [name for name in few.columns if not (name.startswith("power") and (few[name] == 0).all())]]
        few = few.drop(columns="ray")
        cells = [[f"{v:.5g}" if isinstance(v, float) else str(v) for v in row] for row in few.itertuples(index=False)]
        parts.append(markdown_table(list(few.columns), cells))
    return "\n\n".join(parts) + "\n"


def _sizes(formulas: Formulas) -> str:
    words = formulas.family.symbols
    return "\n".join([
        f"- p over {words.stress} D, m over {words.stress} D^2, H_tip and M_tip over {words.stress} at z = L "
        f"times D^2 and D^3, H_lid and M_lid over {words.lid} times D^2 and D^3.",
        "- p and m are per metre of depth, z downwards from mudline.",
        f"- Motions of a spring: y {words.stiffness}/(s D) with y = u + rotation z, rotation {words.stiffness}/s, "
        "s the stress that its reaction is over.",
        f"- X = {words.X}, h = X/(1 + X).",
        "- L/D, z/L as they are; x1, x2, ... see the range.",
    ])  # fmt: skip


def _stiffness_text(formulas: Formulas) -> str:
    names = "K_V" if formulas.form.own_stiffness else ", ".join(FACTORS)
    text = f"Initial stiffness over F r/D, F = s D (L + D), r = X D/rho: rows {names}; K_V = exp(K_V)"
    if formulas.form.own_stiffness:
        return text + "; the lateral stiffness is that of the springs at rest."
    return text + (
        ", and the lateral stiffness for (u, rotation L) is A A^T with A = [[a, 0], [b a, c]], a = exp(K_a), b = K_b, "
        "c = exp(K_c)."
    )


def _range(formulas: Formulas) -> list[list[str]]:
    family = formulas.family
    low, high = formulas.box
    even = family.even(formulas.inputs)
    names = family.symbols.even or family.labels
    return [
        [
            label,
            f"{a:.4g}",
            f"{b:.4g}",
            f"x{k + 1} from {names[k]}",
            f"{even[:, k].min():.6g}",
            f"{even[:, k].max():.6g}",
        ]
        for k, (label, a, b) in enumerate(zip(family.labels, low, high, strict=True))
    ]


def _errors(errors: pd.DataFrame | None) -> list[str]:
    if errors is None:
        return ["Not checked on held-back caissons."]
    cells = [[f"{v:.3g}" if isinstance(v, float) else str(v) for v in row] for row in errors.itertuples(index=False)]
    worst = float(errors["rms_pct"].max())
    poor = f"The root mean square error is up to {worst:.0f} %: these springs are not for a design. " * (worst > POOR)
    return [f"{poor}Of held-back caissons, in per cent, beside full models on the same mesh:",
            markdown_table([str(name) for name in errors.columns], cells)]  # fmt: skip
