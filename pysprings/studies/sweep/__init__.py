# SPDX-License-Identifier: MIT
"""Studies of many scenes: a base scene, axes of its values, a folder a case, one dataset of all."""
