# SPDX-License-Identifier: MIT
"""Interface laws: one law a file, traction from jump."""
