# SPDX-License-Identifier: MIT
"""Commands: options in, streams and exit codes out."""
