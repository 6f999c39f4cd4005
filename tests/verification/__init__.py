# SPDX-License-Identifier: MIT
"""Verification: problems with an outside answer, shared by the tests and by the table of docs/evidence."""
