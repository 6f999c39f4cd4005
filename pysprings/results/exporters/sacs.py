# SPDX-License-Identifier: MIT
"""SACS PSI: P-Y, M-T, T-Z and Q-Z cards of a rigid pile that stands for the caisson; not run in SACS.

Virtual springs of a fan stand in strata down to twice the skirt length, so that a pile of that length carries them;
springs at real depths in those of the skirt, forces of tip and lid in the strata beside. What turns against the
rotation is one M-T stratum: on a rigid pile its depth is all the same. Cards have fixed columns, six characters a
number (metric: m, cm, kN/cm, kN m/cm, kN/cm2), after the SACS 2024 PSI manual, 2.4.3.7, 2.4.3.8, 2.4.5.2, 2.4.6.1 and
chapter 9 (T-Z, Q-Z, P-Y and M-T curves of the user).
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.text import commented
from pysprings.results.exporters.base import VIRTUAL, ZONE, Exported, Options, Source, Target
from pysprings.results.exporters.header import header, springs_at
from pysprings.results.exporters.uniaxial_curve import Spring, Table, table
from pysprings.results.exporters.uniaxial_sets import (
    OPPOSED,
    Uniaxial,
    change_by_tables,
    errors_by_role,
    no_heave,
    on_a_pile,
    uniaxial,
    with_tables,
)
from pysprings.springs.springs import Springs

WIDTH = 6  # characters of a number
PAIRS = 5  # a line
HIGHEST = 900.0  # m, of a pile head
MOST = 30  # points of a curve: more need a number of points on the header that was not seen in use
_NUMBER = re.compile(r"([-+]?\d*\.\d*)([-+]\d+)?")


@dataclass(frozen=True, slots=True)
class Kind:
    """Words and columns of a family of curves: header, stratum, data; its factor and where that stands.

    Reactions are multiplied by the factor: T and Q in kN/cm2 are small, and have more digits in units of 0.001.
    diameter : column and width of the reference diameter.
    """

    head: str
    stratum: str
    data: str
    column: int
    factor: str
    diameter: tuple[int, int] = (0, 0)


PY = Kind("SOIL LATERAL HEAD", "SOIL P-Y", "P-Y", 37, " 1.0", (28, 6))
MT = Kind("SOIL BENDING HEAD", "SOIL M-T", "M-T", 39, " 1.0", (45, 7))
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


def cards(
    kind: Kind, strata: Sequence[Stratum], name: str, diameter: float = 0.0, *flags: tuple[int, str]
) -> Iterator[str]:
    """Yield the lines of a family; diameter [cm] is the reference (the pile's own: P and M stay), flags of its head."""
    most = max(each.q.size for each in strata)
    column, width = kind.diameter
    reference = [(column, f"{diameter:{width}.1f}")] if column else []
    head = (1, kind.head), (18, f"{len(strata):3d}"), (21, f"{most:3d}"), *reference, (41, f"{name:4.4s}")
    yield _card(*head, *flags)
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
    cell = f"{value:z6.3f}"  # no -0.000
    return cell if len(cell) <= WIDTH else f"{value:6.2f}"


def _card(*fields: tuple[int, str]) -> str:
    """Return a line of 80 columns with fields from their first columns (1-based) on."""
    line = [" "] * 80
    for start, words in fields:
        line[start - 1 : start - 1 + len(words)] = words
    return "".join(line).rstrip()


FINE = 801
CM, KN_PER_CM, N_PER_CM2 = 1e-2, 1e5, 1e4  # in SI, kN m/cm as kN/cm; T and Q have the factor 0.001
GAP = 1e-6  # m, between strata: rounding
_FRAME = "pile axis down; depths from the pile head [m]; z of T-Z and Q-Z positive downwards (pile in compression)"
_UNITS = (
    "metric: depth m, P kN/cm, y and z cm, M kN m/cm, theta rad, T and Q 0.001 kN/cm2 (factor 0.001 in columns 39-44; "
    "those of P and M are 1)"
)
_LOST = (
    "PSI takes other actions of the pile by itself; its own base shear and base moment are switched off",
    "torsion is not written: PSI takes GJ/L of the pile without it, and warns",
    "the vertical curves are changes from the state at rest: PSI begins at zero load",
    "lateral curves do not depend on V; PSI resolves them in the two local planes of the pile",
    "nonlinear elastic (monotonic backbone): no hysteresis, no memory; curves are flat behind their last point",
)
_PREVIEW = (
    "M-T cards (all that turns against the rotation): a technical preview in PSI, full in Pile3D (manual of 2024)"
)


def _made(springs: Springs, kind: str, V: float | None) -> tuple[Uniaxial, list[Spring], float, str]:
    """Return the springs, lateral ones by stratum, the length of the pile [m], and words on it."""
    if kind == VIRTUAL:
        made, length = on_a_pile(springs, V)
        words = f"the pile stands for the whole foundation: {length:g} m below mudline, very stiff; {OPPOSED}"
        return made, [each for each in made.springs if each.direction == "lateral"], length, words
    made = uniaxial(springs, kind, V, planes=2, slices=ZONE)
    own = [each for each in made.springs if each.direction == "lateral"]
    strata = [each for each in own if each.height > 0.0]
    if not strata:
        raise refused("springs", f"the set '{made.model.spring_set}' has no p-y springs")
    others = [each for each in own if each.height == 0.0]
    for end in others:
        k = min(range(len(strata)), key=lambda j: abs(strata[j].depth - end.depth))
        strata[k] = _sum(strata[k], end)
    joined = f"; forces of {', '.join(each.name for each in others)} act on the slices beside them" if others else ""
    words = f"the pile is the caisson: give it a very stiff section{joined}"
    return made, strata, springs.length, words


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
                values = branch.at(np.minimum(np.abs(x[own]), branch.x[-1]), rows) - branch.r[rows, :1]
                out[own] = values.sum(axis=0)
            return out

        return Spring(name, "vertical", depth, height, -low, high, force)

    skirt = [spring("t", float(table.depth[j]), float(table.b[j]), [int(j)]) for j in np.flatnonzero(table.name == "t")]
    ends = [int(j) for j in np.flatnonzero(np.isin(table.name, ("V_tip", "V_lid")))]
    return skirt, [spring("q", float(table.depth.max()), 0.0, ends)] if ends else []


def _stratum(given: Table, bounds: tuple[float, float], unit: float, of_q: float = CM) -> Stratum:
    """Return the curve of a table, reactions and displacements in units of SI, as the cards hold it."""
    odd = given.spring.odd
    used = given.q >= 0.0 if odd else slice(None)
    return rounded(Stratum(*bounds, given.q[used] / of_q, given.f[used] / unit, odd))


def _bounds(made: Uniaxial, spring: Spring) -> tuple[float, float]:
    """Return top and bottom [m] of the stratum or slice of a spring."""
    if spring.name == VIRTUAL:
        return spring.depth - 0.5 * spring.height, spring.depth + 0.5 * spring.height
    edges = made.model.origin["depth_bounds"]
    k = int(np.argmin(np.abs(made.model.origin.depth - spring.depth)))
    return float(edges[k, 0]), float(edges[k, 1])


def _whole(strata: Sequence[Stratum], length: float, head: float) -> list[Stratum]:
    """Return strata of a pile of a length [m] without gaps, those in between empty, at depths below the pile head."""
    out, edge = list[Stratum](), 0.0
    none = replace(strata[0], q=np.array([0.0, 1.0]), f=np.zeros(2), symmetric=True)
    for each in [*strata, replace(none, top=length, bottom=length)]:
        if each.top > edge + GAP:
            out.append(replace(none, top=edge, bottom=each.top))
        out.append(each)
        edge = each.bottom
    return [replace(each, top=head + each.top, bottom=head + each.bottom) for each in out[:-1]]


def _as_written(given: Table, stratum: Stratum, unit: float, of_q: float = CM) -> Table:
    """Return a symmetric table with the numbers of the cards, in SI."""
    q, f = stratum.q * of_q, stratum.f * unit
    spring = replace(given.spring, low=-float(q[-1]), high=float(q[-1]))
    return replace(given, spring=spring, q=np.concatenate([-q[:0:-1], q]), f=np.concatenate([-f[:0:-1], f]))


def _lateral_cards(
    springs: Springs, made: Uniaxial, options: Options, strata: list[Spring], length: float
) -> tuple[list[str], list[str]]:
    """Return P-Y and M-T cards, and sentences on what they lose, with the errors of the curves as they are written."""
    head, soil, diameter = float(options["head"] or 0.0), str(options["soil"]), 100.0 * springs.diameter
    turning = [each for each in made.springs if each.direction == "rotation"]
    turning = [replace(reduce(_sum, turning), depth=0.0, height=length)] if turning else []
    given = [table(each, 2 * int(options["points"]) - 1) for each in [*strata, *turning]]
    bounds = [_bounds(made, each) for each in strata]
    held, written = [], []
    for each, ends in zip(given, [*bounds, (0.0, length)], strict=False):
        units = KN_PER_CM * each.spring.height, CM if each.spring.direction == "lateral" else 1.0
        held.append(_stratum(each, ends, *units))
        written.append(_as_written(each, held[-1], *units))
    fine, carried = with_tables(made, [table(each.spring, FINE) for each in given]), with_tables(made, written)
    lost = [change_by_tables(springs, fine, carried), *errors_by_role(springs, carried, "error of these cards")]
    py = _whole(held[: len(strata)], length, head)
    lines = [*cards(PY, py, soil, diameter, (61, "NN"), (67, "Y" if turning else "N"))]
    if turning:
        lines += cards(MT, _whole(held[len(strata) :], length, head), soil, diameter)
    return lines, [*lost, *[_PREVIEW] * bool(turning)]


def _axial_cards(springs: Springs, made: Uniaxial, options: Options, length: float) -> tuple[list[str], list[str]]:
    """Return T-Z and Q-Z cards of a pile of a length [m], and sentences on them; no cards without vertical paths."""
    skirt, end = _vertical(made)
    if not skirt:
        return [], ["no T-Z and Q-Z cards: the springs have no vertical paths"]
    head, soil = float(options["head"] or 0.0), str(options["soil"])
    points = min(2 * int(options["points"]) - 1, MOST)  # of both sides
    thickness = float(springs.attrs["skirt_thickness_m"])
    area = math.pi * (springs.diameter - thickness) * thickness
    around = N_PER_CM2 * math.pi * springs.diameter
    strata = [_stratum(table(each, points), _bounds(made, each), around) for each in skirt]
    lines = list(cards(TZ, _whole(strata, length, head), soil))
    strata = [_stratum(table(each, points), (head, head + length + 1.0), N_PER_CM2 * area) for each in end]
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
    points = int(options["points"])
    if not 3 <= points <= MOST:
        raise refused("--option points", f"{points} is not from 3 to {MOST}")
    if not 0.0 <= (head := float(options["head"] or 0.0)) <= HIGHEST:
        room = f"from 0 to {HIGHEST:g} m above mudline, from where depths count down in six columns"
        raise refused("--option head", f"{head:g} m is not {room}")
    springs, load = springs_at(source, options)
    kind = str(options["springs"] or (VIRTUAL if springs.has_fan else "full"))
    made, strata, length, about = _made(springs, kind, load)
    axial, words = _axial_cards(springs, made, options, length)
    lateral, errors = _lateral_cards(springs, made, options, strata, length)
    lost = [f"springs '{made.model.spring_set}'", *made.lost, about, *_LOST, no_heave(springs), *words, *errors]
    above = [*header(source, "SACS PSI soil cards (not run in SACS)", _FRAME, _UNITS, at=springs), *lost]
    text = "\n".join([*commented("*", above, 76), *axial, *lateral]) + "\n"
    return Exported([target.write("caisson_sacs.inp", text)], lost)
