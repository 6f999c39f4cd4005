# SPDX-License-Identifier: MIT
"""Scene -> engine model and stages."""
