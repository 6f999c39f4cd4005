# SPDX-License-Identifier: MIT
"""`pysprings accuracy`: runs of a scene by setting, their errors and costs, table and picture."""
