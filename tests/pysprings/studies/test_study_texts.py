# SPDX-License-Identifier: MIT
"""Scenes of the catalogues, tables, documents and pictures of the studies, line by line, in the stored texts."""

from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path as File
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pysprings.cli import studies
from pysprings.core import version
from pysprings.full_model.accuracy.measures import LOAD, MEASURES, OTHER, PY, Reference
from pysprings.full_model.accuracy.presets import settings
from pysprings.full_model.run_record import RunRecord
from pysprings.scene.sections import PAPER_PATH
from pysprings.studies import stability
from pysprings.studies.accuracy import study
from pysprings.studies.accuracy.rows import FULL, MACRO, StudyResult, error_against_time
from pysprings.studies.accuracy.study import to_markdown
from pysprings.studies.stability import OUTCOMES, Outcome, catalogue, summary
from tests.support import stored, synthetic, tiny
from tests.support.drawn import describe, number
from tests.support.files import Outline
from validation.paper import claims, figures, idealisations, page, runs as paper_runs, sensitivity, text
from validation.paper.cases import CASES, VARIANTS, Variant

TEXTS = File(__file__).parent / "texts"


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Names and values of nested settings."""
    if isinstance(value, list | tuple) and not any(isinstance(part, dict) for part in value):
        yield name, " ".join(f"({leaf(part)})" if isinstance(part, list | tuple) else leaf(part) for part in value)
    elif isinstance(value, dict | list | tuple):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, part in pairs:
            yield from leaves(part, f"{name}.{key}".lstrip("."))
    else:
        yield name, leaf(value)


def leaf(value: Any) -> str:
    """A single value; those of a tuple beside each other."""
    if isinstance(value, list | tuple):
        return " ".join(map(leaf, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


PAPER_SCENE = tiny.paper(paths=(PAPER_PATH,))
USUAL = dict(leaves(PAPER_SCENE.model_dump()))


def unusual(make: Any) -> str:
    """What a scene sets otherwise than the default scene; the message of one that is refused."""
    try:
        found = dict(leaves(make().model_dump()))
    except ValueError as error:
        return f"refused: {stability._refusal(error)}"
    return ", ".join(f"{key} = {value}" for key, value in found.items() if USUAL.get(key, "") != value)


def test_scenes_of_the_catalogues() -> None:
    lines = [f"{case.name} ({case.words}): {unusual(lambda c=case: c.scene('paper'))}" for case in CASES]
    lines += [f"{CASES[0].name}, fields only: {unusual(lambda: CASES[0].scene('coarse', fields_only=True))}", ""]
    for variant in VARIANTS:
        lines.append(f"{variant.group}: {variant.name}, {variant.standing}, beside {variant.beside}")
        for case in filter(None, (variant.case(), variant.smooth_case())):
            lines.append(f"  {case.name} ({case.words}): {unusual(lambda c=case: c.scene('coarse'))}")
    lines.append("")
    for each in stability.CASES:
        head = f"{each.group}: {each.name}{', hard' * each.hard} ({each.what})"
        lines.append(f"{head}: {unusual(lambda c=each: c.scene('coarse'))}")
    stored.compare(lines, TEXTS / "scenes.txt", "scenes of the paper and of the catalogue, beside the default scene")


# --- the paper ---


def ran(name: str) -> paper_runs.Run:
    """A run of the invented soil as the paper's case of this name: with water stronger, without friction weaker."""
    case = next(each for each in CASES if each.name == name)
    tree = synthetic.make_result((synthetic.Path("pull", size=20e-3, steps=40),))
    tree.attrs |= {"outer_diameter_m": 7.8, "skirt_length_m": 4.0, "scene_toml": "", "solver": "superlu"}
    path = tree["paths/pull"].to_dataset(inherit=False)
    path.attrs["rate_m_per_s"] = case.rate or np.nan
    _, nodes, _ = synthetic.section_mesh(synthetic.Caisson())
    path["section_ux"] = path["section_ux"] * (1.0 - 0.05 * xr.DataArray(nodes, dims="section_node"))
    loads = [key for key in ("H", "H_outer", "H_inner", "p", "p_component", "shear_lateral") if key in path]
    factor = 0.5 if case.friction == 0.0 else 1.0
    if not case.drained:
        factor = factor * (1.0 + np.maximum(path["u"] - 2e-3, 0.0) * (5.0 if case.rate == 0.05e-3 else 9.0))
        suction = (-1e6 * path["u"] * (2.0 + np.cos(path["azimuth"]))).broadcast_like(path["pore_pressure"])
        path["pore_pressure"] = suction.transpose(*path["pore_pressure"].dims)
        path["F_pw"], path["pressure_min"] = -1e7 * path["u"], -3e6 * path["u"]
        path["section_pore_pressure"] = 1e5 * path["section_ux"]
    path = path.assign({key: (path[key] * factor).transpose(*path[key].dims) for key in loads})
    if name == "elastic-steel":
        change = (0.1 * path["y"] * (1.0 + path["depth"])).transpose("step", "depth")
        path = path.assign(diameter_change_x=-change, diameter_change_y=0.6 * change)
    tree["paths/pull"].dataset = path
    complete = name != "slow-smooth"
    water = {"expelled_m3": 2e-3, "compressed_m3": 1e-4, "film_m3": 4e-4, "outflow_m3": 1.5e-3,
             "worst_imbalance_over_exchanged": 3e-9, "pressure_min_Pa": -7.9e3, "pressure_max_Pa": 1e2}  # fmt: skip
    record = RunRecord.from_dict({
        "status": "complete" if complete else "partial", "wall_s": 12.5, "version": "9.9",
        "scene_sha256": "0123456789abcdef", "mesh": {"max_aspect": 12.3},
        "paths": {"pull": {"iterations": 81} | ({} if case.drained else {"water": water})},
    })  # fmt: skip
    return paper_runs.Run(case, File(), tree, paper_runs.path_of(tree), record)


@pytest.fixture(scope="module")
def runs() -> dict[str, paper_runs.Run]:
    return {case.name: ran(case.name) for case in CASES if case.name != "van-eekelen"}


def test_claims_and_report_of_the_paper(runs: dict[str, paper_runs.Run], tmp_path: File) -> None:
    paths = {name: run.path for name, run in runs.items()}
    table, idealised = claims.assess(paths), idealisations.compare(paths)
    short = claims.assess({name: path.isel(step=slice(0, 14)) for name, path in paths.items()})
    found = {
        name: {"status": "complete", "detail": ""} | sensitivity.figures_of_path(paths[run])
        for name, run in (("as-stated", "drained"), ("as-stated-smooth", "drained-smooth"), ("slow", "slow"))
    }
    rows = [sensitivity.row(each, found) for each in VARIANTS if each.name in found]
    refused = {"status": "refused", "detail": "K0 is outside"}
    rows.append(sensitivity.row(Variant("initial stress", "K0-0.5", "K0 0.5"), {"K0-0.5": refused}))
    readings = pd.DataFrame(rows).assign(mesh="coarse", variants=5)
    file = page.write(tmp_path, "medium", runs, [], table, idealised, readings)
    lines = ["--- claims", *text.claim_lines(table), "--- of runs that stopped", *text.claim_lines(short)]
    lines += ["--- claims.md", text.claims_markdown(table), "--- sensitivity.md", text.sensitivity_markdown(readings)]
    lines += [
        "--- figures",
        *(f"{name}: {number(value)}" for name, value in found["slow"].items() if name[:1] not in "sd"),
    ]
    lines += ["--- report.html", *Outline(file.read_text(encoding="utf-8").replace(version.__version__, "0")).lines]
    stored.compare(lines, TEXTS / "paper.txt", "the paper's study on the soil of tests/support/invented_soil.py")


@pytest.mark.slow
def test_pictures_of_the_paper(runs: dict[str, paper_runs.Run]) -> None:
    own = {name: run for name, run in runs.items()}
    drawn = [
        (each, each.draw(own)) for each in figures.DRAWINGS if each.stem != "macro_against_full" and each.possible(own)
    ]
    lines = [line for each, figure in drawn for line in (f"{each.stem}: {each.caption}", *describe(figure), "")]
    assert len(drawn) == len(figures.DRAWINGS) - 1
    stored.compare(
        lines, TEXTS / "paper-pictures.txt", "the paper's pictures of the soil of tests/support/invented_soil.py"
    )


# --- stiff and extreme cases ---


def test_table_and_picture_of_the_stiff_cases(capsys: pytest.CaptureFixture[str]) -> None:
    outcomes = [
        Outcome(
            f"group {k // 2}", f"case-{outcome}", f"what {outcome} is", outcome, "" if k == 0 else f"why {k}",
            u_mm=20.0 - k, H_kN=1234.5 * k, increments=20 + k if k != 3 else 0, cut_backs=3 * k,
            median_iterations=3.0 + k if k != 3 else None, max_iterations=9 + k if k != 3 else None,
            worst_residual=1e-6 * (k + 1), energy_imbalance=1e-8 * (k + 1), water_imbalance=None if k else 4e-9,
            condition=1e5 * (k + 1), factorisations=7 + k, wall_s=10.0 * (k + 1),
        )
        for k, outcome in enumerate(OUTCOMES)
    ]  # fmt: skip
    table = pd.DataFrame([asdict(each) for each in outcomes])
    lines = [stability.heading(), *(stability.line(asdict(each)) for each in outcomes)]
    lines += [f"{key}: {value}" for key, value in summary(table).items()]
    lines += [stability.closing(summary(table)), stability.closing(summary(table.iloc[3:]))]
    lines += [stability.to_markdown(table), *describe(catalogue(table))]
    stored.compare(lines, TEXTS / "stability.txt", "table and picture of stiff cases that were made up")


# --- error against time ---


BRICKS = {"discretisation": "hex8", "harmonics": None}


def studied() -> StudyResult:
    """What a study may find: three meshes, two variations one of which stopped, macro-models; two paths."""
    wanted = settings(["coarse:0.75", "coarse", "coarse:1.35"], quick=True)
    rows = []
    for k, each in enumerate(wanted):
        errors = {f"{name}_pct": 10.0 * (i + 1) / (k + 1) ** 2 for i, name in enumerate(MEASURES)}
        rows.append({
            "model": FULL, "name": each.name, "group": each.group,
            "mesh": each.mesh, "refinement": each.refinement, **BRICKS,
            "series": each.series, "slices": None, "status": "complete" if k < 4 else "stopped",
            "why": "" if k < 4 else "not converged: no", "unknowns": 1234 * (k + 1), "linear": "superlu",
            "increments": 20 + k, "iterations": 50 + k, "factorisations": 30 + k,
            "wall_s": 2.5 * (k + 1), "cpu_s": 4.5 * (k + 1), "unit_s": 0.01,
            "units": 250.0 * (k + 1), "memory_MB": 400.0 + k, "reference": "load, py" if k == 2 else "",
            "pareto": k in (0, 2), "from_mesh_pct": 0.5 * k if k > 2 else np.nan, **(errors if k < 4 else {}),
        })  # fmt: skip
        rows.append({
            "model": MACRO, "name": f"{each.name}, full, {k + 1} slices", "group": "macro-model",
            "mesh": each.mesh, **BRICKS,
            "refinement": each.refinement, "series": each.series, "slices": k + 1, "status": "complete", "why": "",
            "unknowns": 1234 * (k + 1), "wall_s": 1e-3 * (k + 1), "cpu_s": 1e-3 * (k + 1), "unit_s": 0.01,
            "units": 0.1 * (k + 1), "reference": "", "pareto": k == 1, "from_mesh_pct": np.nan, **errors,
        })  # fmt: skip
    one = np.ones(3)
    known = {
        LOAD: Reference(one, 1.02 * one, 1.85, "extrapolated with order 1.85"),
        OTHER: Reference(one, 1.01 * one, None, "the differences change sign: the finest mesh as it is"),
        PY: Reference(one, 1.03 * one, 1.2, "extrapolated with order 1.20"),
    }
    doubts = {name: 0.5 * (k + 1) if k != 1 else np.nan for k, name in enumerate(MEASURES)}
    slower = known | {PY: replace(known[PY], order=None)}
    references = {"pull": known, "turn": slower}
    return StudyResult(
        pd.DataFrame(rows), references, {"pull": doubts, "turn": doubts},
        [each.name for each in wanted if each.series], wanted, {"hex8": references}, "hex8",
    )  # fmt: skip


def test_documents_of_the_accuracy_study(tmp_path: File, capsys: pytest.CaptureFixture[str]) -> None:
    found = studied()
    (tmp_path / "accuracy.csv").touch()
    studies._print_accuracy(tmp_path, found)
    lines = ["--- the terminal", capsys.readouterr().out.replace(str(tmp_path), "OUT")]
    lines += ["--- accuracy.md", to_markdown(found, {"scene": "made up", "seconds on": "a machine"}, "accuracy.png")]
    noted = [
        (key, value) for key, value in leaves(study.to_json(PAPER_SCENE, found)) if key.partition(".")[0] not in HEAD
    ]
    lines += ["--- accuracy.json", *(f"{key}: {value}" for key, value in noted)]
    lines += ["--- accuracy.png", *describe(error_against_time(found.table, "made up $x$", [5.0, 1.0]))]
    lines += ["--- all settings", *map(str, settings(linear=["superlu", "other"], base_linear="superlu"))]
    stored.compare(lines, TEXTS / "accuracy.txt", "documents of an accuracy study that was made up")


HEAD = ("scene", "scene_sha256", "version", "date", "machine")
