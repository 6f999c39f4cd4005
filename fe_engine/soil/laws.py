# SPDX-License-Identifier: MIT
"""Soil laws of the engine, one line each; see `register` for laws from outside."""

from __future__ import annotations

from fe_engine.register import Register
from fe_engine.soil import (
    anisotropic,
    elastic,
    following,
    iwan_clay,
    iwan_sand,
    plasol,
    tresca,
    van_eekelen,
    von_mises,
)
from fe_engine.soil.law import SoilLaw

SOIL_LAWS: Register[SoilLaw] = Register(
    "soil law",
    elastic.LAW,
    plasol.LAW,
    van_eekelen.LAW,
    von_mises.LAW,
    tresca.LAW,
    following.LAW,
    iwan_clay.LAW,
    iwan_sand.LAW,
    anisotropic.LAW,
)
