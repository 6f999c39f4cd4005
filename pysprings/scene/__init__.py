# SPDX-License-Identifier: MIT
"""TOML <-> frozen Scene; every problem with its place."""
