# SPDX-License-Identifier: MIT
"""Laws of a model and their parameters, as the rows of arrays that the loops read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fe_engine.contact.law import ContactLaw
from fe_engine.contact.laws import CONTACT_LAWS
from fe_engine.soil.law import SoilLaw
from fe_engine.soil.laws import SOIL_LAWS

Shapes = dict[str, tuple[tuple[int, ...], tuple[int, ...]]]


@dataclass(frozen=True)
class Material:
    """A soil law with its packed parameters: (n,), (k, n) for the k elements of the material, or (k, np, n) by point.

    The rows stand in the order of the elements' numbers; points are those of hex8 or, of a series, of its section.
    """

    law: SoilLaw
    parameters: np.ndarray


class HasLaws(Protocol):
    """A model with soil and an interface: see model.Model."""

    materials: list[Material]
    material: np.ndarray
    contact: np.ndarray
    contact_laws: tuple[ContactLaw, ...]
    contact_law: np.ndarray | None
    initial_pressure: np.ndarray


def soil_rows(model: HasLaws) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the codes of the laws (ne,), their parameters (ne, r, n), and K and G (ne, r, 2) in Pa.

    r is the number of points of an element, or 1 where no material varies inside its elements. Rows of laws with fewer
    parameters than the widest end with NaN.
    """
    ne, r = len(model.material), max((_by_point(each).shape[-2] for each in model.materials), default=1)
    code, moduli = np.zeros(ne, dtype=np.int64), np.zeros((ne, r, 2))
    parameters = np.full((ne, r, max(len(each.law.parameters) for each in model.materials)), np.nan)
    for number, each in enumerate(model.materials):
        mine, given = model.material == number, _by_point(each)
        code[mine] = SOIL_LAWS.code(each.law)
        parameters[mine, :, : given.shape[-1]] = given
        moduli[mine] = np.stack(np.broadcast_arrays(*each.law.moduli(given)), axis=-1)
    return code, parameters, moduli


def _by_point(material: Material) -> np.ndarray:
    """Return the parameters (1, n), (k, 1, n) or (k, np, n)."""
    p = material.parameters
    return p[:, None] if p.ndim == 2 else p[None] if p.ndim == 1 else p


def history_size(model: HasLaws) -> int:
    """Return the number of history variables of a point: those of the law that has most."""
    return max(len(each.law.history) for each in model.materials)


def history_of(model: HasLaws, history: np.ndarray, name: str) -> np.ndarray:
    """Return a history variable (ne, np) by its name, 0 in elements whose law does not have it."""
    values = np.zeros(history.shape[:2])
    for number, each in enumerate(model.materials):
        if name in each.law.history:
            mine = model.material == number
            values[mine] = history[mine, :, each.law.history.index(name)]
    return values


def material_shapes(model: HasLaws) -> Shapes:
    """Return the shapes of the materials' parameters beside those that they must have."""
    shapes: Shapes = {}
    for number, each in enumerate(model.materials):
        shape, n = each.parameters.shape, len(each.law.parameters)
        rows = () if len(shape) == 1 else (int(np.count_nonzero(model.material == number)), *shape[1:-1][:1])
        shapes[f"parameters of material {number} ({each.law.name})"] = shape, (*rows, n)
    return shapes


def contact_rows(model: HasLaws) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return for each station the code of its law (ns,), its parameters (ns, n), and K_N and K_T (ns, 2) in N/m3."""
    ns = len(model.initial_pressure)
    # a copy: the loops are compiled once more for read-only rows
    rows = np.array(np.broadcast_to(model.contact, (ns, model.contact.shape[1])))
    code, penalties = np.zeros(ns, dtype=np.int64), np.zeros((ns, 2))
    for law, mine in _stations_by_law(model):
        code[mine] = CONTACT_LAWS.code(law)
        penalties[mine] = np.stack(law.penalties(rows[mine]), axis=-1)
    return code, rows, penalties


def contact_gaps(model: HasLaws, normal_jump: np.ndarray) -> np.ndarray:
    """Return the openings (ns,) in m, 0 where stations are closed, from the normal jumps (ns,) since the start."""
    gaps = np.zeros(len(normal_jump))
    rows = np.broadcast_to(model.contact, (len(normal_jump), model.contact.shape[1]))
    for law, mine in _stations_by_law(model):
        gaps[mine] = law.gap(rows[mine], model.initial_pressure[mine], normal_jump[mine])
    return gaps


def is_smooth(model: HasLaws) -> bool:
    """Return whether the tangent of every station is symmetric."""
    rows = np.broadcast_to(model.contact, (len(model.initial_pressure), model.contact.shape[1]))
    return all(bool(np.all(law.smooth(rows[mine]))) for law, mine in _stations_by_law(model))


def contact_shapes(model: HasLaws) -> Shapes:
    """Return the shapes of the contact's parameters and codes beside those that they must have."""
    ns, rows = len(model.initial_pressure), len(model.contact)
    shapes: Shapes = {"contact": (model.contact.shape, (rows if rows == 1 else ns, _widest(model.contact_laws)))}
    if model.contact_law is not None:
        shapes["contact_law"] = model.contact_law.shape, (ns,)
    return shapes


def _widest(laws: Sequence[ContactLaw]) -> int:
    return max(len(law.parameters) for law in laws)


def _stations_by_law(model: HasLaws) -> Iterator[tuple[ContactLaw, np.ndarray]]:
    ns = len(model.initial_pressure)
    for number, law in enumerate(model.contact_laws):
        yield law, np.full(ns, number == 0) if model.contact_law is None else model.contact_law == number
