# SPDX-License-Identifier: MIT
"""Excel workbook of a spring set."""
