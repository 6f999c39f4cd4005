# SPDX-License-Identifier: MIT
"""A command whose options of one value are refused when they are given twice: the parser would take the last one."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperCommand

from pysprings.cli.support import to_stderr
from pysprings.core.errors import refused


class Once(TyperCommand):
    """A command that refuses an option of one value that is given twice."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments of the command line. Exits with the code of user input where an option stands twice."""
        given = [text.partition("=")[0] for text in (args[: args.index("--")] if "--" in args else args)]
        for param in self.params:
            names = [name for name in param.opts if name.startswith("-")]
            single = not getattr(param, "multiple", False) and not getattr(param, "is_flag", False)
            if single and sum(given.count(name) for name in names) > 1:
                error = refused(names[0], "is given twice: one value is needed")
                to_stderr(str(error))
                raise typer.Exit(error.exit_code)
        return super().parse_args(ctx, args)
