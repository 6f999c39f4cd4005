# SPDX-License-Identifier: MIT
"""Balances of energy and water."""
