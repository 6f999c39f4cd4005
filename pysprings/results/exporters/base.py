# SPDX-License-Identifier: MIT
"""What an exporter declares, what it reads, and the options of uniaxial springs (light: loads nothing)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.text import suggestion

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pysprings.macro.comparison import Comparison

VIRTUAL = "virtual"
RINGS, ZONE = "rings", "zone"
SETS = (VIRTUAL, "pisa", "full", "py")


def table_options(points: int) -> tuple[Option, ...]:
    """Return the options of an exporter of tables with a default number of points."""
    return (
        Option("springs", "virtual: a fan at virtual depths (default with a fan); pisa, full, py: at real depths",
               choices=("", *SETS), default=""),
        Option("slices", "zone: those of the tables, the last fifth of the skirt as one (default); rings: those of the "
               "mesh, as `predict` has them", choices=("", RINGS, ZONE), default=""),
        Option("points", "points of a table within its range", points),
        Option("planes", "even number of vertical planes with springs; 0: 8 of virtual springs, 2 of others", 0),
        Option("azimuth", "direction of the first plane, from x towards y; that of the load where there are two",
               unit="rad", example="30 deg"),
        V,
        RATE,
    )  # fmt: skip


Needs = Literal["springs", "full model"]


class Source:
    """Data of a run for exporters; each part is opened or computed with its first access, and kept.

    springs, result : Spring set (springs.nc) and full model (full_model.nc), or functions that return them; None
        without one.
    """

    def __init__(
        self,
        springs: xr.DataTree | Callable[[], xr.DataTree] | None = None,
        result: xr.DataTree | Callable[[], xr.DataTree] | None = None,
    ) -> None:
        self._springs, self._result = springs, result
        self.summary: dict[str, str] = {}  # of the run, by heading
        self.mesh_error = ""  # of the run, a sentence; blank: what the springs have of it

    @cached_property
    def springs(self) -> xr.DataTree:
        """Spring set."""
        return _opened(self._springs, "springs")

    @cached_property
    def tables(self) -> xr.DataTree:
        """The springs on the slices of all tables: the last fifth of the skirt is one (`pysprings.reslice`)."""
        from pysprings.springs.tip_zone import reslice

        return reslice(self.springs)

    @cached_property
    def result(self) -> xr.DataTree:
        """Full model."""
        return _opened(self._result, "full model")

    @cached_property
    def compared(self) -> Comparison:
        """The macro-model beside the full model that the springs come from."""
        from pysprings.macro.comparison import Comparison

        return Comparison.of(self.springs)

    @property
    def comparison(self) -> pd.DataFrame:
        """Errors of the macro-model by path and spring set (`pysprings.macro.comparison.compare`)."""
        return self.compared.frame

    @property
    def predictions(self) -> Mapping[str, Mapping[str, xr.Dataset]]:
        """Answers of the macro-model along each path, by path and spring set."""
        return self.compared.curves


def _opened(given: xr.DataTree | Callable[[], xr.DataTree] | None, what: str) -> xr.DataTree:
    if given is None:
        raise refused(None, f"this export needs the {what} of a run")
    return given() if callable(given) else given


@dataclass(frozen=True, slots=True)
class Option:
    """An option of an exporter (`--option NAME=VALUE`).

    name, help : Word of the option; what it does, for help texts.
    default : Value when the option is absent; its type is that of the option.
    unit : SI unit of a quantity, which users give with a unit ("4 MN"); blank for plain values.
    example : Quantity for messages.
    choices : Words that the option accepts; empty for any value.
    """

    name: str
    help: str
    default: bool | int | float | str | None = None
    unit: str = ""
    example: str = ""
    choices: tuple[str, ...] = ()


V = Option("V", "vertical load of the lateral springs, of springs at several", unit="N", example="2 MN")
RATE = Option("rate", "rate of loading, of springs at several", unit="m/s", example="0.5 mm/s")


@dataclass(frozen=True, slots=True)
class Target:
    """Where an exporter writes: its file, or a folder, which need not exist; `note` is called with each file."""

    path: Path
    note: Callable[[Path], object] = lambda _file: None

    def write(self, name: str, text: str) -> Path:
        """Write a text file into the folder, whole or not at all; return its path."""
        from pysprings.core.storage import write_text

        file = write_text(text, self.path / name)
        self.note(file)
        return file


@dataclass(frozen=True, slots=True)
class Exported:
    """Files to name to the user, and remarks: what the format cannot represent, and the error which that causes."""

    files: Sequence[Path]
    remarks: Sequence[str] = ()


Options = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Exporter:
    """A format for other programs and people.

    name : Word of `--to` and `--format`.
    description : What the files are, in one clause.
    write : (source, target, options) -> `Exported`. Files replace earlier ones only when they are whole.
    needs : Data that the exporter reads.
    suffixes : Endings of its files, with the dot.
    file : Name of the only file within a folder; blank for several files.
    text : (source, options) -> content of the file, for formats that can be printed.
    of_every_run : Each run writes the file.
    options : Options of this exporter.
    """

    name: str
    description: str
    write: Callable[[Source, Target, Options], Exported]
    needs: Needs = "springs"
    suffixes: tuple[str, ...] = ()
    file: str = ""
    text: Callable[[Source, Options], str] | None = None
    of_every_run: bool = False
    options: tuple[Option, ...] = field(default_factory=tuple)

    @property
    def is_spring_file(self) -> bool:
        """Whether the exporter writes the springs to one file (`pysprings springs --format`)."""
        return bool(self.file) and self.needs == "springs"


def rendered(template: str, **values: Any) -> str:
    """Return the text of a file from a template of this folder, `<< value >>` and `<% statement %>` in it."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    engine = Environment(
        loader=PackageLoader("pysprings.results.exporters"), undefined=StrictUndefined, keep_trailing_newline=True,
        trim_blocks=True, lstrip_blocks=True, variable_start_string="<<", variable_end_string=">>",
        block_start_string="<%", block_end_string="%>", comment_start_string="<#", comment_end_string="#>",
    )  # fmt: skip
    return engine.get_template(template).render(**values)


def write_text_file(text: Callable[[Source, Options], str]) -> Callable[[Source, Target, Options], Exported]:
    """Return the `write` of an exporter of one text file."""

    def write(source: Source, target: Target, options: Options) -> Exported:
        from pysprings.core.storage import write_text

        return Exported([write_text(text(source, options), target.path)])

    return write


def read_options(exporter: Exporter, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return every option of an exporter: given values (text is converted), else defaults.

    Raises UserInputError: unknown options, values of another type, unit or choice; all are listed.
    """
    known = {option.name: option for option in exporter.options}
    problems, values = [], {option.name: option.default for option in exporter.options}
    for name, value in given.items():
        if name not in known:
            there = f"its options: {', '.join(known)}" if known else "it has no options"
            problems.append(
                Problem(
                    key=f"--option {name}", message=f"no option of '{exporter.name}'{suggestion(name, known)}; {there}"
                )
            )
            continue
        try:
            values[name] = _converted(known[name], value)
        except ValueError as error:
            problems.append(Problem(key=f"--option {name}", message=str(error)))
    if problems:
        raise UserInputError(problems)
    return values


def _converted(option: Option, value: Any) -> Any:
    """Return the value of an option; ValueError with a message where it does not fit."""
    if option.unit and isinstance(value, str):
        from pysprings.core.units import read

        return read(value, option.unit, option.example)
    if option.choices and value not in option.choices:
        raise ValueError(f"'{value}' is not one of {', '.join(option.choices)}{suggestion(str(value), option.choices)}")
    if isinstance(value, str) and not isinstance(option.default, str | None):
        return _parsed(value, option.default)
    return value


def _parsed(text: str, default: bool | int | float) -> bool | int | float:
    if isinstance(default, bool):
        if text.lower() not in ("true", "false"):
            raise ValueError(f"'{text}' is not true or false")
        return text.lower() == "true"
    kind, words = (int, "an integer") if isinstance(default, int) else (float, "a number")
    try:
        return kind(text)
    except ValueError:
        raise ValueError(f"'{text}' is not {words}") from None
