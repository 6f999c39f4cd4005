# SPDX-License-Identifier: MIT
"""What every room uses: errors, units, names of variables, text, files."""

import lazy_loader

__getattr__, __dir__, _ = lazy_loader.attach(__name__, submodules=["errors"])
