# SPDX-License-Identifier: MIT
"""SubDyn: the stiffness at rest or at a load as SSI file (all 42 labels) and as a spring element.

Formats as OpenFAST 5.0.0 reads them (commit 2895884). SubDyn takes a missing label as zero, so that all are written.
Both are linear: a foundation as one matrix 6 x 6, at rest or at a load, and the error of its linear response on the
paths.
"""

import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.path_kinds import has_free_head
from pysprings.core.text import commented, plain_table
from pysprings.core.units import QuantityError, read
from pysprings.core.words import sudden
from pysprings.macro.answer import MacroWarning
from pysprings.macro.model import MacroModel
from pysprings.macro.stiffness import Load, Question, secant, stiffness_six
from pysprings.results.exporters.base import Exported, Options, Source, Target, rendered
from pysprings.results.exporters.header import header
from pysprings.springs.springs import Springs

SMALL = 0.01  # share of H L or of M in the larger of both below which an error of the load means nothing
SHARES = (0.1, 0.5, 1.0)  # of the range of a path where the linear response is compared
_HEAD = (
    "error of the linear response in H and M at 10, 50 and 100 % of the range of each path, in percent of the largest "
    f"H and M on the path ('-': below {100 * SMALL:g} % of the other load):"
)
AT_REST = (
    "linear: stiffness at rest{}, before any load, the dead load too; beside it secants of the springs, and its errors"
)
_UP = (1.0, 1.0, -1.0, 1.0, 1.0, 1.0)  # z of the programs over w, which is down
# of the option at: unit, and an example
LOADS = {"H": ("N", "2 MN"), "M": ("N m", "40 MN m"), "V": ("N", "2 MN"), "arm": ("m", "60 m")}
_SECANTS = (
    "stiffness at rest (before the dead load, not extrapolated), of the springs at rest under it, and their secants "
    "at 10 and 50 % of the range of paths [MN/m, MN/rad, MN m/rad]:"
)
_SECANT_COLUMNS = ("state", "|u| [mm]", "|rotation| [mrad]", "Kxx", "Kxty", "Ktyty")
_LATERAL = np.ix_([0, 4], [0, 4])  # u and rotation of a matrix (6, 6)
_COLUMNS = ("path", "role", "u [mm]", "rotation [mrad]", *(f"{load} {100 * s:g} %" for load in "HM" for s in SHARES))


def at_lid(springs: Springs) -> Array:
    """Return the initial stiffness (6, 6) at the lid centre [N/m, N/rad, N m/rad], symmetric.

    Axes are those of `stiffness_six`; so is torsion.

    Raises UserInputError: springs from a table without vertical stiffness.
    """
    return stiffness_six(springs, symmetric=True).values + 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Linear:
    """A matrix (6, 6) [N/m, N/rad, N m/rad] as `at_lid` has it, in words, and the lines that stand beside it."""

    stiffness: Array
    name: str
    lines: list[str]


def linear(springs: Springs, options: Options) -> Linear:
    """Return the matrix of the options `at`, `matrix`, `rate`, with its errors on the paths: at rest without a load.

    Raises UserInputError: a text that is no load, or springs from a table without vertical stiffness.
    Raises PredictionNotConverged, BeyondSprings: a load that the springs do not carry.
    """
    rate = options["rate"]
    at, here = place_of(springs, options["at"]) if options["at"] else (None, springs)
    springs = here if rate is None else springs.at_rate(float(rate))
    of_rate = [] if rate is None else [f"of the springs at {1e3 * float(rate):.4g} mm/s (of rho)"]
    if at is None:
        matrix = at_lid(springs)
        at_rest = AT_REST.format(sudden(springs.drainage))
        beside = [at_rest, *_mean(springs), *of_rate, *secants(springs), *linear_errors(springs, matrix[_LATERAL])]
        return Linear(matrix, "stiffness at rest", beside)
    question: Question = {**at, "secant": options["matrix"] == "secant", "symmetric": True}
    with warnings.catch_warnings(record=True, action="always", category=MacroWarning) as marks:
        found = stiffness_six(springs, **question)
    matrix, name = found.values * np.outer(_UP, _UP) + 0.0, str(found.attrs["long_name"])
    words = f"linear: {name} ({options['at']}); x along that load; beside it secants of the springs, and its errors"
    notes = [*(f"supported in part: {each.message}" for each in marks), str(found.attrs["vertical"])]
    return Linear(matrix, name, [words, *of_rate, *notes, *secants(springs), *linear_errors(springs, matrix[_LATERAL])])


def _mean(springs: Springs) -> list[str]:
    """Return a line on what Kxty stands for, where friction makes the stiffness at rest unsymmetric."""
    K = springs.lateral_stiffness
    if abs(K[0, 1] - K[1, 0]) < 1e-3 * abs(K[0, 1]):
        return []
    both = f"H per rotation {1e-6 * K[0, 1]:.4g} and M per u {1e-6 * K[1, 0]:.4g} MN/rad"
    return [f"the matrix is symmetric: Kxty is the mean of {both} of the full model"]


def place_of(springs: Springs, text: str) -> tuple[Load, Springs]:
    """Return the load of "H=2 MN, arm=60 m" (H, M, V, arm), or the motion of "50 % of pull_1_D" (SI), and its springs.

    Raises UserInputError, all faults at once.
    """
    if level := re.fullmatch(r"(\d+(?:\.\d*)?) ?% of (\w+)", text.strip()):
        path, share = springs.path(level[2]), 0.01 * float(level[1])
        motion = np.stack([path.u, path.rotation])
        if path.is_vertical or not 0.0 < share <= 1.0:
            raise refused("--option at", f"'{text}' is not above 0 and up to 100 % of the range of a lateral path")
        (step,) = _steps(motion, springs.length, (share,))
        own = Load(u=float(motion[0, step]), rotation=float(motion[1, step]), V=float(path.given_loads[step]))
        here = springs.answering(path)
        return own, here.whole or here
    found, problems = Load(), []
    for part in text.split(","):
        name, sign, value = (each.strip() for each in part.partition("="))
        if not sign or name not in LOADS:
            problems.append(f"'{part.strip()}' is not one of {', '.join(f'{each}=VALUE' for each in LOADS)}")
            continue
        if name in found:
            problems.append(f"{name} is given twice")
        try:
            found |= {name: float(read(value, *LOADS[name]))}  # type: ignore[misc]
        except QuantityError as error:
            problems.append(f"{name}: {error}")
    if problems:
        raise UserInputError([Problem(key="--option at", message=each) for each in problems])
    return found, springs


def secants(springs: Springs) -> list[str]:
    """Return the lines of a table: stiffness at rest, then the secants at 10 and 50 % of the range of lateral paths.

    The secant is that of the springs that predict, at recorded states of the paths with a free head (of all lateral
    ones where there is none), in the frame and the words of the matrix. Springs at rest are those of the first path:
    under the dead load, and on extrapolated reactions.
    """
    lateral = [path for path in springs.paths.values() if not path.is_vertical]
    rows = [("at rest", "", "", *_entries(at_lid(springs)[np.ix_([0, 4], [0, 4])]))]
    for path in [each for each in lateral if has_free_head(each.attrs)] or lateral:
        model = MacroModel.from_springs(springs.answering(path))
        if len(rows) == 1:
            K = model.tangent_stiffness().values[np.ix_([0, -1], [0, -1])]
            rows.append(("springs at rest", "", "", *_entries(0.5 * (K + K.T))))
        motion = np.stack([path.u, path.rotation])
        for share, step in zip(SHARES[:2], _steps(motion, springs.length), strict=False):
            matrix = secant(model, float(path.u[step]), float(path.rotation[step]), symmetric=True)
            size = [f"{round(1e3 * value, 9):.3g}" for value in np.abs(motion[:, step])]
            rows.append((f"{path.name}, {100 * share:g} %", *size, *_entries(matrix[np.ix_([0, -1], [0, -1])])))
    return [_SECANTS, *plain_table(_SECANT_COLUMNS, rows).splitlines()]


def _entries(matrix: Array) -> list[str]:
    return [f"{1e-6 * value:.4g}" for value in (matrix[0, 0], matrix[0, 1], matrix[1, 1])]


def _steps(motion: Array, length: float, shares: Sequence[float] = SHARES) -> list[int]:
    """Return the steps at shares of the largest size of a motion (2, step)."""
    size = np.hypot(motion[0], motion[1] * length)
    return [int(np.argmin(np.abs(size - share * size.max()))) for share in shares]


def linear_errors(springs: Springs, lateral: Array) -> list[str]:
    """Return the lines of a table with a row for each lateral path: errors in H and M of a matrix (2, 2).

    Loads of the matrix at the recorded motion (u, rotation) less those of the full model, relative to the largest size
    of each load on the whole path, at `SHARES` of the range.
    """
    rows = []
    for name, path in springs.paths.items():
        if path.is_vertical:
            continue
        data = path.dataset
        motion = np.stack([data["u"].values, data["rotation"].values])
        steps = _steps(motion, springs.length)
        end = [f"{1e3 * value + 0.0:.3g}" for value in motion[:, steps[-1]]]
        words = _words(lateral @ motion, data, springs.length, steps)
        rows.append((name, str(data.attrs["role"]), *end, *words))
    return [_HEAD, *plain_table(_COLUMNS, rows, (True, True)).splitlines()] if rows else []


def _words(linear: Array, data: xr.Dataset, length: float, steps: Sequence[int]) -> list[str]:
    """Return the errors of H, then of M, at steps; "-" of a load that is small beside the other one."""
    sizes = [float(np.abs(data[load].values).max(initial=0.0)) for load in "HM"]
    whole = max(sizes[0] * length, sizes[1])
    words = []
    for row, (load, size, arm) in enumerate(zip("HM", sizes, (length, 1.0), strict=True)):
        counts = size * arm > SMALL * whole
        for step in steps:
            error = 100.0 * (linear[row, step] - float(data[load][step])) / size if counts else 0.0
            words.append(f"{error + 0.0:+.1f}" if counts else "-")
    return words


_DOFS = ("x", "y", "z", "tx", "ty", "tz")
FRAME = (
    "right-handed, x along the load of the springs, z up, origin at the lid centre (mudline); rotations right-hand; "
    "forces on the soil"
)
UNITS = "N/m, N/rad = N m/m, N m/rad; kg, kg m, kg m2"
FREE_BASE = (
    "in SubDyn all six flags of the base reaction joint are 0 (1 clamps it: SSI file and SoilDyn have no effect then)"
)
NO_TORSION = "torsion is not known, no full model has computed it: Ktztz is 0, which SubDyn rejects; put in a value"


def labels(letter: str) -> Iterator[tuple[str, int, int]]:
    """Yield (label, row, column) of the upper triangle in the order of SubDyn: Kxx, Kxy, Kyy, Kxz ..."""
    for column in range(6):
        for row in range(column + 1):
            yield f"{letter}{_DOFS[row]}{_DOFS[column]}", row, column


def spring_element_text(head: Sequence[str], stiffness: np.ndarray) -> str:
    """Return the rows of a SubDyn file for a spring element: its properties, a member and its direction cosines."""
    pairs = [(i, j) for i in range(6) for j in range(i, 6)]
    return rendered(
        "subdyn_spring.dat.j2", head=commented("!", head), names=[f"k{i + 1}{j + 1}" for i, j in pairs],
        units=[_unit(i, j) for i, j in pairs], values=[f"{stiffness[i, j]:.15E}" for i, j in pairs],
    )  # fmt: skip


def _unit(i: int, j: int) -> str:
    return ("(N/m)", "(N/rad)", "(Nm/rad)")[(i > 2) + (j > 2)]


def matrix_of(source: Source, options: Options) -> Linear:
    """Return the matrix (6, 6) with z up, at rest or at a load, and the sentences on what a matrix loses."""
    found = linear(Springs.of(source.springs), options)
    return found if found.stiffness[5, 5] else replace(found, lines=[*found.lines, NO_TORSION])


def write_subdyn(head: Sequence[str], stiffness: np.ndarray, target: Target) -> list:
    """Write the SSI file (stiffness, and no added mass) and the rows of a spring element; return their paths."""
    lines = commented("!", [*head, FREE_BASE])
    lines += [f"{stiffness[i, j]:24.15E}  {label}" for label, i, j in labels("K")]
    lines += [f"{0.0:24.15E}  {label}" for label, _, _ in labels("M")]
    return [
        target.write("subdyn_ssi.dat", "\n".join(lines) + "\n"),
        target.write("subdyn_spring.dat", spring_element_text(head, stiffness)),
    ]


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write the SSI file and the spring element."""
    found = matrix_of(source, options)
    head = [*header(source, f"SubDyn foundation matrix: {found.name}", FRAME, UNITS), *found.lines]
    return Exported(write_subdyn(head, found.stiffness, target), [*found.lines, FREE_BASE])
