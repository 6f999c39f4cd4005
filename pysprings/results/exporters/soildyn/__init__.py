# SPDX-License-Identifier: MIT
"""SoilDyn of OpenFAST: its input files, the spring file of the nonlinear foundation, and the library that reads it."""
