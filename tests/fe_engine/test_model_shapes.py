# SPDX-License-Identifier: MIT
"""Every array of a model that has another shape than its parts ask for is refused, by name, with both shapes."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fe_engine.errors import ModelError
from fe_engine.material import Material
from fe_engine.model import Model, Water
from fe_engine.soil import plasol
from tests.support.fourier_models import disc
from tests.support.models import SAND, mixed, wet


def refused(model: Any, name: str, got: tuple[int, ...], expected: tuple[int, ...]) -> None:
    with pytest.raises(ModelError, match=re.escape(f"{name} has shape {got}, expected {expected}") + "$"):
        model.check()


def longer(array: np.ndarray, axis: int = 0) -> np.ndarray:
    """The array with one row more."""
    return np.concatenate([array, np.take(array, [0], axis=axis)], axis=axis)


@pytest.mark.parametrize("name", ["material", "initial_stress", "fixed", "border_scale", "initial_pressure"])
@pytest.mark.parametrize("make", [mixed, disc])
def test_arrays_of_a_model(make: Any, name: str) -> None:
    model = make()
    model.check()
    array = getattr(model, name)
    if name == "initial_pressure":  # by which contact is judged, too
        count, rows = len(array), model.contact
        model = replace(model, initial_pressure=longer(array), contact=rows[:1])
        refused(model, name, (count + 1,), (count,))
        return
    refused(replace(model, **{name: longer(array)}), name, (len(array) + 1, *array.shape[1:]), array.shape)


def test_sizes_of_a_model_are_those_of_its_mesh() -> None:
    model = mixed()
    ne, n, ns = model.mesh.n_elements, model.mesh.n_nodes, len(model.stations)
    assert model.material.shape == (ne,) and model.initial_stress.shape == (ne, 8, 6) and model.fixed.shape == (n, 3)
    assert model.border_scale.shape == (4,) and model.initial_pressure.shape == (ns,)
    series = disc(harmonics=3)
    points = 4 * series.azimuths
    assert series.initial_stress.shape == (series.mesh.n_elements, points, 6)
    assert series.displacement_shape == (series.mesh.n_nodes, 3, 4) and model.displacement_shape == (n, 3)


def test_stations_of_a_series() -> None:
    model = disc()
    stations, ns = model.stations, len(model.stations)
    shorter = replace(stations, azimuth=stations.azimuth[:-1])
    refused(replace(model, stations=shorter), "stations.azimuth", (ns - 1,), (ns,))
    twice = replace(stations, nodes=np.repeat(stations.nodes, 2, axis=1))
    refused(replace(model, stations=twice), "stations.nodes", (ns, 2), (ns, 1))
    with pytest.raises(ModelError, match=r"^2 azimuths cannot resolve 2 harmonics: take more$"):
        few = model.initial_stress[:, : 4 * 2]
        replace(model, azimuths=2, initial_stress=few).check()


def test_contact_and_its_laws() -> None:
    model = mixed()
    ns, rows = len(model.stations), model.contact
    refused(replace(model, contact=rows[:-1]), "contact", (ns - 1, rows.shape[1]), rows.shape)
    refused(replace(model, contact=rows[:1, :-1]), "contact", (1, rows.shape[1] - 1), (1, rows.shape[1]))
    replace(model, contact=rows[:1]).check()  # one row for all
    law = np.zeros(ns, dtype=np.int64)
    replace(model, contact_law=law).check()
    refused(replace(model, contact_law=law[1:]), "contact_law", (ns - 1,), (ns,))


def test_parameters_of_materials() -> None:
    """One row for all; a row an element; a row an element and point."""
    model, p = mixed(), plasol.LAW.pack(*SAND)
    mine = int((model.material == 0).sum())

    def with_rows(rows: np.ndarray) -> Model:
        return replace(model, materials=[Material(plasol.LAW, rows), model.materials[1]])

    name, n = f"parameters of material 0 ({plasol.LAW.name})", len(p)
    for good in (p, np.tile(p, (mine, 1)), np.tile(p, (mine, 8, 1))):
        with_rows(good).check()
    refused(with_rows(p[:-1]), name, (n - 1,), (n,))
    refused(with_rows(np.tile(p, (mine + 1, 1))), name, (mine + 1, n), (mine, n))
    refused(with_rows(np.tile(p, (mine - 1, 8, 1))), name, (mine - 1, 8, n), (mine, 8, n))
    refused(with_rows(np.tile(p[:-1], (mine, 8, 1))), name, (mine, 8, n - 1), (mine, 8, n))


def test_water_of_a_model() -> None:
    model = wet()
    water, n = model.water, model.mesh.n_nodes
    assert isinstance(water, Water) and water.film is not None and model.n_film == water.film.n_nodes > 0
    pressures = n + model.n_film
    model.check()
    model.water = replace(water, fixed=longer(water.fixed))
    refused(model, "water.fixed", (pressures + 1,), (pressures,))
    model.water = replace(water, initial=water.initial[1:])
    refused(model, "water.initial", (pressures - 1,), (pressures,))
    model.water = water
    with pytest.raises(ModelError, match=r"^a film needs the stations of an interface$"):
        replace(model, stations=None).check()
    model.water = replace(water, film=None, fixed=water.fixed[:n], initial=water.initial[:n])
    assert model.n_film == 0
    model.check()
    replace(model, stations=None).check()


def test_axes_of_a_node_and_a_station() -> None:
    model = mixed()
    node = int(model.stations.nodes[2, 0])
    with pytest.raises(ModelError, match=rf"^node {node} has axes of its own and a contact station; the stations read"):
        replace(model, frames={**model.frames, node: np.eye(3)}).check()
