# SPDX-License-Identifier: MIT
"""Laboratory tests of a layer's law beside data: run, table, picture, fit of keys."""
