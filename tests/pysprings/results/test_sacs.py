# SPDX-License-Identifier: MIT
"""SACS PSI cards by a reader of fixed columns of its own, against the springs, and as somebody has read them."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.model import MacroModel
from pysprings.macro.vertical import build_vertical
from pysprings.results.exporters import Source, export, sacs
from pysprings.results.exporters.sacs import number
from pysprings.results.exporters.uniaxial_sets import uniaxial
from pysprings.springs.springs import Springs
from tests.support import stored, synthetic
from tests.support.fans import fan_springs, potential
from tests.support.vertical import vertical_springs

TEXTS = Path(__file__).parent / "texts"
HEADS = {
    "SOIL TZAXIAL HEAD": "T-Z", "SOIL BEARING HEAD": "T-Z", "SOIL LATERAL HEAD": "P-Y", "SOIL BENDING HEAD": "M-T",
}  # fmt: skip
Curve = tuple[float, float, bool, float, np.ndarray]  # top, bottom [m], symmetric, factor, pairs (force, displacement)


@pytest.fixture(scope="module")
def source() -> Source:
    return Source(vertical_springs())


@pytest.fixture(scope="module")
def cards(source: Source, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("sacs")
    export(source, "sacs", folder, springs="pisa", points=12)
    return (folder / "caisson_sacs.inp").read_text().splitlines()


def fortran(cell: str) -> float:
    """Value of a field of six columns: a decimal point, and an exponent without its letter."""
    cell = cell.strip()
    assert cell.count(".") == 1, cell
    sign = max(cell.rfind("+"), cell.rfind("-"))
    return float(cell) if sign <= 0 else float(cell[:sign] + "e" + cell[sign:])


def columns(line: str, first: int, last: int) -> str:
    return line.ljust(80)[first - 1 : last]


def read(lines: list[str]) -> dict[str, tuple[str, list[Curve]]]:
    """Families of cards: header line and curves; every line and every count is used up."""
    rows, out = iter([line for line in lines if not line.startswith("*")]), {}
    for head in rows:
        data = HEADS[columns(head, 1, 17)]
        curves: list[Curve] = []
        for _ in range(int(columns(head, 18, 20))):
            line = next(rows)
            assert columns(line, 14, 17) == "SLOC" and columns(line, 18, 19) in ("SM", "  ")
            points = int(columns(line, 22, 23))
            assert points <= int(columns(head, 21, 23)) <= 30
            field = (37, 40) if data == "P-Y" else (39, 44)
            values: list[float] = []
            while len(values) < 2 * points:
                card = next(rows)
                assert columns(card, 1, 13) == "SOIL         " and columns(card, 14, 17) == f"{data} "
                cells = [columns(card, 18 + 6 * k, 23 + 6 * k) for k in range(min(10, 2 * points - len(values)))]
                assert not columns(card, 18 + 6 * len(cells), 80).strip()
                values += [fortran(cell) for cell in cells]
            pairs = np.reshape(values, (-1, 2))
            depths = float(columns(line, 25, 30)), float(columns(line, 31, 36))
            curves.append((*depths, columns(line, 18, 19) == "SM", float(columns(line, *field)), pairs))
        out[columns(head, 1, 17)] = head, curves
    return out


def test_the_cards_are_those_that_somebody_has_read(cards: list[str]) -> None:
    stored.compare([line for line in cards if not line.startswith("*")], TEXTS / "sacs.txt", "SACS PSI cards")


def test_columns_counts_and_rules(cards: list[str]) -> None:
    assert all(len(line) <= 80 for line in cards)
    families = read(cards)
    assert list(families) == list(HEADS)  # axial, end bearing, lateral
    head, laterals = families["SOIL LATERAL HEAD"]
    assert columns(head, 28, 33) == " 780.0" and columns(head, 41, 44) == "SOL1"
    assert columns(head, 61, 62) == "NN" and columns(head, 67, 67) == "Y"  # tip by its springs, M-T cards
    assert columns(families["SOIL BENDING HEAD"][0], 41, 51) == "SOL1  780.0"
    for _, curves in families.values():
        for top, bottom, symmetric, _, pairs in curves:
            assert bottom > top >= 0.0
            assert (np.diff(pairs[:, 1]) > 0.0).all() and (pairs == 0.0).all(axis=1).any()
            assert not symmetric or (pairs[0] == 0.0).all()
    assert all(symmetric for _, _, symmetric, _, _ in laterals)
    bounds = [(top, bottom) for top, bottom, *_ in laterals]
    assert bounds[0][0] == 0.0 and all(a[1] == b[0] for a, b in pairwise(bounds))


def test_p_y_cards_carry_the_lateral_force_of_the_springs(source: Source, cards: list[str]) -> None:
    """Translation: p times height, forces of tip and lid included, within the error of twelve points."""
    _, laterals = read(cards)["SOIL LATERAL HEAD"]
    model = uniaxial(Springs.of(source.springs), "pisa").model
    for u in (5e-4, 2e-3, 8e-3):
        carried = sum(
            1e5 * (bottom - top) * np.interp(100.0 * u, pairs[:, 1], pairs[:, 0]) * factor
            for top, bottom, _, factor, pairs in laterals
        )
        assert carried == pytest.approx(model.reactions(u, 0.0)[0][0], rel=0.01)


@pytest.mark.parametrize("kind", ["virtual", "pisa"])
@pytest.mark.parametrize(("u", "rotation"), [(2e-3, 0.0), (2e-3, 5e-4), (0.0, 1e-3), (3e-3, -3e-4)])
def test_a_rigid_pile_on_the_cards_carries_the_loads_of_the_springs(
    kind: str, u: float, rotation: float, tmp_path: Path
) -> None:
    """P-Y by depth and M-T over the pile: H and M, those of the fan to what uniaxial springs leave."""
    tree = fan_springs(potential)
    export(Source(tree), "sacs", tmp_path, springs=kind)
    families = read((tmp_path / "caisson_sacs.inp").read_text().splitlines())
    H, M = 0.0, 0.0
    for top, bottom, _, _, pairs in families["SOIL LATERAL HEAD"][1]:
        depth = 0.5 * (top + bottom)
        y = u - depth * rotation
        p = 1e5 * (bottom - top) * np.sign(y) * np.interp(abs(100.0 * y), pairs[:, 1], pairs[:, 0])
        H, M = H + p, M - depth * p
    ((top, bottom, _, factor, pairs),) = families["SOIL BENDING HEAD"][1]
    M += 1e5 * factor * (bottom - top) * np.sign(rotation) * np.interp(abs(rotation), pairs[:, 1], pairs[:, 0])
    model = MacroModel.from_springs(tree, "fan" if kind == "virtual" else kind)
    exact, length = model.reactions(u, rotation)[0], model.length
    size = np.hypot(exact[0], exact[1] / length)
    assert np.hypot(H - exact[0], (M - exact[1]) / length) < (0.1 if kind == "virtual" else 0.02) * size
    assert bottom == (2.0 if kind == "virtual" else 1.0) * length


@pytest.mark.parametrize("ends", [(1e-2, -1e-2), (1e-2,), (-1e-2,)])
def test_t_z_and_q_z_cards_carry_the_vertical_force(tmp_path: Path, ends: tuple[float, ...]) -> None:
    """In compression and tension, where these are known, over the outer circumference and the annulus of the wall."""
    tree = vertical_springs(ends=ends)
    export(Source(tree), "sacs", tmp_path, springs="pisa", points=12)
    springs, families = Springs.of(tree), read((tmp_path / "caisson_sacs.inp").read_text().splitlines())
    vertical = build_vertical(springs)
    assert vertical is not None
    D, t = springs.diameter, float(springs.attrs["skirt_thickness_m"])
    for w in (-6e-3, -1e-3, 1e-3, 6e-3):
        force = sum(
            1e7 * factor * np.pi * D * (bottom - top) * np.interp(100.0 * w, pairs[:, 1], pairs[:, 0])
            for top, bottom, _, factor, pairs in families["SOIL TZAXIAL HEAD"][1]
        )
        ((*_, factor, pairs),) = families["SOIL BEARING HEAD"][1]
        force += 1e7 * factor * np.pi * (D - t) * t * np.interp(100.0 * w, pairs[:, 1], pairs[:, 0])
        change = vertical.reactions(np.array([vertical.rest[0] + w]))[-1, 0] - vertical.rest[1]
        assert force == pytest.approx(change if vertical.branch(w) else 0.0, rel=0.01)


def test_six_characters_hold_a_number() -> None:
    random = np.random.default_rng(4)
    values = 10.0 ** random.uniform(-6.0, 4.9, 2000) * random.choice([-1.0, 1.0], 2000)
    for value in values:
        cell = number(float(value))
        assert len(cell) <= 6
        assert fortran(cell) == pytest.approx(value, rel=6e-3 if value > 0.0 else 6e-2)
        if 0.1 <= abs(value) < 9000.0:
            assert fortran(cell) == pytest.approx(value, rel=6e-5 if value > 0.0 else 6e-4)
    assert fortran(number(0.0)) == 0.0
    mudline = sacs.Stratum(-1e-17, 0.417, np.array([0.0, 1.0]), np.array([0.0, 1.0]), symmetric=True)
    assert list(sacs.cards(sacs.PY, [mudline], "MUD"))[1][24:36] == " 0.000 0.417"


def test_what_the_cards_cannot_hold_is_named_with_its_error(source: Source, tmp_path: Path) -> None:
    done = export(source, "sacs", tmp_path, springs="pisa", head=2.0)
    text = (tmp_path / "caisson_sacs.inp").read_text()
    for words in ("M-T cards (all that turns against the rotation)", "torsion is not written", "error of these cards"):
        assert any(words in remark for remark in done.remarks), words
    plain = " ".join(line.strip("* ") for line in text.splitlines() if line.startswith("*"))
    assert all(remark in plain for remark in done.remarks)
    assert "not run in SACS" in plain and str(source.springs.attrs["scene_sha256"]) in plain
    tops = [top for _, curves in read(text.splitlines()).values() for top, *_ in curves]
    assert min(tops) == 2.0  # below the pile head
    with pytest.raises(UserInputError, match="31 is not from 3 to 30"):
        export(source, "sacs", tmp_path, points=31)
    for head in (-2.0, 20_000.0):
        with pytest.raises(UserInputError, match=r"head: .* m is not from 0 to 900 m above mudline"):
            export(source, "sacs", tmp_path, head=head)


def test_without_vertical_paths_there_are_no_axial_cards(tmp_path: Path) -> None:
    done = export(Source(synthetic.make_springs()), "sacs", tmp_path, springs="py")
    assert list(read((tmp_path / "caisson_sacs.inp").read_text().splitlines())) == ["SOIL LATERAL HEAD"]
    assert any("no T-Z and Q-Z cards" in remark for remark in done.remarks)
