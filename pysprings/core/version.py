# SPDX-License-Identifier: MIT
"""The version, in the one place that the build, the records and the command read."""

__version__ = "0.1.0"
