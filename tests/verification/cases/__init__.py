# SPDX-License-Identifier: MIT
"""One problem a file: build it, compute it, return rows that set our figure beside the reference."""
