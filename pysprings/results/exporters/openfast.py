# SPDX-License-Identifier: MIT
"""OpenFAST: the initial stiffness as SubDyn SSI file (all 42 labels) and as SoilDyn input with one matrix.

Formats as OpenFAST 5.0.0 reads them (commit 2895884): SubDyn takes a missing label as zero, so that all are written;
SoilDyn (CalcOption 1) takes one matrix at one point at or below the mudline. Both are linear.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pysprings.results.exporters.base import Exported, Exporter, Option, Options, Source, Target

if TYPE_CHECKING:
    import numpy as np

_DOFS = ("x", "y", "z", "tx", "ty", "tz")
_FRAME = (
    "right-handed, x along the load of the springs, z up, origin at the lid centre (mudline); rotations right-hand; "
    "forces on the soil"
)
_UNITS = "N/m, N/rad = N m/m, N m/rad; kg, kg m, kg m2"
_TORSION = "torsion is not known from lateral loading: Ktztz is 0, which SubDyn rejects; give --option torsion=..."
_LINEAR = "linear: the matrix is that of the caisson at rest, at all displacements"


def labels(letter: str) -> Iterator[tuple[str, int, int]]:
    """Yield (label, row, column) of the upper triangle in the order of SubDyn: Kxx, Kxy, Kyy, Kxz ..."""
    for column in range(6):
        for row in range(column + 1):
            yield f"{letter}{_DOFS[row]}{_DOFS[column]}", row, column


def ssi_text(head: Sequence[str], stiffness: np.ndarray) -> str:
    """Return a SubDyn SSI file: stiffness (6, 6), and no added mass."""
    lines = [f"! {line}" for line in head]
    lines += [f"{stiffness[i, j]:24.15E}  {label}" for label, i, j in labels("K")]
    lines += [f"{0.0:24.15E}  {label}" for label, _, _ in labels("M")]
    return "\n".join(lines) + "\n"


def soildyn_text(head: Sequence[str], stiffness: np.ndarray, place: tuple[float, float, float]) -> str:
    """Return a SoilDyn input file with one matrix (CalcOption 1) at a place [m]; the header stands at its end, too."""
    zero = "0 0 0 0 0 0"
    lines = [
        f"---------- SoilDyn Input File: {head[0]} ----------",
        f"{head[1]}; frame, units, range and error: below END",
        "---------- Options ----------",
        "False        Echo         - Echo the input data",
        '"default"    DT           - Time step (s)',
        "1            CalcOption   - 1: stiffness matrix",
        "---------- Stiffness and damping at one point ----------",
        f"{place[0]:.10g} {place[1]:.10g} {place[2]:.10g}    Location (x, y, z) (m)",
        "---------- Stiffness (N/m, N/rad, N m/rad) ----------",
        *(" ".join(f"{value:.15E}" for value in row) for row in stiffness),
        "---------- Damping (not supported by SoilDyn) ----------",
        *[zero] * 6,
        "---------- P-Y curves (not available in SoilDyn) ----------",
        "0            PY_NumPoints",
        "---------- Location (x, y, z) (m) and file ----------",
        "---------- REDWIN library (not used) ----------",
        "2            DLL_Model",
        '"unused"     DLL_FileName',
        "0            DLL_NumPoints",
        "---------- Location (x, y, z) (m) and files ----------",
        "---------- Output ----------",
        "False        SumPrint",
        "---------- OutList ----------",
        '"Sld1Fxg, Sld1Fyg, Sld1Fzg, Sld1Mxg, Sld1Myg, Sld1Mzg"',
        "END of input",
        *(f"! {line}" for line in head),
    ]
    return "\n".join(lines) + "\n"


def _write(source: Source, target: Target, options: Options) -> Exported:
    from pysprings.results.exporters.header import header
    from pysprings.results.exporters.linear import linear_errors, stiffness_z_up
    from pysprings.springs.springs import Springs

    springs, torsion = Springs.of(source.springs), float(options["torsion"] or 0.0)
    stiffness = stiffness_z_up(springs, torsion)
    lost = [_LINEAR, *(f"error of the linear response, {line}" for line in linear_errors(springs))]
    lost += [] if torsion else [_TORSION]
    head = [*header(source, "OpenFAST foundation matrix", _FRAME, _UNITS), *lost]
    place = float(options["x"] or 0.0), float(options["y"] or 0.0), float(options["z"] or 0.0)
    files = [
        target.write("subdyn_ssi.dat", ssi_text(head, stiffness)),
        target.write("soildyn.dat", soildyn_text(head, stiffness, place)),
    ]
    return Exported(files, lost)


OPENFAST = Exporter(
    name="openfast",
    description="initial stiffness for OpenFAST: SubDyn SSI file, SoilDyn input with one matrix",
    write=_write,
    suffixes=(".dat",),
    options=(
        Option("torsion", "stiffness about the vertical axis, which springs do not give", unit="N m/rad",
               example="1e9 N m/rad"),
        Option("x", "place of the lid centre in the frame of OpenFAST", unit="m", example="0 m"),
        Option("y", "the same", unit="m", example="0 m"),
        Option("z", "height of the mudline above still water, negative", unit="m", example="-30 m"),
    ),
)  # fmt: skip
