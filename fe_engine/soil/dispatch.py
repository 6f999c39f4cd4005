# SPDX-License-Identifier: MIT
"""Update of a point by the code of its law: `update(code, p, strain, old, new, tangent, with_tangent)`."""

from __future__ import annotations

from fe_engine.soil.laws import SOIL_LAWS

update_soil = SOIL_LAWS.chain("update", "p, strain, old, new, tangent, with_tangent", __name__)
