# SPDX-License-Identifier: MIT
"""Catalogue of stiff and extreme cases."""
