# SPDX-License-Identifier: MIT
"""Formulas of springs in dimensionless form, fitted over a study. Forms are modules, each with an entry in `FORMS`."""

from __future__ import annotations

from pysprings.core.registry import Registry
from pysprings.studies.atlas.formulas import conic, ground_conic, hyperbolic
from pysprings.studies.atlas.formulas.base import Form

FORMS: Registry[Form] = Registry(
    "form of springs", (conic.FORM, ground_conic.FORM, hyperbolic.FORM), group="pysprings.spring_forms"
)

__all__ = ["FORMS", "Form"]
