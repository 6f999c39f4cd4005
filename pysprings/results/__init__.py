# SPDX-License-Identifier: MIT
"""The files of a run: folder, tables, pictures, report, exports."""

import lazy_loader

__getattr__, __dir__, _ = lazy_loader.attach(__name__, submodules=["exporters", "plots"])
