# SPDX-License-Identifier: MIT
"""SACS PSI: P-Y, T-Z and Q-Z cards of a pile that is the caisson; not run in SACS.

P-Y cards have no moments: what turns against the rotation (m, M_tip, M_lid) is lost, and the error of that is printed.
Forces of tip and lid join the slices beside them. Cards have fixed columns, six characters a number (metric: m, cm,
kN/cm, kN/cm2), after the SACS 2024 PSI manual, 2.4.3.7, 2.4.3.8 and 2.4.5.2 (T-Z, Q-Z and P-Y curves of the user).
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.text import commented
from pysprings.macro.solver import row_values
from pysprings.results.exporters.base import ZONE, Exported, Options, Source, Target
from pysprings.results.exporters.header import header, springs_at
from pysprings.results.exporters.uniaxial_curve import Spring, Table, table
from pysprings.results.exporters.uniaxial_sets import (
    Uniaxial,
    change_by_tables,
    errors_by_role,
    no_heave,
    uniaxial,
    with_tables,
)
from pysprings.springs.springs import Springs

WIDTH = 6  # characters of a number
PAIRS = 5  # a line
MOST = 30  # points of a curve: more need a number of points on the header that was not seen in use
_NUMBER = re.compile(r"([-+]?\d*\.\d*)([-+]\d+)?")


@dataclass(frozen=True, slots=True)
class Kind:
    """Words and columns of a family of curves: header, stratum, data; its factor and where that stands.

    Reactions are multiplied by the factor: T and Q in kN/cm2 are small, and have more digits in units of 0.001.
    """

    head: str
    stratum: str
    data: str
    column: int
    factor: str


PY = Kind("SOIL LATERAL HEAD", "SOIL P-Y", "P-Y", 37, " 1.0")
TZ = Kind("SOIL TZAXIAL HEAD", "SOIL T-Z", "T-Z", 39, " 0.001")
QZ = Kind("SOIL BEARING HEAD", "SOIL BEAR", "T-Z", 39, " 0.001")


@dataclass(frozen=True, slots=True, eq=False)
class Stratum:
    """A curve between two depths below the pile head [m]: reactions f over displacements q in the units of the cards.

    Symmetric curves hold q >= 0.
    """

    top: float
    bottom: float
    q: Array
    f: Array
    symmetric: bool


def number(value: float) -> str:
    """Return at most six characters, those nearest to a value; small ones in Fortran's way ("1.23-4")."""
    cells = [f"{value:.{digits}f}" for digits in range(6)]
    cells[0] += "."
    cells = [re.sub(r"^(-?)0\.(?=\d)", r"\1.", cell) for cell in cells]
    if value:
        for digits in range(5):
            mantissa, power = f"{value:.{digits}e}".split("e")
            cells.append(f"{mantissa}{'' if digits else '.'}{int(power):+d}")
    fitting = [cell for cell in cells if len(cell) <= WIDTH]
    return min(fitting, key=lambda cell: (abs(read(cell) - value), len(cell)))


def read(cell: str) -> float:
    """Return the value of a number of a card."""
    found = _NUMBER.fullmatch(cell.strip())
    if found is None:
        raise ValueError(f"'{cell}' is no number of a card")
    return float(f"{found[1]}e{found[2] or 0}")


def rounded(stratum: Stratum) -> Stratum:
    """Return a stratum with the numbers as the cards hold them; displacements that are alike there count once."""
    q, f = (np.array([read(number(float(value))) for value in values]) for values in (stratum.q, stratum.f))
    keep = np.concatenate([[True], np.diff(q) > 0.0])
    return Stratum(stratum.top, stratum.bottom, q[keep], f[keep], stratum.symmetric)


def cards(kind: Kind, strata: Sequence[Stratum], name: str, diameter: float | None = None) -> Iterator[str]:
    """Yield the lines of a family; diameter [cm] is the reference of P-Y curves (the pile's own: P stays as it is)."""
    most = max(each.q.size for each in strata)
    reference = [(28, f"{diameter:6.1f}")] if diameter is not None else []
    yield _card((1, kind.head), (18, f"{len(strata):3d}"), (21, f"{most:3d}"), *reference, (41, f"{name:4.4s}"))
    for each in strata:
        marks = (14, "SLOC"), (18, "SM" if each.symmetric else "  "), (22, f"{each.q.size:2d}")
        yield _card(
            (1, kind.stratum), *marks, (25, _depth(each.top)), (31, _depth(each.bottom)), (kind.column, kind.factor)
        )
        for k in range(0, each.q.size, PAIRS):
            cells = [number(float(v)) for pair in zip(each.f, each.q, strict=True) for v in pair][2 * k :][: 2 * PAIRS]
            fields = [(18 + WIDTH * i, f"{cell:>{WIDTH}}") for i, cell in enumerate(cells)]
            yield _card((1, "SOIL"), (14, kind.data), *fields)


def _depth(value: float) -> str:
    cell = f"{value:6.3f}"
    return cell if len(cell) <= WIDTH else f"{value:6.2f}"


def _card(*fields: tuple[int, str]) -> str:
    """Return a line of 80 columns with fields from their first columns (1-based) on."""
    line = [" "] * 80
    for start, words in fields:
        line[start - 1 : start - 1 + len(words)] = words
    return "".join(line).rstrip()


FINE = 801
CM, KN_PER_CM, N_PER_CM2 = 1e-2, 1e5, 1e4  # in SI; T and Q have the factor 0.001
_FRAME = "pile axis down; depths from the pile head [m]; z of T-Z and Q-Z positive downwards (pile in compression)"
_UNITS = "metric: depth m, P kN/cm, y and z cm, T and Q 0.001 kN/cm2 (factor 0.001 in columns 39-44; that of P is 1)"
_LOST = (
    "the pile is the caisson: give it a very stiff section; PSI takes other actions of the pile by itself",
    "torsion is not written: PSI takes GJ/L of the pile without it, and warns",
    "the vertical curves are changes from the state at rest: PSI begins at zero load",
    "lateral curves do not depend on V; PSI resolves them in the two local planes of the pile",
    "nonlinear elastic (monotonic backbone): no hysteresis, no memory; curves are flat behind their last point",
)


def _lateral(made: Uniaxial) -> tuple[list[Spring], list[str]]:
    """Return the p springs of all slices, with forces of tip and lid in the slice beside; and what is left out."""
    slices = [each for each in made.springs if each.direction == "lateral" and each.height > 0.0]
    if not slices:
        raise refused("springs", f"the set '{made.model.spring_set}' has no p-y springs")
    ends = [each for each in made.springs if each.direction == "lateral" and each.height == 0.0]
    turning = sorted({each.name for each in made.springs if each.direction == "rotation"})
    lost = [f"no P-Y card for what acts against the rotation: {', '.join(turning)}"] if turning else []
    if ends:
        lost.append(f"forces of {', '.join(each.name for each in ends)} act on the slices beside them")
    for end in ends:
        k = min(range(len(slices)), key=lambda j: abs(slices[j].depth - end.depth))
        slices[k] = _sum(slices[k], end)
    return slices, lost


def _sum(one: Spring, other: Spring) -> Spring:
    force, more = one.force, other.force
    reach = min(one.high, other.high)
    return replace(one, low=-reach, high=reach, force=lambda x: force(x) + more(x))


def _vertical(made: Uniaxial) -> tuple[list[Spring], list[Spring]]:
    """Return springs t [N/m] of all slices, and the sum of tip and lid [N], over the change of w from rest."""
    table = made.model.vertical
    if table is None:
        return [], []
    down, up = table.branch(1.0), table.branch(-1.0)
    high, low = (0.0 if each is None else each.end[0] for each in (down, up))

    def spring(name: str, depth: float, height: float, rows: list[int]) -> Spring:
        def force(x: np.ndarray) -> np.ndarray:
            out = np.zeros(x.size)
            for branch in filter(None, (down, up)):
                own = branch.sign * x > 0.0
                count = np.full(len(rows), branch.x.size)
                knots = np.tile(branch.x, (len(rows), 1))
                q = np.tile(np.minimum(np.abs(x[own]), branch.x[-1]), (len(rows), 1))
                values = row_values(knots, branch.r[rows], branch.slope[rows], count, q) - branch.r[rows][:, :1]
                out[own] = values.sum(axis=0)
            return out

        return Spring(name, "vertical", depth, height, -low, high, force)

    skirt = [spring("t", float(table.depth[j]), float(table.b[j]), [int(j)]) for j in np.flatnonzero(table.name == "t")]
    ends = [int(j) for j in np.flatnonzero(np.isin(table.name, ("V_tip", "V_lid")))]
    return skirt, [spring("q", float(table.depth.max()), 0.0, ends)] if ends else []


def _stratum(given: Table, bounds: tuple[float, float], unit: float) -> Stratum:
    """Return the curve of a table, reactions in `unit` of SI, as the cards hold it."""
    odd = given.spring.odd
    used = given.q >= 0.0 if odd else slice(None)
    return rounded(Stratum(*bounds, given.q[used] / CM, given.f[used] / unit, odd))


def _bounds(made: Uniaxial, depth: float, head: float) -> tuple[float, float]:
    """Return top and bottom of the slice at a depth [m], below the pile head."""
    edges = made.model.origin["depth_bounds"]
    k = int(np.argmin(np.abs(made.model.origin.depth - depth)))
    return head + float(edges[k, 0]), head + float(edges[k, 1])


def _as_written(given: Table, stratum: Stratum, unit: float) -> Table:
    """Return a symmetric table with the numbers of the cards, in SI."""
    q, f = stratum.q * CM, stratum.f * unit
    spring = replace(given.spring, low=-float(q[-1]), high=float(q[-1]))
    return replace(given, spring=spring, q=np.concatenate([-q[:0:-1], q]), f=np.concatenate([-f[:0:-1], f]))


def _texts(source: Source, options: Options) -> tuple[list[str], list[str], Springs]:
    """Return the lines of the cards, the sentences on what is lost, and the springs at their rate and load."""
    points = int(options["points"])
    if not 3 <= points <= MOST:
        raise refused("--option points", f"{points} is not from 3 to {MOST}")
    springs, load = springs_at(source, options)
    made = uniaxial(springs, options["springs"], load, planes=2, slices=ZONE)
    axial, words = _axial_cards(springs, made, options)
    lateral, errors = _lateral_cards(springs, made, options)
    lost = [f"springs '{made.model.spring_set}'", *made.lost, *_LOST, no_heave(springs), *words, *errors]
    return [*axial, *lateral], lost, springs


def _lateral_cards(springs: Springs, made: Uniaxial, options: Options) -> tuple[list[str], list[str]]:
    """Return P-Y cards, and sentences on what they lose, with the errors of the curves as they are written."""
    head, (slices, lost) = float(options["head"] or 0.0), _lateral(made)
    strata, written = [], []
    for given in (table(each, 2 * int(options["points"]) - 1) for each in slices):
        unit = KN_PER_CM * given.spring.height
        strata.append(_stratum(given, _bounds(made, given.spring.depth, head), unit))
        written.append(_as_written(given, strata[-1], unit))
    fine, carried = with_tables(made, [table(each, FINE) for each in slices]), with_tables(made, written)
    lost += [change_by_tables(springs, fine, carried), *errors_by_role(springs, carried, "error of these P-Y cards")]
    return list(cards(PY, strata, str(options["soil"]), 100.0 * springs.diameter)), lost


def _axial_cards(springs: Springs, made: Uniaxial, options: Options) -> tuple[list[str], list[str]]:
    """Return T-Z and Q-Z cards, and sentences on them; no cards without vertical paths."""
    skirt, end = _vertical(made)
    if not skirt:
        return [], ["no T-Z and Q-Z cards: the springs have no vertical paths"]
    head, soil = float(options["head"] or 0.0), str(options["soil"])
    points = min(2 * int(options["points"]) - 1, MOST)  # of both sides
    thickness = float(springs.attrs["skirt_thickness_m"])
    area = math.pi * (springs.diameter - thickness) * thickness
    around = N_PER_CM2 * math.pi * springs.diameter
    strata = [_stratum(table(each, points), _bounds(made, each.depth, head), around) for each in skirt]
    lines = list(cards(TZ, strata, soil))
    bounds = head, head + springs.length + 1.0
    strata = [_stratum(table(each, points), bounds, N_PER_CM2 * area) for each in end]
    return [*lines, *(cards(QZ, strata, soil) if end else ())], list(_axial(made, area))


def _axial(made: Uniaxial, area: float) -> Iterator[str]:
    yield "T is the net of both walls over the outer circumference"
    yield f"Q is (V_tip + V_lid)/{area:.6g} m2, the tip of the wall: give the pile this end area (not plugged)"
    table = made.model.vertical
    for change, words in ((1.0, "pressed down"), (-1.0, "pulled up")):
        if table is not None and table.branch(change) is None:
            yield f"no vertical path of a caisson that is {words}: T-Z and Q-Z carry nothing there"


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write the cards."""
    lines, lost, at = _texts(source, options)
    head = [*header(source, "SACS PSI soil cards (not run in SACS)", _FRAME, _UNITS, at=at), *lost]
    text = "\n".join([*commented("*", head, 76), *lines]) + "\n"
    return Exported([target.write("caisson_sacs.inp", text)], lost)
