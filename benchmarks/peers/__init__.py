# SPDX-License-Identifier: MIT
"""The same caisson in pysprings and in programs of others (`make bench-peers`)."""
