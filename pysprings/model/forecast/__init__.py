# SPDX-License-Identifier: MIT
"""What a run leaves out, needs and costs, before it starts."""
