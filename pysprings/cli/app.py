# SPDX-License-Identifier: MIT
"""The command `pysprings`: data on stdout, talk on stderr; commands load what they need."""

from __future__ import annotations

import sys
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pysprings.cli.options import named
from pysprings.cli.support import (
    DEBUG,
    guarded,
    in_discretisation,
    interruptible,
    print_json,
    quantities,
    record_stamp,
    refuse,
    refuse_no_folder,
    refuse_other_run,
    refuse_unfinished,
    result_folder,
    say,
    springs_of,
    springs_or_table,
    with_target,
)
from pysprings.core.errors import ResourceError, RunIncomplete
from pysprings.core.files.layout import is_unfinished
from pysprings.core.files.written import note, own_folder
from pysprings.core.jit import choose_for_command
from pysprings.core.streams import open_missing_streams
from pysprings.core.version import __version__
from pysprings.results import exporters
from pysprings.results.exporters import EXPORTERS
from pysprings.scene.template_names import template_names

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

EPILOG = (
    "Exit codes: 0 ok; 1 a bug; 2 user input; 3 not converged (partial results saved); 4 resources; 130 interrupted."
)

app = typer.Typer(
    help="p-y springs of suction caissons from a 3D finite-element model, and the prediction made with them.",
    epilog=EPILOG,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class Preset(StrEnum):
    """Mesh presets, as in the scene's [mesh]."""

    coarse = "coarse"
    medium = "medium"
    paper = "paper"
    fine = "fine"


class Discretisation(StrEnum):
    """Discretisations, as in the scene's [mesh]."""

    hex8 = "hex8"
    fourier = "fourier"


class Target(StrEnum):
    """Errors that a run may aim at: see `pysprings.full_model.accuracy.presets`."""

    five = "5%"
    two = "2%"
    one = "1%"


class SpringSet(StrEnum):
    """What a prediction uses: see `pysprings.macro.predict`."""

    fan = "fan"
    full = "full"
    pisa = "pisa"
    py = "py"


SETS = (
    "springs to use: fan (all reactions, between calibration paths of several directions), full (all reactions of one "
    "path), pisa (p-y from a pure translation, moments from a pure rotation), py (p-y alone)"
)
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="scene file (TOML)")]
Result = Annotated[Path, typer.Argument(metavar="RESULT", help="folder of a run, or its springs.nc")]
Mesh = Annotated[Preset | None, typer.Option("--mesh", help="mesh preset instead of the scene's")]
Series = Annotated[
    Discretisation | None, typer.Option("--discretisation", help="bricks or Fourier series instead of the scene's")
]
Json = Annotated[bool, typer.Option("--json", help="one JSON document on stdout")]


def _print_version(wanted: bool) -> None:
    if wanted:
        from pysprings.core.licences import installed, text

        print(f"pysprings {__version__}")
        print(text(installed()))
        raise typer.Exit


@app.callback()
def _options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and the licences, and exit.", is_eager=True, callback=_print_version
        ),
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    DEBUG["on"] = debug


@app.command()
@guarded
def init(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="scene file to write")] = Path("caisson.toml"),
    template: Annotated[
        str, typer.Option("--template", metavar="NAME", help=f"scene to start from: {', '.join(template_names())}")
    ] = "paper-drained",
    force: Annotated[bool, typer.Option("--force", help="replace existing files")] = False,
) -> None:
    """Write a commented scene, and the JSON schema that helps editors with it."""
    from pysprings.scene.template import write_scene

    written = write_scene(file, template, force)
    for path in written:
        print(path)
    kept = "" if len(written) > 1 else "the schema that was there is kept; --force renews it\n"
    say(f"{kept}next: pysprings check {file}")


@app.command()
@guarded
def check(scene: SceneFile, mesh: Mesh = None, discretisation: Series = None, as_json: Json = False) -> None:
    """Validate a scene; say what it leaves out, how large the model is and what it costs. Solves nothing."""
    from pysprings.cli.reports import describe_json, print_description
    from pysprings.scene.load import load_scene

    loaded = in_discretisation(load_scene(scene), discretisation and discretisation.value)
    loaded = loaded.replace(mesh={"preset": mesh.value}) if mesh else loaded
    from pysprings.model.forecast.estimate import describe

    about = describe(loaded)
    if as_json:
        print_json(describe_json(scene, loaded, about))
    else:
        print_description(scene, loaded, about)


@app.command()
@guarded
def run(
    scene: SceneFile,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="result folder \\[default: out/SCENE]")
    ] = None,
    mesh: Mesh = None,
    discretisation: Series = None,
    target: Annotated[
        Target | None, typer.Option("--target-error", help="the cheapest setting with this error, instead of a mesh")
    ] = None,
    estimate: Annotated[
        bool, typer.Option("--estimate-error", help="also run a coarser mesh, and estimate the error from both")
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="go on with the interrupted run in the folder")] = False,
    force: Annotated[bool, typer.Option("--force", help="replace results that the folder holds")] = False,
    as_json: Json = False,
) -> None:
    """Full model, springs, prediction with the springs, tables and pictures."""
    from pysprings.cli.reports import print_results, results_json
    from pysprings.scene.load import load_scene

    loaded = in_discretisation(load_scene(scene), discretisation and discretisation.value)
    extra = {"estimate_error": True} if estimate else {}
    if target is not None:
        loaded, extra = with_target(loaded, target.value, mesh is not None)
    folder = out or Path("out") / scene.stem
    with result_folder(folder, force, resume):
        if resume and not is_unfinished(folder):
            stopped = _as_it_ended(folder, loaded.replace(mesh={"preset": mesh.value}) if mesh else loaded)
        else:
            stopped = _run(loaded, folder, mesh.value if mesh else None, resume, extra)
    if as_json:
        print_json(results_json(folder))
    else:
        print_results(folder)
    if isinstance(stopped, KeyboardInterrupt) and is_unfinished(folder):
        option = f" --mesh {mesh.value}" if mesh else f" --target-error {target.value}" if target else ""
        option += f" --discretisation {discretisation.value}" if discretisation else ""
        option += " --estimate-error" if estimate else ""
        say(f"go on with: pysprings run {scene} --out {folder}{option} --resume")
    if stopped is not None:
        raise stopped


Stopped = RunIncomplete | ResourceError | KeyboardInterrupt | None


def _run(scene: Scene, folder: Path, mesh: str | None, resume: bool, extra: dict[str, Any]) -> Stopped:
    """Run a scene; return what ended it early when results were written nevertheless."""
    from pysprings.core.progress import reporter
    from pysprings.results.folder import run_to_folder

    before = record_stamp(folder)
    try:
        with interruptible(), reporter(sys.stderr) as progress:
            run_to_folder(scene, folder, mesh=mesh, progress=progress, resume=resume, **extra)
    except (RunIncomplete, ResourceError, KeyboardInterrupt) as error:
        if record_stamp(folder) in (None, before):
            raise
        return error
    return None


def _as_it_ended(folder: Path, scene: Scene) -> Stopped:
    """Say that the run in a folder has ended, and how; change nothing."""
    from pysprings.cli.reports import read_record

    record = read_record(folder)
    refuse_other_run(folder, record, scene.sha256)
    say(f"the run in {folder} has ended ({record['status']}): nothing is left to do")
    return None if record["status"] == "complete" else RunIncomplete("; ".join(record["failures"]), folder)


SPRING_FILES = [each for each in EXPORTERS.built_in if each.is_spring_file]


@app.command()
@guarded
def springs(
    result: Result,
    form: Annotated[
        str | None, named("--format", EXPORTERS, "format \\[default: from --out, else csv]", SPRING_FILES)
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="file to write \\[default: stdout]")] = None,
    wide: Annotated[bool, typer.Option("--wide", help="csv: rows are steps, a pair of columns y, p a depth")] = False,
    as_json: Json = False,
) -> None:
    """Write p-y and companion tables (csv: the long p-y table; the other formats hold everything)."""
    wanted = "json" if as_json else _format(form, out)
    if wide and wanted not in ("csv", "wide"):
        refuse("--wide", f"is a form of csv, not of {wanted}")
    wanted = "wide" if wide else wanted
    tree = springs_of(result)
    if out is None:
        print(exporters.text(tree, wanted), end="")
    else:
        for path in exporters.export(tree, wanted, out).files:
            print(path)


def _format(form: str | None, out: Path | None) -> str:
    """Return the format that the option names, that the ending of the file selects, or csv."""
    known = [each for each in EXPORTERS if each.is_spring_file]
    names = "|".join(each.name for each in known)
    ending = out.suffix.lower() if out else ".csv"
    exporter = EXPORTERS.find(form, "--format") if form else next((e for e in known if ending in e.suffixes), None)
    if exporter is None:
        refuse("--out", f"no format is known for '{ending.lstrip('.')}'; give --format {names}", out)
    if exporter not in known:
        refuse("--format", f"'{exporter.name}' is no spring file but an export: pysprings export --to {exporter.name}")
    if out is None and exporter.text is None:
        refuse("--out", f"the format {exporter.name} needs a file")
    if out is not None and out.is_dir():
        refuse("--out", "is a folder, not a file", out)
    return exporter.name


@app.command()
@guarded
def export(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="folder of a run, springs.nc, or full_model.nc")],
    to: Annotated[str, named("--to", EXPORTERS, "format or program")] = "paraview",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="folder for the files \\[default: NAME/ beside RESULT]")
    ] = None,
    option: Annotated[
        list[str] | None, typer.Option("--option", metavar="NAME=VALUE", help="option of the export; may be repeated")
    ] = None,
) -> None:
    """Write files for other programs. ParaView files need a run with \\[output] paraview = true."""
    exporter = EXPORTERS.find(to, "--to")
    options = _export_options(option or [])
    exporters.read_options(exporter, options)
    if out is not None:
        refuse_no_folder(out)
    folder = result if result.is_dir() else result.parent
    source = _export_source(result, exporter)
    place = own_folder(folder, exporter.name) if out is None else out
    target = exporters.Target(place / exporter.file, partial(note, folder) if out is None else _keep_no_list)
    done = exporters.export(source, exporter.name, target, **options)
    for path in done.files:
        print(path)
    for remark in done.remarks:
        say(f"note: {remark}")


def _keep_no_list(_file: Path) -> None:
    """Accept a file outside the result folder, which the next run into the folder does not remove."""


def _export_options(given: list[str]) -> dict[str, str]:
    """Return {name: value} of options NAME=VALUE."""
    pairs = [text.partition("=") for text in given]
    for name, sign, _ in pairs:
        if not sign or not name:
            refuse("--option", f"'{name}' is not NAME=VALUE")
    return {name.strip(): value.strip() for name, _, value in pairs}


def _export_source(result: Path, exporter: exporters.Exporter) -> exporters.Source:
    """Return the springs, or the full model of a folder or file; refuse a run that has not ended."""
    from pysprings.core.files.storage import read_tree

    if exporter.needs == "springs":
        return exporters.Source(springs=springs_of(result))
    refuse_unfinished(result)
    return exporters.Source(result=read_tree(result / "full_model.nc" if result.is_dir() else result))


@app.command()
@guarded
def predict(
    result: Annotated[Path, typer.Argument(metavar="SPRINGS", help="springs.nc, the folder of a run, or a p-y table")],
    load: Annotated[str | None, typer.Option("--H", metavar="FORCE", help='lateral load, e.g. "2 MN"')] = None,
    arm: Annotated[
        str | None, typer.Option("--arm", metavar="LENGTH", help='its height above mudline, e.g. "8 m"')
    ] = None,
    moment: Annotated[
        str | None,
        typer.Option("--M", metavar="MOMENT", help='moment about the lid centre, -H*arm, e.g. "-3 MN m"'),
    ] = None,
    vertical: Annotated[str | None, typer.Option("--V", metavar="FORCE", help="vertical load, positive down")] = None,
    u_max: Annotated[
        str | None,
        typer.Option("--u-max", metavar="LENGTH", help='a whole curve up to this displacement, e.g. "5 mm"'),
    ] = None,
    points: Annotated[int, typer.Option("--points", help="points of the curve", min=2, max=10_000)] = 50,
    u: Annotated[str | None, typer.Option("--u", metavar="LENGTH", help="the load at this displacement")] = None,
    rotation: Annotated[
        str | None,
        typer.Option("--rotation", metavar="ANGLE", help="the load at this rotation; with --u: both imposed"),
    ] = None,
    sequence: Annotated[
        Path | None,
        typer.Option("--sequence", metavar="FILE", help="CSV with a load (H_N, M_Nm, V_N) or motion (u_m ...) a line"),
    ] = None,
    spring_set: Annotated[
        SpringSet | None, typer.Option("--springs", help=SETS + " \\[default: fan where there is one, else full]")
    ] = None,
    path: Annotated[
        str | None, typer.Option("--path", metavar="NAME", help="load path whose springs serve (full, py)")
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="refuse an answer that the springs support only in part")
    ] = False,
    rate: Annotated[
        str | None,
        typer.Option("--rate", metavar="VELOCITY", help="of rho = |(u, rotation*L)|, for springs from several rates"),
    ] = None,
    stiffness: Annotated[
        bool,
        typer.Option(
            "--stiffness", help="also the stiffness of the springs at each state, and the full model's initial one, 6x6"
        ),
    ] = False,
    skirt_length: Annotated[
        str | None, typer.Option("--skirt-length", metavar="LENGTH", help="of a table without depth_bottom_m")
    ] = None,
    as_json: Json = False,
) -> None:
    """Predict displacement and rotation of the rigid caisson on its springs, or a load-displacement curve.

    SPRINGS may be a table of p-y curves (CSV, Excel) with columns depth_m, y_m, p_N_per_m, and companions if any.
    """
    from pysprings.cli import predict as asked
    from pysprings.cli.reports import prediction_json, print_prediction, remarks_of

    given = quantities(
        {
            "--H": (load, "N", "2 MN"),
            "--arm": (arm, "m", "8 m"),
            "--M": (moment, "N m", "-3 MN m"),
            "--V": (vertical, "N", "4 MN"),
            "--u-max": (u_max, "m", "5 mm"),
            "--u": (u, "m", "3 mm"),
            "--rotation": (rotation, "rad", "0.5 mrad"),
            "--skirt-length": (skirt_length, "m", "4 m"),
            "--rate": (rate, "m/s", "0.1 mm/s"),
        }
    )
    asked.refuse_contradictions(given, sequence)
    kind = spring_set.value if spring_set else None
    springs = asked.at_rate(springs_or_table(result, given["--skirt-length"], strict), given["--rate"])
    states = asked.answer(springs, given, sequence, kind, path, points, strict)
    six = asked.initial_six(springs) if stiffness else None
    if as_json:
        print_json(prediction_json(states) | (asked.stiffness_json(states, six) if stiffness else {}))
        return
    print_prediction(states)
    if stiffness:
        asked.print_stiffness(states, six)
    if remarks := remarks_of(states):
        say(remarks)


@app.command()
@guarded
def compare(
    result: Result,
    spring_set: Annotated[
        SpringSet | None, typer.Option("--springs", help="only these springs \\[default: all]")
    ] = None,
    slices: Annotated[bool, typer.Option("--slices", help="error and cost by number of depth slices instead")] = False,
    as_json: Json = False,
) -> None:
    """Set the prediction with the springs beside the full model, by path: eta and errors."""
    tree = springs_of(result)
    kind = spring_set.value if spring_set else None
    if slices:
        from pysprings.macro import slices as by_slices

        table = by_slices.slice_convergence(tree, springs_kind=kind)
        if as_json:
            print_json({"rows": table.to_dict(orient="records")})
        else:
            print(by_slices.to_text(table), end="")
        return
    from pysprings.macro.comparison import compare as compare_models
    from pysprings.macro.comparison_text import to_dict, to_text

    frame = compare_models(tree, kind)
    if as_json:
        print_json(to_dict(frame))
    else:
        print(to_text(frame), end="")


@app.command()
@guarded
def accuracy(
    scene: SceneFile,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="result folder \\[default: out/accuracy-SCENE]")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="small meshes and few settings")] = False,
    mesh: Annotated[
        list[str] | None,
        typer.Option("--mesh", metavar="PRESET", help="a mesh of the series, or medium:0.7; repeated, three at best"),
    ] = None,
    presets: Annotated[
        Path | None, typer.Option("--write-presets", metavar="FILE", help="also write what --target-error chooses from")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="have every run made again")] = False,
    as_json: Json = False,
) -> None:
    """Error against run time over meshes, steps, tolerances and linear solvers: table, picture, Pareto front.

    Runs that have ended in DIR are not run again; interrupted ones go on.
    """
    from pysprings.cli import accuracy as cli_accuracy
    from pysprings.scene.load import load_scene

    folder = out or Path("out") / f"accuracy-{scene.stem}"
    cli_accuracy.run(load_scene(scene), folder, mesh or [], quick, force, presets, as_json)


@app.command()
@guarded
def stability(
    case: Annotated[
        list[str] | None, typer.Option("--case", metavar="NAME", help="a case or a group of cases; may be repeated")
    ] = None,
    mesh: Mesh = None,
    refinement: Annotated[float, typer.Option("--refinement", help="factor on the preset's numbers of cells")] = 1.0,
    reach: Annotated[
        str, typer.Option("--reach", metavar="LENGTH", help="how far the cases are pulled that say nothing else")
    ] = "20 mm",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="folder for the table and its picture")
    ] = None,
    as_json: Json = False,
) -> None:
    """Run the stiff and extreme cases: how each ends, steps, cut-backs, residuals, balances.

    Ends with exit code 3 where a case stops without a named reason.
    """
    from pysprings.cli import stability as cli_stability

    far = quantities({"--reach": (reach, "m", "20 mm")})["--reach"]
    assert far is not None
    unexplained = cli_stability.run(case or [], mesh.value if mesh else "coarse", refinement, far, out, as_json)
    if unexplained:
        raise RunIncomplete(f"{unexplained} cases ended without a named reason")


@app.command()
@guarded
def paper(
    mesh: Annotated[Preset, typer.Option("--mesh", help="mesh preset of the runs")] = Preset.medium,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="result folder \\[default: out/paper-MESH]")
    ] = None,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="also vary what the paper leaves open, one at a time")
    ] = False,
    sensitivity_mesh: Annotated[Preset, typer.Option("--sensitivity-mesh", help="their mesh preset")] = Preset.coarse,
    force: Annotated[bool, typer.Option("--force", help="forget what has run in DIR, and begin anew")] = False,
    as_json: Json = False,
) -> None:
    """Reproduce Cerfontaine, Charlier & Collin (2018): its runs, the paper's figures, its claims beside ours.

    Runs that have ended in DIR are not run again; interrupted ones go on.
    """
    from pysprings.cli import paper as cli_paper

    variants_on = sensitivity_mesh.value if sensitivity else None
    cli_paper.run(out or Path("out") / f"paper-{mesh.value}", mesh.value, variants_on, force, as_json)


def main() -> None:
    """Run the command line."""
    open_missing_streams()
    choose_for_command(sys.argv[1:])
    app(prog_name="pysprings")


if __name__ == "__main__":
    main()
