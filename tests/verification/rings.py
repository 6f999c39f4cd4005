# SPDX-License-Identifier: MIT
"""Contact pressure and opening around the rings of a skirt, and a measure of their alternation from point to point.

Stiff penalties at integration points that couple the nodes of a face make pressures swing about the true ones
(Schellekens & de Borst 1993). The measure works on stations at any spacing, so that nodal and Gauss stations can
be set side by side; a ring is the stations of one wall at one depth, with their mirror images.
"""

from dataclasses import dataclass

import numpy as np

from fe_engine.assembly.kernels_stations import station_jumps
from fe_engine.contact import coulomb
from fe_engine.state import Fields
from pysprings.model.contact import SURFACE
from tests.verification.pushes import Push


@dataclass(frozen=True)
class Ring:
    """Azimuth (n,) in [0, pi], ascending, with the contact pressure (n,) in Pa and the opening (n,) in m."""

    azimuth: np.ndarray
    pressure: np.ndarray
    gap: np.ndarray


@dataclass(frozen=True)
class Alternation:
    """How much a set of rings alternates.

    ``swing`` : three second differences that follow each other with changing signs, the smallest of them, over the
    ring's mean pressure; the largest such. A smooth curve, a kink and the step at the edge of an open zone give next
    to nothing, a swing of +-s from point to point gives 4 s, one point that stands out by s gives s. ``isolated`` :
    stations without pressure between two loaded ones; ``widest`` : their largest opening in m. A station in the
    symmetry plane is not counted: its neighbours mirror each other, and an open zone begins there with one station.
    """

    swing: float
    isolated: int
    widest: float


def alternation(rings: list[Ring]) -> Alternation:
    """Measure the alternation of the pressure, and of opening, around rings."""
    swing, isolated, widest = 0.0, 0, 0.0
    for ring in rings:
        azimuth, pressure = _whole(ring)
        difference = _second_difference(azimuth, pressure)
        swing = max(swing, _swing(difference) / max(float(pressure.mean()), 1.0))
        loaded = pressure > 0.0
        alone = ~loaded & np.roll(loaded, 1) & np.roll(loaded, -1)
        alone = alone[: len(ring.azimuth)] & _off_plane(ring.azimuth)
        isolated += int(np.count_nonzero(alone))
        widest = max(widest, float(ring.gap[alone].max(initial=0.0)))
    return Alternation(swing, isolated, widest)


def _off_plane(azimuth: np.ndarray) -> np.ndarray:
    """True where a station has a mirror image of its own."""
    return (azimuth > 1e-9) & (azimuth < np.pi - 1e-9)


def _whole(ring: Ring) -> tuple[np.ndarray, np.ndarray]:
    """The ring with its mirror images behind it: azimuth from 0 to 2 pi, and pressure."""
    image = np.flatnonzero(_off_plane(ring.azimuth))[::-1]
    azimuth = np.concatenate([ring.azimuth, 2.0 * np.pi - ring.azimuth[image]])
    return azimuth, np.concatenate([ring.pressure, ring.pressure[image]])


def _second_difference(azimuth: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Twice the distance of each value from the straight line between its neighbours on the circle."""
    before = np.mod(azimuth - np.roll(azimuth, 1), 2.0 * np.pi)
    after = np.mod(np.roll(azimuth, -1) - azimuth, 2.0 * np.pi)
    line = (np.roll(value, 1) * after + np.roll(value, -1) * before) / (before + after)
    return 2.0 * (line - value)


def _swing(difference: np.ndarray) -> float:
    """Largest of the smallest size of three neighbours whose signs change twice."""
    three = np.stack([np.roll(difference, 1), difference, np.roll(difference, -1)])
    changes = (three[0] * three[1] < 0.0) & (three[1] * three[2] < 0.0)
    return float(np.where(changes, np.abs(three).min(axis=0), 0.0).max())


def skirt_rings(push: Push, state: Fields) -> list[Ring]:
    """All rings of both walls at a state."""
    stations, model = push.stations, push.built.model
    jump = station_jumps(push.system.stations, state.displacement, state.border)
    gap = coulomb.gap(model.contact, model.initial_pressure, jump[:, 0])
    x, y, z = stations.position.T
    azimuth = np.arctan2(y, x)
    found = []
    for name in ("outer", "inner"):
        mine = stations.surface == SURFACE[name]
        for depth in np.unique(np.round(z[mine], 9)):
            ring = np.flatnonzero(mine & (np.abs(z - depth) < 1e-8))
            ring = ring[np.argsort(azimuth[ring])]
            found.append(Ring(azimuth[ring], -state.traction[ring, 0], gap[ring]))
    return found
