# SPDX-License-Identifier: MIT
"""Load cases answered by the macro-model: motion, tilt, stiffness, utilisation, and what is not known, case by case."""
