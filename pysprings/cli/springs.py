# SPDX-License-Identifier: MIT
"""`pysprings springs`, `export` and `soildyn`: springs and results as files for people and programs."""

from functools import partial
from pathlib import Path
from typing import Annotated

from pysprings.cli.folders import all_folders_of, refuse_no_folder, refuse_read
from pysprings.cli.inputs import refuse_unfinished, springs_of
from pysprings.cli.options import Json, Rate, Result, argument, named, option
from pysprings.cli.support import refuse, to_stderr
from pysprings.core.text import plain_table
from pysprings.core.words import Use
from pysprings.core.written import note, own_folder
from pysprings.results import exporters
from pysprings.results.exporters import EXPORTERS

SPRING_FILES = [each for each in EXPORTERS if each.is_spring_file]


def springs(
    result: Result,
    form: Annotated[
        str | None, named("--format", EXPORTERS, "format [default: from --out, else csv]", SPRING_FILES)
    ] = None,
    out: Annotated[Path | None, option("--out", "file to write [default: stdout]", "FILE")] = None,
    wide: Annotated[bool, option("--wide", "csv: rows are steps, a pair of columns y, p a depth")] = False,
    use: Annotated[
        Use | None, option("--for", "one set of curves for a beam program, with its error (csv, xlsx)")
    ] = None,
    depths: Annotated[str | None, option("--depths", 'beam: depths, such as "0.5, 1.5, 2.5 m"', "LIST")] = None,
    pile: Annotated[
        bool, option("--pile", "beam: p-y of a rigid pile, twice as long as the skirt, that stands for the foundation")
    ] = False,
    rate: Rate = None,
    as_json: Json = False,
) -> None:
    """Write p-y and companion tables. CSV is the long p-y table; the other formats hold everything."""
    chosen, options = "json" if as_json else _format(form, out), dict[str, str]()
    refuse_read("--out", out, None if chosen == "nc" else result)
    if wide and chosen not in ("csv", "wide"):
        refuse("--wide", f"is a form of csv, not of {chosen}")
    given = {"depths": depths, "pile": "yes" if pile else None, "rate": None if rate is None else f"{rate!r} m/s"}
    asked = {name: value for name, value in given.items() if value is not None}
    if use is None and asked:
        refuse(f"--{next(iter(asked))}", "is an option of --for beam")
    if use is not None:
        if wide or chosen not in ("csv", "xlsx"):
            refuse("--for", f"writes csv or xlsx, not {'--wide' if wide else chosen}")
        if out is not None and out.suffix.lower() != f".{chosen}":
            refuse("--out", f"the name of the file must end with .{chosen}", out)
        chosen, options = use, asked
    from pysprings.springs.path import space_paths_of

    chosen = "wide" if wide else chosen
    source = _export_source(result, EXPORTERS.find(chosen, "--for"))
    if chosen in ("csv", "wide") and (lost := space_paths_of(source.springs)):
        to_stderr(f"note: {', '.join(lost)} leave the plane of one load and are not in this table: --json has them")
    if out is None:
        print(exporters.text(source, chosen, **options), end="")
    else:
        for path in exporters.export(source, chosen, out, **options).files:
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


def export(
    result: Annotated[Path, argument("RESULT", "folder of a run, springs.nc, or full_model.nc")],
    to: Annotated[str | None, named("--to", EXPORTERS, "format or program")] = None,
    out: Annotated[Path | None, option("--out", "folder for the files [default: NAME/ beside RESULT]", "DIR")] = None,
    option: Annotated[
        list[str] | None, option("--option", "option of the export; may be repeated", "NAME=VALUE")
    ] = None,
) -> None:
    """Write files for other programs, a folder for each estimate. ParaView files need [output] paraview = true."""
    if not to:
        rows = [(each.name, each.description) for each in EXPORTERS]
        to_stderr(plain_table(("--to", "writes"), rows, (True, True)).rstrip())
        refuse("--to", f"is missing: give one of {', '.join(EXPORTERS.names())}")
    exporter = EXPORTERS.find(to, "--to")
    options = _export_options(option or [])
    exporters.read_options(exporter, options)
    if out is not None:
        refuse_no_folder(out)
    for name, each in (all_folders_of(result) or {"": result}).items():
        _export_one(each, exporter, options, out / name if out and name else out)


def _export_one(result: Path, exporter: exporters.Exporter, options: dict[str, str], out: Path | None) -> None:
    """Write the files of one run."""
    folder = result if result.is_dir() else result.parent
    source = _export_source(result, exporter)
    place = own_folder(folder, exporter.name) if out is None else out
    kept = () if out is not None else (partial(note, folder),)  # the next run into the folder removes what is listed
    done = exporters.export(source, exporter.name, exporters.Target(place / exporter.file, *kept), **options)
    for path in done.files:
        print(path)
    for remark in done.remarks:
        to_stderr(f"note: {remark}")


def _export_options(given: list[str]) -> dict[str, str]:
    """Return {name: value} of options NAME=VALUE."""
    pairs = [text.partition("=") for text in given]
    for name, sign, _ in pairs:
        if not sign or not name:
            refuse("--option", f"'{name}' is not NAME=VALUE")
    values = {name.strip(): value.strip() for name, _, value in pairs}
    if len(values) < len(pairs):
        names = [name.strip() for name, *_ in pairs]
        refuse("--option", f"'{max(names, key=names.count)}' is given twice: one value is needed")
    return values


def _export_source(result: Path, exporter: exporters.Exporter) -> exporters.Source:
    """Return the springs, or the full model of a folder or file; refuse a run that has not ended."""
    from pysprings.full_model.accuracy.two_mesh import missing, words
    from pysprings.full_model.run_record import RunRecord
    from pysprings.results.layout import open_result

    if exporter.needs == "springs":
        source = exporters.Source(springs=springs_of(result))
        record = RunRecord.read(result if result.is_dir() else result.parent)
        if record and record.scene_sha256 == source.springs.attrs.get("scene_sha256"):
            source.mesh_error = words(record.error_estimate or missing("the run made none"))
        return source
    refuse_unfinished(result)
    return exporters.Source(result=open_result(result))


def soildyn(
    out: Annotated[Path, argument("DIR", "folder for the library")],
    compiler: Annotated[
        str | None, option("--compiler", "C compiler [default: CC, cc, gcc or clang]", "COMMAND")
    ] = None,
) -> None:
    """Build the library of `export --to openfast` for SoilDyn."""
    from pysprings.results.exporters.soildyn.library import build

    refuse_no_folder(out)
    print(build(out, compiler))
