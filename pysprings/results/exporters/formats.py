# SPDX-License-Identifier: MIT
"""The formats of this package: words, files, options of each exporter (light: what writes loads when called)."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from pysprings.results.exporters.base import RATE, Exporter, Option, V, table_options, write_text_file


def _loaded(module: str, name: str = "write") -> Callable[..., Any]:
    """Return a function of a module of this folder that loads with its first call."""

    def call(*arguments: Any) -> Any:
        return getattr(import_module(f"pysprings.results.exporters.{module}"), name)(*arguments)

    return call


POINTS = 80  # of a curve for beam programs


def _of_text(name: str, description: str, function: str, file: str, of_every_run: bool = True) -> Exporter:
    """Return an exporter of one file, whose text a function of `csv` returns."""
    text, suffix = _loaded("csv", function), file[file.rindex(".") :]
    return Exporter(
        name, description, write_text_file(text), suffixes=(suffix,), file=file, text=text, of_every_run=of_every_run
    )


CSV = _of_text("csv", "p-y tables", "py_text", "py.csv")
WIDE = _of_text("wide", "the same, a pair of columns y, p by depth, for spreadsheets", "wide_text", "py_wide.csv")
JSON = _of_text("json", "all springs as one JSON document", "springs_text", "springs.json", False)
XLSX = Exporter(
    "xlsx", "springs as a spreadsheet", _loaded("xlsx"), suffixes=(".xlsx",), file="springs.xlsx", of_every_run=True
)
NETCDF = Exporter(
    name="nc",
    description="springs (NetCDF), for `pysprings springs, predict, compare`",
    write=_loaded("csv", "write_netcdf"),
    suffixes=(".nc",),
    file="springs.nc",
    of_every_run=True,
)
BEAM = Exporter(
    name="beam",
    description="one set of curves for beam programs: p(y), m(rotation), tip and lid (CSV, xlsx)",
    write=_loaded("beam"),
    text=_loaded("beam", "text"),
    options=(
        Option("depths", 'depths of the curves, such as "0.5, 1.5, 2.5 m"; those of all tables without', default=""),
        Option(
            "pile",
            "yes: p(y) of a rigid pile twice as long as the skirt, and m(rotation) at its head; they follow the fan",
            "no",
            choices=("no", "yes"),
        ),
        Option("points", "points of a curve", POINTS),
        V,
        RATE,
    ),
)
PARAVIEW = Exporter(
    name="paraview",
    description="ParaView files of a run with [output] paraview = true: displacements, stresses, pressures by step",
    write=_loaded("vtu"),
    needs="full model",
    suffixes=(".pvd", ".vtu"),
)
MATRIX = (
    Option("at", "where the matrix is that of the springs: a load (H, M, V, arm), \"H=2 MN, arm=60 m\", or a share of "
           "a path, \"50 % of pull_1_D\"; at rest without", default=""),
    Option("matrix", "the secant from rest, or the tangent there", "secant", choices=("secant", "tangent")),
)  # fmt: skip
OPENFAST = Exporter(
    name="openfast",
    description="OpenFAST foundation: matrices for SubDyn and SoilDyn, nonlinear springs for the SoilDyn library",
    write=_loaded("openfast"),
    suffixes=(".dat", ".txt"),
    options=(
        Option("x", "place of the lid centre in the frame of OpenFAST", unit="m", example="0 m"),
        Option("y", "the same", unit="m", example="0 m"),
        Option("z", "height of the mudline above still water, negative", unit="m", example="-30 m"),
        Option("springs", "of the nonlinear foundation: the fan, or the elements that remember reversals", "fan",
               choices=("fan", "memory")),
        V,
        RATE,
        Option("reaction_at_rest", "vertical reaction of the nonlinear foundation at displacement 0: the vertical load "
               "at rest (the structure has its weight), or none", "load", choices=("load", "none")),
        Option("beyond", "beyond the calibrated range the library extrapolates with a warning, or stops OpenFAST",
               "warn", choices=("warn", "stop")),
        *MATRIX,
    ),
)  # fmt: skip
SUBDYN = Exporter(
    name="subdyn",
    description="stiffness for SubDyn, at rest or at a load: SSI file, spring element",
    write=_loaded("subdyn"),
    suffixes=(".dat",),
    options=(RATE, *MATRIX),
)
OPENSEES = Exporter(
    name="opensees",
    description="springs for OpenSees: openseespy and Tcl, ElasticMultiLinear on stiff beams",
    write=_loaded("opensees"),
    suffixes=(".py", ".tcl"),
    options=(
        *table_options(401),
        Option("material", "elastic: ElasticMultiLinear; masing: MultiLinear, hysteresis by Masing's rule", "elastic",
               choices=("elastic", "masing")),
        Option("first", "first tag of nodes, materials and elements", 900001),
    ),
)  # fmt: skip
CALCULIX = Exporter(
    name="calculix",
    description="springs for CalculiX: *SPRING, NONLINEAR as include file in the syntax of Abaqus, and an example",
    write=_loaded("calculix"),
    suffixes=(".inp",),
    options=(
        *table_options(401),
        Option("lid", "node of the lid", 1),
        Option("rotations", "node of the rotations of the lid", 2),
        Option("first", "first number of nodes and elements", 900001),
    ),
)
SACS = Exporter(
    name="sacs",
    description="P-Y, M-T, T-Z and Q-Z cards for SACS PSI, metric; not run in SACS",
    write=_loaded("sacs"),
    suffixes=(".inp",),
    options=(
        Option("points", "points of a side of a curve; a curve has at most 30", 20),
        *(option for option in table_options(20) if option.name in ("springs", "V", "rate")),
        Option("soil", "name of the soil, four letters", "SOL1"),
        Option("head", "height of the pile head above mudline", unit="m", example="2 m"),
    ),
)

FORMATS = (CSV, WIDE, XLSX, NETCDF, JSON, BEAM, PARAVIEW, OPENFAST, SUBDYN, OPENSEES, CALCULIX, SACS)
