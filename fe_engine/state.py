# SPDX-License-Identifier: MIT
"""Committed and trial state of a model; the only place where a state is committed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.fourier_model import FourierModel
from fe_engine.material import history_size
from fe_engine.model import Model

FIELDS = ("displacement", "border", "stress", "history", "traction", "pressure")


@dataclass
class Fields:
    """One copy of everything that evolves.

    displacement (n, 3) m in nodal axes, or the coefficients (n, 3, N + 1) of a Fourier series; border (nb,); stress
    (ne, np, 6) Pa at the points of each element; history (ne, np, nh), nh that of the law with most; traction (ns, 3)
    Pa, effective, in station frames; pressure (n + nf,) Pa of the water (empty when drained).

    Layout in a series, N harmonics, M azimuths (in bricks: a node has x y z, an element 8 points)::

        displacement[n] | U_0 .. U_N | V_0 .. V_N | W_0 .. W_N |        u_r, u_theta, u_z: see elements.fourier
        stress[e]       | point 0 at azimuth 0 .. M-1 | point 1 at .. | point 2 at .. | point 3 at .. |
        stress[e, p]    | rr | tt | zz | rt | tz | zr |                 (in bricks xx yy zz xy yz zx)
        history[e, p]   | variables of the element's law, in its order | 0 .. 0 |
        traction[s]     | -p | tau_1 | tau_2 |
        border          | u | w | rotation |                            of a rigid body
        pressure        | corners of the soil's elements | nodes of the film |      each with P_0 .. P_N
    """

    displacement: np.ndarray
    border: np.ndarray
    stress: np.ndarray
    history: np.ndarray
    traction: np.ndarray
    pressure: np.ndarray

    def copy_from(self, other: Fields) -> None:
        """Overwrite every array in place."""
        for name in FIELDS:
            getattr(self, name)[...] = getattr(other, name)


class State:
    """Committed fields and the trial fields that an increment works on."""

    def __init__(self, model: Model | FourierModel) -> None:
        self.committed = initial_fields(model)
        self.trial = initial_fields(model)

    def reset_trial(self) -> None:
        """Throw the trial away."""
        self.trial.copy_from(self.committed)

    def commit(self) -> None:
        """Accept the trial: the one place where history moves on."""
        self.committed.copy_from(self.trial)


def initial_fields(model: Model | FourierModel) -> Fields:
    """Return the fields of a model before anything has moved."""
    ns = 0 if model.stations is None else len(model.stations)
    traction = np.zeros((ns, 3))
    if ns:
        traction[:, 0] = -model.initial_pressure
    return Fields(
        displacement=np.zeros(model.displacement_shape),
        border=np.zeros(model.n_border),
        stress=np.array(model.initial_stress, dtype=float, copy=True),
        history=np.zeros((*model.initial_stress.shape[:2], history_size(model))),
        traction=traction,
        pressure=np.zeros(0) if model.water is None else np.array(model.water.initial, dtype=float, copy=True),
    )
