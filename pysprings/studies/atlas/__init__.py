# SPDX-License-Identifier: MIT
"""Atlases: springs of any caisson of a family of ground from the full models of a study, with their predicted error."""
