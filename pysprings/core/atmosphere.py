# SPDX-License-Identifier: MIT
"""Pressures below which water cavitates."""

from __future__ import annotations

ATMOSPHERE = 101_325.0  # Pa, standard atmosphere (ISO 2533)
VAPOUR = 2_339.0  # Pa, saturated vapour of water at 20 deg C (IAPWS)
