# SPDX-License-Identifier: MIT
"""Laboratory data: tables of triaxial, DSS and oedometer tests, and the tests of a scene's layer beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.tables import Column, one_table
from pysprings.core.tables.headings import ANY, TEXT
from pysprings.core.words import ElementTest

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pysprings.model.element import Curve

    Array = NDArray[np.float64]

# kind of test -> its strain, and what is measured over it: the first is needed, a fit uses those that are there
MEASURED: dict[ElementTest, tuple[str, tuple[str, ...]]] = {
    "triaxial": ("axial_strain", ("q_Pa", "volumetric_strain", "pore_pressure_Pa")),
    "triaxial-extension": ("axial_strain", ("q_Pa", "volumetric_strain", "pore_pressure_Pa")),
    "dss": ("shear_strain", ("shear_stress_Pa", "volumetric_strain", "pore_pressure_Pa", "axial_stress_Pa")),
    "oedometer": ("axial_strain", ("axial_stress_Pa",)),
}
_PASCALS = {
    "q_Pa": ("q", "deviator stress", "deviatoric stress"), "p_Pa": ("p", "p'", "mean effective stress"),
    "shear_stress_Pa": ("tau", "shear stress"), "pore_pressure_Pa": ("u", "pore pressure", "excess pore pressure"),
    "axial_stress_Pa": ("vertical stress", "axial stress", "vertical effective stress"),
    "radial_stress_Pa": ("radial stress",),
    "stress_Pa": ("stress", "consolidation stress", "cell pressure", "confining pressure"),
}  # fmt: skip
_STRAINS = {
    "axial_strain": ("axial strain", "eps1", "epsa", "vertical strain"), "shear_strain": ("shear strain", "gamma"),
    "volumetric_strain": ("volumetric strain", "epsv", "volume strain"),
}  # fmt: skip
COLUMNS = (
    Column("test", TEXT, ("name",)),
    *(Column(name, "Pa", names, "kPa") for name, names in _PASCALS.items()),
    *(Column(name, "1", names, percent=0.01) for name, names in _STRAINS.items()),
    *(Column(name, ANY, skipped="follows from others") for name in ("e", "void ratio", "step", "drainage")),
    Column("mobilised_angle_rad", "rad", ("mobilised angle",), skipped="follows from others"),
)


@dataclass(frozen=True)
class LabTest:
    """A measured test: its name, its consolidation stress (Pa), and columns in SI by their names in `MEASURED`."""

    name: str
    stress: float
    columns: Mapping[str, Array]


def read_tests(file: Path, kind: ElementTest, stress: float | None) -> list[LabTest]:
    """Return the tests of a table: rows of one name, or of one consolidation stress, are one test.

    ``stress`` (Pa) is that of a table without a column of it. Compression is positive.

    Raises UserInputError: one problem per thing that is wrong with the table.
    """
    strain, measured = MEASURED[kind]
    table = one_table(file, COLUMNS, "a laboratory test")
    for name in (strain, measured[0]):
        if name not in table:
            shown = next(each.shown for each in COLUMNS if each.name == name)
            table.fault(None, None, f"no column '{shown}': a {kind} test needs it")
    if "stress_Pa" not in table and stress is None:
        table.fault(None, None, "no column 'stress [kPa]' of the consolidation stress: add it, or give one --stress")
    table.faults.stop()
    values = {name: table.numbers(name, most=False) for name in (strain, *measured) if name in table}
    stresses = table.numbers("stress_Pa") if "stress_Pa" in table else np.full(len(table), stress)
    names = table.texts("test") if "test" in table else [f"{each / 1e3:.6g} kPa" for each in stresses]
    for k in np.flatnonzero(~(stresses > 0.0)).tolist():
        table.fault(k, "stress_Pa", "a consolidation stress must be positive")
    for k in np.flatnonzero(np.isnan(values[strain]) | np.isnan(values[measured[0]])).tolist():
        table.fault(k, strain, "needs a number here and for the stress")
    tests = []
    for name in dict.fromkeys(names):
        rows = np.array([each == name for each in names])
        if rows.sum() < 3 or np.ptp(values[strain][rows]) == 0.0:
            table.fault(int(np.argmax(rows)), None, f"test '{name}' has fewer than 3 rows of different strain")
        if np.ptp(stresses[rows]) > 0.0:
            table.fault(int(np.argmax(rows)), "stress_Pa", f"test '{name}' has several consolidation stresses")
        tests.append(LabTest(name, float(stresses[rows][0]), {key: each[rows] for key, each in values.items()}))
    table.faults.stop()
    return tests


def residuals(test: LabTest, curve: Curve | None, kind: ElementTest, undrained: bool) -> list[Array]:
    """Return computed less measured values, an array (n,) a column, each over the column's largest and sqrt(n).

    Of volumetric strain at least 1 % counts as the largest, of an undrained test the pore pressure in its place. A
    curve that ends early, or is None, is 100 % away from the values beyond.
    """
    strain, measured = MEASURED[kind]
    columns = {} if curve is None else curve.columns()
    at, left_out = np.abs(test.columns[strain]), "volumetric_strain" if undrained else "pore_pressure_Pa"
    out = []
    for name in (each for each in measured if each in test.columns and each != left_out):
        good = np.isfinite(test.columns[name])
        value, least = test.columns[name][good], 0.01 if name == "volumetric_strain" else 1.0
        scale = max(float(np.abs(value).max(initial=0.0)), least)
        away = np.full(len(value), scale)
        if curve is not None:
            reached = at[good] <= np.abs(columns[strain][-1]) * (1.0 + 1e-6)
            found = np.interp(at[good], np.abs(columns[strain]), columns[name])
            away = np.where(reached, found - value, away)
        out.append(away / scale / np.sqrt(max(len(value), 1)))
    return out
