# SPDX-License-Identifier: MIT
"""Prints at the end how many hostile inputs were tried, accepted and refused."""

from typing import Any

from tests.fuzz import judge


def pytest_terminal_summary(terminalreporter: Any) -> None:
    if judge.TALLIES:
        terminalreporter.section("hostile input")
        judge.report(terminalreporter.write_line)
