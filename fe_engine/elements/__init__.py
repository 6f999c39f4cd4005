# SPDX-License-Identifier: MIT
"""Elements and interface geometry."""
