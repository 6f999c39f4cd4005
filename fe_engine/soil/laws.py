# SPDX-License-Identifier: MIT
"""Soil laws of the engine, one line each; see `register` for laws from outside."""

from __future__ import annotations

from fe_engine.register import Register
from fe_engine.soil import anisotropic, elastic, following, iwan_anisotropic, iwan_clay, iwan_sand, tresca, von_mises
from fe_engine.soil.frictional import SURFACES
from fe_engine.soil.law import SoilLaw

SOIL_LAWS: Register[SoilLaw] = Register(
    "soil law",
    elastic.LAW,
    *SURFACES,
    von_mises.LAW,
    tresca.LAW,
    following.LAW,
    iwan_clay.LAW,
    iwan_sand.LAW,
    anisotropic.LAW,
    iwan_anisotropic.LAW,
)
