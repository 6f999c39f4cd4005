# SPDX-License-Identifier: MIT
"""Studies of many runs: accuracy, stability, the paper."""
