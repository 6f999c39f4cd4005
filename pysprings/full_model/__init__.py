# SPDX-License-Identifier: MIT
"""The full model along its load paths: rows, checkpoints, record, error estimate."""
