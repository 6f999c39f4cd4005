# SPDX-License-Identifier: MIT
"""SubDyn: the stiffness at rest or at a load as SSI file (all 42 labels) and as a spring element.

Formats as OpenFAST 5.0.0 reads them (commit 2895884). SubDyn takes a missing label as zero, so that all are written.
Both are linear.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pysprings.core.text import commented
from pysprings.results.exporters.base import Exported, Options, Source, Target
from pysprings.results.exporters.header import header
from pysprings.results.exporters.linear import Linear, linear
from pysprings.springs.springs import Springs

_DOFS = ("x", "y", "z", "tx", "ty", "tz")
FRAME = (
    "right-handed, x along the load of the springs, z up, origin at the lid centre (mudline); rotations right-hand; "
    "forces on the soil"
)
UNITS = "N/m, N/rad = N m/m, N m/rad; kg, kg m, kg m2"
NO_TORSION = "torsion is not known, no full model has computed it: Ktztz is 0, which SubDyn rejects; put in a value"


def labels(letter: str) -> Iterator[tuple[str, int, int]]:
    """Yield (label, row, column) of the upper triangle in the order of SubDyn: Kxx, Kxy, Kyy, Kxz ..."""
    for column in range(6):
        for row in range(column + 1):
            yield f"{letter}{_DOFS[row]}{_DOFS[column]}", row, column


def ssi_text(head: Sequence[str], stiffness: np.ndarray) -> str:
    """Return a SubDyn SSI file: stiffness (6, 6), and no added mass."""
    lines = commented("!", head)
    lines += [f"{stiffness[i, j]:24.15E}  {label}" for label, i, j in labels("K")]
    lines += [f"{0.0:24.15E}  {label}" for label, _, _ in labels("M")]
    return "\n".join(lines) + "\n"


def spring_element_text(head: Sequence[str], stiffness: np.ndarray) -> str:
    """Return the rows of a SubDyn file for a spring element: its properties, a member and its direction cosines."""
    pairs = [(i, j) for i in range(6) for j in range(i, 6)]
    lines = commented("!", head)
    lines += [
        "! Copy the rows below into the SubDyn file; joints and numbers in < > are those of the model. Both joints are",
        "! at the lid centre; the joint of the ground is a base reaction joint with all six degrees of freedom fixed.",
        "---------------------- MEMBERS ----------------------",
        "<MemberID>  <joint of the tower>  <joint of the ground>  1  1  5  1",
        "---------------------- SPRING ELEMENT PROPERTIES ----------------------",
        "             1   NSpringPropSets   - Number of spring properties",
        "PropSetID " + " ".join(f"k{i + 1}{j + 1}" for i, j in pairs),
        "(-) " + " ".join(_unit(i, j) for i, j in pairs),
        "1 " + " ".join(f"{stiffness[i, j]:.15E}" for i, j in pairs),
        "---------------------- MEMBER COSINE MATRICES COSM(i,j) ----------------------",
        "             1   NCOSMs      - Number of unique cosine matrices (-)",
        "COSMID COSM11 COSM12 COSM13 COSM21 COSM22 COSM23 COSM31 COSM32 COSM33",
        "(-) (-) (-) (-) (-) (-) (-) (-) (-) (-)",
        "1 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0",
    ]
    return "\n".join(lines) + "\n"


def _unit(i: int, j: int) -> str:
    return ("(N/m)", "(N/rad)", "(Nm/rad)")[(i > 2) + (j > 2)]


def matrix_of(source: Source, options: Options) -> Linear:
    """Return the matrix (6, 6) with z up, at rest or at a load, and the sentences on what a matrix loses."""
    found = linear(Springs.of(source.springs), options)
    return found if found.stiffness[5, 5] else replace(found, lines=[*found.lines, NO_TORSION])


def write_subdyn(head: Sequence[str], stiffness: np.ndarray, target: Target) -> list:
    """Write the SSI file and the rows of a spring element; return their paths."""
    return [
        target.write("subdyn_ssi.dat", ssi_text(head, stiffness)),
        target.write("subdyn_spring.dat", spring_element_text(head, stiffness)),
    ]


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write the SSI file and the spring element."""
    found = matrix_of(source, options)
    head = [*header(source, f"SubDyn foundation matrix: {found.name}", FRAME, UNITS), *found.lines]
    return Exported(write_subdyn(head, found.stiffness, target), found.lines)
