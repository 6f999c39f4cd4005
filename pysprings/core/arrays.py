# SPDX-License-Identifier: MIT
"""Types of arrays."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Marks = NDArray[np.bool_]
Texts = NDArray[np.object_]
