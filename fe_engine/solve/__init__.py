# SPDX-License-Identifier: MIT
"""Newton iterations, globalisation, load and time steps."""
