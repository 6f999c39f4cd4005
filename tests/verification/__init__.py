# SPDX-License-Identifier: MIT
"""Verification: problems with an outside answer, shared by the tests and by the README's table."""
