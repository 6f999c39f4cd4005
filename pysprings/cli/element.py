# SPDX-License-Identifier: MIT
"""`pysprings element`: laboratory tests on one point of a layer, beside data, with keys fitted to them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.options import (
    Changes,
    DrawnFigures,
    Format,
    Json,
    NoFigures,
    SceneFile,
    formats_of,
    option,
    quantity,
)
from pysprings.cli.scene import estimate_of, load, print_estimate
from pysprings.cli.support import print_json, print_table, quantities, refuse
from pysprings.core.columns import Column, Table, filled
from pysprings.core.errors import RunIncomplete
from pysprings.core.units import quoted
from pysprings.core.words import ElementTest

if TYPE_CHECKING:
    from pysprings.scene.ground import Stratum
    from pysprings.scene.model import Scene
    from pysprings.studies.element import Fit, Fitted, LabTest, Outcome

_ROWS = (
    Column("test", "test", words=True),
    Column("drainage", "drainage", words=True),
    Column("stress [kPa]", "stress_Pa", factor=1e-3),
    Column("largest stress [kPa]", "peak_Pa", factor=1e-3),
    Column("at strain [%]", "strain_at_peak", factor=100.0),
    Column("stress at the end [kPa]", "end_Pa", factor=1e-3),
    Column("phi mobilised, largest [deg]", "mobilised_angle_deg"),
    Column("volumetric strain [%]", "volumetric_strain", factor=100.0),
    Column("pore pressure [kPa]", "pore_pressure_Pa", factor=1e-3),
    Column("away from data [%]", "away", factor=100.0),
)
FAR = 0.2  # distance from data beyond which fitted values are none
_KEYS = (
    Column("key", "key", words=True), Column("unit", "unit", words=True), Column("before", "before"),
    Column("fitted", "value"), Column("standard error", "error", 2), Column("", "note", words=True),
)  # fmt: skip


def element(
    scene: SceneFile,
    test: Annotated[ElementTest, option("--test", "kind of test")] = "triaxial",
    layer: Annotated[str | None, option("--layer", "layer [default: the only one]", "NAME")] = None,
    stress: Annotated[
        list[str] | None, option("--stress", 'consolidation stress, e.g. "100 kPa"; repeated', "STRESS")
    ] = None,
    drainage: Annotated[
        Literal["drained", "undrained"], option("--drainage", "constant cell pressure, or constant volume")
    ] = "drained",
    depth: Annotated[float | None, quantity("--depth", "m", "3 m", "where values by depth are taken [middle]")] = None,
    strain: Annotated[float | None, option("--strain", "last strain, e.g. 0.1; by default of the kind")] = None,
    data: Annotated[Path | None, option("--data", "measured tests (CSV, xlsx)", "FILE")] = None,
    fit: Annotated[str | None, option("--fit", "keys of the layer to fit to --data", "KEY,KEY")] = None,
    out: Annotated[Path | None, option("--out", "folder [default: out/element-SCENE]", "DIR")] = None,
    changes: Changes = None,
    figures: DrawnFigures = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    as_json: Json = False,
) -> None:
    """Drive a layer's law through a laboratory test. Set it beside data, and fit keys to them."""
    formats = formats_of(figures, no_figures, figure_format)
    loaded = load(scene, None, changes)
    folder = Path("out") / f"element-{scene.stem}" if out is None else out
    refuse_no_folder(folder)
    stratum = _layer(loaded, layer, depth)
    at = 0.5 * (stratum.top + stratum.bottom) if depth is None else depth
    if not stratum.top <= at <= stratum.bottom:
        refuse("--depth", f"{at:g} m is not in the layer, {stratum.top:g} to {stratum.bottom:g} m")
    if strain is not None and not 0.0 < strain <= 1.0:
        refuse("--strain", f"{strain:g} is not in (0, 1]")
    if test == "oedometer" and drainage == "undrained":
        refuse("--drainage", "an oedometer test drains")
    from pysprings.studies.element import Request, run, write

    asked = _stresses(stress)
    tests = _tests(data, test, asked, strain)
    keys = _keys(fit, stratum, data)
    outcome = run(Request(stratum, test, at, drainage == "undrained", asked, strain, tests, keys))
    files = write(outcome, folder, formats)
    if as_json:
        document = {"depth_m": at, "tests": outcome.rows, "fit": _fit_json(outcome.fit)}
        print_json(estimate_of(loaded) | document | {"files": [str(file) for file in files]})
    else:
        _print(outcome)
        print_estimate(loaded)
        for file in files:
            print(file)
    if outcome.stopped or (outcome.fit is not None and not outcome.fit.converged):
        raise RunIncomplete("; ".join(outcome.stopped) or "the fit did not converge", folder)


def _layer(scene: Scene, name: str | None, depth: float | None) -> Stratum:
    """Return the layer of a name, of several with it that at the depth [m]; without a name the only one."""
    strata = [each for each in scene.ground.strata if not each.like]
    names = ", ".join(f"'{each.name}'" for each in strata)
    if name is None and len(strata) > 1:
        refuse("--layer", f"the scene has several layers: give one of {names}")
    found = [each for each in strata if name in (None, each.name)]
    if not found:
        refuse("--layer", f"{quoted(name)} is no layer of the scene: give one of {names}")
    if len(found) > 1 and depth is not None:
        found = [each for each in found if each.top <= depth <= each.bottom][:1] or found
    if len(found) > 1:
        places = ", ".join(f"{each.top:g} to {each.bottom:g} m" for each in found)
        refuse("--depth", f"{len(found)} layers have the name {quoted(found[0].name)}, {places}: give a depth in one")
    return found[0]


def _stresses(given: list[str] | None) -> tuple[float, ...]:
    """Return the consolidation stresses in Pa."""
    found: list[float] = []
    for text in given or ():
        value = quantities({"--stress": (text, "Pa", "100 kPa")})["--stress"]
        if value is None or value <= 0.0:
            refuse("--stress", f"{quoted(text)} must be positive")
        if f"{value:.6g}" in (f"{each:.6g}" for each in found):  # as many digits as a test's name has
            refuse("--stress", f"{quoted(text)} stands there twice")
        found.append(value)
    return tuple(found)


def _tests(
    file: Path | None, kind: ElementTest, stresses: tuple[float, ...], strain: float | None
) -> tuple[LabTest, ...]:
    from pysprings.studies.element import read_tests

    if file is None:
        return ()
    if len(stresses) > 1:
        refuse("--stress", "--data gives the stress of each test: one at most, for a table without a column of it")
    tests = tuple(read_tests(file, kind, stresses[0] if stresses else None))
    if strain is not None and strain < (last := max(each.last_strain(kind) for each in tests)):
        refuse("--strain", f"{strain:g} is less than the last strain of --data, {last:g}: rows beyond it have no curve")
    return tests


def _keys(text: str | None, stratum: Stratum, data: Path | None) -> tuple[str, ...]:
    """Return the keys to be fitted."""
    from pysprings.core.text import suggestion
    from pysprings.scene.soils import SOIL_LAWS
    from pysprings.studies.element import known_keys

    if text is None:
        return ()
    if data is None:
        refuse("--fit", "needs --data")
    keys, known = [each.strip() for each in text.split(",")], known_keys(stratum)
    for key in keys:
        if key in stratum.values and key in SOIL_LAWS[stratum.law].keys and key not in known:
            refuse("--fit", f"{quoted(key)} is by depth in this layer: give it one number at the depth of the tests")
        if key not in known:
            what = f"{quoted(key)} is no number of the layer that its law uses{suggestion(key, known)}"
            refuse("--fit", f"{what}; those are {', '.join(known)}")
    if len(set(keys)) < len(keys):
        refuse("--fit", "a key stands there twice")
    return tuple(keys)


def _print(outcome: Outcome) -> None:
    print_table(Table.of(filled(_ROWS, outcome.rows), outcome.rows))
    request, stratum = outcome.request, outcome.request.stratum
    print(f"\nlargest stress, stress at the end: {outcome.stress}")
    print(f"values of layer {quoted(stratum.name)} at {request.depth:g} m below mudline (--depth)")
    if not (stratum.exponent or stratum.total_stress):
        print("\nG does not follow the stress in a test: no key makes it do so")
    fit = outcome.fit
    if fit is None:
        return
    if fit.after > FAR:
        print(f"\nthe law does not reach the data: more than {FAR:.0%} away with the best values of these keys")
    rows = [vars(each) | {"note": _note(each)} for each in fit.keys]
    print(f"\nfit: {100.0 * fit.before:.3g} % away from the data before, {100.0 * fit.after:.3g} % after")
    print_table(Table.of(_KEYS, rows))
    if len(rows) > 1:
        print("\ncorrelation of the fitted keys:")
        names = [each.key for each in fit.keys]
        cells = [
            [name, *("-" if math.isnan(each) else f"{each:.2f}" for each in line)]
            for name, line in zip(names, fit.correlation, strict=True)
        ]
        print_table(Table("", ("", *names), cells, left=(True, *[False] * len(names))))


def _note(key: Fitted) -> str:
    """Return what is wrong with a fitted value; blank for nothing."""
    notes = ["at its bound"] * key.at_bound + ["these data do not determine it"] * math.isnan(key.error)
    return ", ".join(notes)


def _fit_json(fit: Fit | None) -> dict[str, Any] | None:
    if fit is None:
        return None
    keys = [vars(each) for each in fit.keys]
    return {"keys": keys, "away_before": fit.before, "away_after": fit.after, "converged": fit.converged,
            "correlation": fit.correlation.tolist()}  # fmt: skip
