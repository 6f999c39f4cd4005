# SPDX-License-Identifier: MIT
"""Finite elements for soil-structure interaction, without caissons or files."""

from fe_engine.settings import refuse_bad_settings

refuse_bad_settings()  # before Numba loads, which ends in a traceback of its own
