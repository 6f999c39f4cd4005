# SPDX-License-Identifier: MIT
"""Atomic files, checksums, folder lock, names of result files."""
