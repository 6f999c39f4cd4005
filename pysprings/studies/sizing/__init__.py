# SPDX-License-Identifier: MIT
"""Sizing: the least steel that meets load cases, on an atlas first, then confirmed by full models."""
