# SPDX-License-Identifier: MIT
"""pysprings: p-y springs of suction caissons from a 3D finite-element model, and predictions made with them.

The public names stand in the stub beside this file; each loads on first use, so that `import pysprings` and the
command's `--help` stay fast. All other modules are private.
"""

import lazy_loader

from pysprings.core.version import __version__ as __version__

__getattr__, _names, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __dir__() -> list[str]:
    return [*_names(), "__version__"]
