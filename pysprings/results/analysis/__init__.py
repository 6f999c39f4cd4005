# SPDX-License-Identifier: MIT
"""Quantities of a result that pictures and the report show."""
