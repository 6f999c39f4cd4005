# SPDX-License-Identifier: MIT
"""Numbers as people read them."""

import numpy as np
import pytest

from pysprings.core.errors import Problem, UserInputError, reason_of
from pysprings.core.text import number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1848, "1,848"), (np.int64(12345), "12,345"), (0.28149, "0.2815"), (1.5e6, "1,500,000"), (2e20, "2e+20"),
        (-0.0, "0"), (True, "yes"), ("x", "x"), (None, "-"), (float("nan"), "-"), ((1, 2.5), "1, 2.5"),
    ],
)  # fmt: skip
def test_numbers(value: object, text: str) -> None:
    assert number(value) == text


def test_a_reason_is_the_problems_without_the_words_of_the_command_line() -> None:
    """It stands within a sentence of the summary."""
    error = UserInputError([Problem(key="mesh", message="no such mesh"), Problem(key="a", message="b")])
    assert reason_of(error) == "mesh: no such mesh; a: b"
    assert reason_of(ValueError("why")) == "ValueError: why"
