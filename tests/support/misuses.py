# SPDX-License-Identifier: MIT
"""Misuses of the program, each with what it has to say: `tests/pysprings/cli/test_misuses.py` runs them."""

import json
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from pysprings.springs.checks import save_springs
from tests.support import synthetic
from tests.support.fans import fan_springs, potential
from tests.support.vertical import vertical_springs

# exit codes: no answer; an answer with a warning, and with marks where it has states; no equilibrium
REFUSED, WARNED, LOST = 2, 0, 3


@dataclass(frozen=True)
class Misuse:
    """What somebody does, the command, its exit code, and a pattern of what it says on stderr."""

    what: str
    command: str
    code: int
    says: str


def _m(what: str, command: str, says: str, code: int = REFUSED) -> Misuse:
    return Misuse(what, command, code, says)


LOADS = (
    _m(
        "load beyond the calibrated range", "predict one.nc --H 20MN", "beyond the range of path 'pull'.*they carry H ="
    ),
    _m("the same, the other way", "predict one.nc --H -20MN", "beyond the range of path 'pull'.*they carry H = -"),
    _m("moment beyond the range", "predict one.nc --M 500MNm", "beyond the range.*--extrapolate"),
    _m("load beyond the range of a fan", "predict fan.nc --H 100MN --arm 5m", "beyond the range of the fan of 8 paths"),
    _m("curve beyond the range", "predict one.nc --u-max 50mm", "beyond the range of path 'pull'"),
    _m("displacement beyond the range", "predict one.nc --u 50mm", "beyond the range of path 'pull'"),
    _m("rotation beyond the range", "predict fan.nc --rotation 5deg", "beyond the range of the fan"),
    _m("stiffness under a load beyond the range", "predict one.nc --H 20MN --stiffness", "beyond the range"),
    _m(
        "answer beyond the range that was asked for",
        "predict one.nc --H 20MN --extrapolate",
        "warning: beyond the range",
        WARNED,
    ),
    _m("load beyond a limit load of the full model", "predict limit.nc --H 4MN", "path 'pull' met a limit load"),
    _m("the same, with --extrapolate", "predict limit.nc --H 4MN --extrapolate", "path 'pull' met a limit load"),
    _m("load beyond the end of a path that stopped", "predict stopped.nc --H 4MN", "path 'pull' stopped.*apex"),
    _m(
        "load that no motion carries",
        "predict soft.csv --H 5MN --arm -2m --extrapolate",
        "no equilibrium beyond H = ",
        LOST,
    ),
    _m("tilt beyond the range", "predict one.nc --tilt 5deg", "beyond the range of path 'pull'"),
    _m("motion beyond a limit load", "predict limit.nc --u 6mm --extrapolate", "path 'pull' met a limit load"),
    _m("--strict and --extrapolate", "predict one.nc --H 20MN --strict --extrapolate", "give one of them"),
)
DIRECTIONS = (
    _m(
        "springs of one pull under a load at another height",
        "predict one.nc --H 300kN --arm 8m",
        "off the path 'pull'",
        WARNED,
    ),
    _m("the same, with --strict", "predict one.nc --H 300kN --arm 8m --strict", "off the path 'pull'"),
    _m("p-y springs alone", "predict one.nc --H 100kN --springs py", "they carry a fraction of the load", WARNED),
    _m("between rays that are too far apart", "predict wide.nc --H -500kN --M -3MNm", "90 degrees apart", WARNED),
    _m("the same, with --strict", "predict wide.nc --H -500kN --M -3MNm --strict", "90 degrees apart"),
    _m("sequence that turns back", "predict fan.nc --sequence back.csv", "come after the sequence turned back", WARNED),
    _m("the same, with --strict", "predict fan.nc --sequence back.csv --strict", "turned back"),
    _m("sequence that turns aside", "predict fan.nc --sequence aside.csv", "left its first direction", WARNED),
    _m("the same, with --strict", "predict fan.nc --sequence aside.csv --strict", "left its first direction"),
    _m("spring set that is not there", "predict one.nc --H 1MN --springs best", "unknown spring set|best"),
)
VERTICAL = (
    _m("V far beyond that of the paths", "predict one.nc --V 500MN", "V is known from 0 N to 4 MN"),
    _m("uplift without a vertical path", "predict one.nc --H 100kN --V -1MN", "V is known from 0 N to 4 MN"),
    _m("V other than that of the paths", "predict one.nc --H 100kN --V 2.7MN", "is not that of path 'pull'", WARNED),
    _m("the same, with --strict", "predict one.nc --H 100kN --V 2.7MN --strict", "is not that of path 'pull'"),
    _m("V beyond the vertical springs", "predict down.nc --V 60MN", "beyond the vertical springs .path down"),
    _m("V against the only vertical path", "predict down.nc --V 1MN", "no vertical path leads upwards"),
    _m("V with springs from a table", "predict py.csv --H 10kN --V 1MN", "leave V out"),
)
WORDS = (
    _m("force for a height", "predict one.nc --H 1MN --arm 8kN", "is a force; expected a length"),
    _m("rate of drained springs", "predict one.nc --H 1MN --rate 1mm/s", "do not depend on a rate"),
    _m("one option twice", "predict one.nc --H 1MN --H 100kN", "--H: is given twice"),
    _m("tilt without a unit", "predict one.nc --tilt 0.25", 'unit such as "0.25 deg"'),
    _m("load that is no number", "predict one.nc --H nan", "expected a quantity with unit"),
    _m("points without a curve", "predict one.nc --H 100kN --points 10", "are those of a curve: give --u-max"),
    _m("load beyond all bounds", "predict one.nc --H 1e30MN", "is not in"),
    _m("answer in another format", "predict one.nc --H 100kN --out a.pdf", "ends in csv, json or nc"),
    _m("reference depth as a bare number", "predict one.nc --H 1MN --stiffness --reference-depth 4", "unit"),
)
FILES = (
    _m("table beyond its range", "predict py.csv --u 50mm", "beyond the range of path 'table'"),
    _m(
        "table beyond a peak of its curves", "predict soft.csv --u 3mm --rotation 0mrad", "a curve that softens", WARNED
    ),
    _m("table in another format", "predict py.ods --H 10kN", "is a spreadsheet of another program"),
    _m("column in another unit", "predict stress.csv --H 10kN", "wrong unit|wrong name or unit"),
    _m("sequence in another unit", "predict one.nc --sequence tons.csv", "unknown column"),
    _m("sequence of loads and motions", "predict one.nc --sequence mixed.csv", "expected either loads or motions"),
    _m("sequence with a gap", "predict one.nc --sequence gap.csv", "gap.csv:3: H_N"),
    _m("sequence that leaves the range", "predict one.nc --sequence beyond.csv", "beyond the range of path 'pull'"),
    _m("file that is not there", "predict none.nc --H 10kN", "none.nc"),
    _m("file cut short", "predict short.nc --H 10kN", "short.nc"),
    _m("file with doubled reactions", "predict doubled.nc --H 10kN", "the reactions sum to"),
    _m("folder without springs", "predict empty --H 10kN", "no springs.nc in this folder"),
    _m("folder of a run that was killed", "predict killed --H 10kN", "holds a run that has not ended"),
    _m("folder of an interrupted run, --strict", "predict broken --H 10kN --strict", "the run was interrupted"),
    _m("scene in the place of springs", "predict tight.toml --H 10kN", "of a run: springs.nc"),
    _m("empty table", "predict zero.csv --H 10kN", "missing column"),
    _m("memory of springs that have none", "predict fan.nc --H 10kN --springs memory", "no ray that turns back"),
    _m("files in the place of folders of runs", "diff one.nc fan.nc", "is not the folder of a run"),
    _m("run beside a folder without one", "diff empty empty", "is not the folder of a run"),
    _m("program that no export is for", "export one.nc --to nastran", "'nastran' is not one of"),
    _m("option that an export has not", "export one.nc --to openfast --option colour=red", "no option of 'openfast'"),
    _m("length for a direction", "export one.nc --to opensees --option azimuth=5m", "is a length"),
    _m("force without a unit", "export one.nc --to opensees --option V=1e6", 'such as "2 MN"'),
    _m(
        "torsion, which comes from the model", "export one.nc --to subdyn --option torsion=1e9", "no option of 'subdyn'"
    ),
    _m("export at a V that the springs have not", "export fan.nc --to openfast --option V=900MN", "are known at V = "),
    _m("export of the folder of a run that was killed", "export killed --to sacs", "has not ended"),
    _m(
        "nonlinear foundation from one path",
        "export one.nc --to openfast --option springs=memory",
        "no nonlinear foundation: it needs a fan",
        WARNED,
    ),
    _m("option of an export twice", "export one.nc --to openfast --option V=1MN --option V=2MN", "'V' is given twice"),
    _m("option of an export without a value", "export one.nc --to openfast --option x", "is not NAME=VALUE"),
)
SCENES = (
    _m("unknown key", "check key.toml", "unknown key .did you mean 'friction_coefficient'"),
    _m("unit of another quantity", "check unit.toml", "is a length; expected a pressure|is a length"),
    _m("caisson that does not fit into the domain", "check domain.toml", "domain"),
    _m("domain that is tight around the caisson", "check tight.toml", "domain", WARNED),
    _m("motion beyond small displacements", "check large.toml", "small", WARNED),
    _m("unusual stiffness", "check weak.toml", "shear_modulus.*outside the common range", WARNED),
    _m("empty scene", "check zero.toml", "the file is empty"),
    _m("changed value without a unit", "check tight.toml --set soil.young_modulus=80", "expected a quantity with unit"),
    _m("two paths of one name", "check twice.toml", "twice|already|unique|same name"),
    _m("height of a design load that is missing", "check arm.toml", "is the height of a load: give lateral_force"),
    _m("run that is resumed and begun anew", "run tight.toml --resume --force --out new", "give one of them"),
    _m("target error and a mesh", "run tight.toml --mesh coarse --target-error 1%", "chooses the mesh itself"),
    _m("file in the place of a result folder", "run tight.toml --out one.nc", "is a file, not a folder"),
    _m("folder in the place of a log", "run tight.toml --log empty", "is a folder, not a file"),
    _m("resumption of nothing", "run tight.toml --out empty --resume", "nothing to resume"),
    _m("path without its displacement", "check path.toml", "lateral_displacement"),
)
CASES = (
    _m("load cases without units", "design fan.nc nounit.csv", r"no unit: write 'H \[kN\]'"),
    _m("direction without a unit", "design fan.nc direction.csv", r"write 'direction \[deg\]'"),
    _m("one load in two columns", "design fan.nc twice.csv", "column stands 2 times"),
    _m("cells that are no numbers", "design fan.nc nan.csv", "is not a finite number"),
    _m("uplift beyond the springs, --strict", "design fan.nc uplift.csv --strict", "1 no answer"),
    _m("case beyond the springs, --strict", "design fan.nc far.csv --strict", "1 no answer"),
    _m("sizes in the place of loads", "design fan.nc sizes.csv", "unknown column; known are name"),
    _m("pressure for a load", "design fan.nc pressure.csv", "wrong unit .kPa.: expected a force"),
    _m("partial factor in per cent", "design fan.nc percent.csv", "135 is above 10"),
    _m("degrees in a column of radians", "design fan.nc radians.csv", "is beyond one turn, 360 deg"),
    _m("V beyond the springs, --strict", "design fan.nc heavy.csv --strict", "1 no answer"),
    _m("answers in the report of a spring file", "design fan.nc far.csv --report", "needs the folder of a run"),
    _m("load cases on springs of a killed run", "design killed far.csv", "has not ended"),
    _m("file for the answers in another format", "design fan.nc far.csv --out a.pdf", "ends in none of .csv"),
    _m("capacity at a V without a unit", "capacity tight.toml --V 3", "expected a quantity with unit"),
    _m("directions of the envelope out of range", "capacity tight.toml --directions 0", r"0 is not in \[2, 72\]"),
    _m("factor on a strength that is not there", "capacity tight.toml --factor phi=1.2", "one of tan_phi, c, su"),
    _m("capacity with springs and without", "capacity tight.toml --springs one.nc --no-macro", "give one of them"),
    _m("length for a vertical load", "capacity tight.toml --V 3m", "is a length; expected a force"),
    _m("load cases of a capacity without units", "capacity tight.toml --cases nounit.csv", "no unit: write"),
    _m("study of a key that is not there", "sweep key_study.toml", "soil.E: unknown key"),
    _m("study with values in other units", "sweep unit_study.toml", "is a length; expected a pressure"),
    _m("study of one key twice", "sweep twice_study.toml", "is that of another axis"),
    _m("scene in the place of a study", "sweep tight.toml", "scene: missing: the file of the base scene"),
    _m("factor that raises the strength", "capacity tight.toml --factor 0.8", "expected a number from 1 to 5"),
)
MISUSES = (*LOADS, *DIRECTIONS, *VERTICAL, *WORDS, *FILES, *SCENES, *CASES)

_TABLE = "depth_m,depth_top_m,depth_bottom_m,y_m,p_N_per_m\n"
_PULL = '[[path]]\nname = "pull"\nkind = "pull"\nlateral_displacement = "5 mm"\n'


def write_files(folder: Path) -> None:
    """Write the files of the misuses into a folder."""
    for name, tree in _springs().items():
        save_springs(tree, folder / f"{name}.nc")
    _write_broken(folder)
    slices = [(1.0, (0.0, 1e5, 1.5e5, 5e4)), (3.0, (0.0, 1e5, 1.5e5, 5e4))]
    knots = (0.0, 1e-3, 2e-3, 4e-3)
    soft = [f"{z},{z - 1},{z + 1},{y},{p}" for z, values in slices for y, p in zip(knots, values, strict=True)]
    hard = [f"{z},{z - 1},{z + 1},{y},{1e8 * y}" for z, _ in slices for y in knots]
    (folder / "soft.csv").write_text(_TABLE + "\n".join(soft) + "\n")
    (folder / "py.csv").write_text(_TABLE + "\n".join(hard) + "\n")
    (folder / "py.ods").write_text("PK")
    (folder / "stress.csv").write_text("depth_m,y_kPa,p_N_per_m\n1,0.1,1e5\n3,0.1,1e5\n")
    (folder / "tons.csv").write_text("H_tons,M_Nm\n1,0\n")
    (folder / "back.csv").write_text("H_N,arm_m\n2e5,2\n4e5,2\n1e5,2\n")
    (folder / "mixed.csv").write_text("H_N,u_m\n1e5,1e-3\n")
    (folder / "gap.csv").write_text("H_N,arm_m\n1e5,2\nnan,2\n")
    (folder / "beyond.csv").write_text("H_N,arm_m\n1e5,2\n9e7,2\n")
    (folder / "aside.csv").write_text("H_N,M_Nm\n1e5,0\n2e5,0\n2e5,1e6\n")
    for name, text in _CASES.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    for name, text in _SCENES.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")


def _springs() -> dict[str, xr.DataTree]:
    rays = [("push", "translation", 8e-3), ("turn", "rotation", 2e-3), ("back", "rotation", -2e-3)]
    wide = synthetic.make_springs(tuple(synthetic.Path(name, kind, size=size, steps=8) for name, kind, size in rays))
    trees = {
        "one": synthetic.make_springs(), "fan": fan_springs(potential), "wide": wide,
        "down": vertical_springs(ends=(1e-2,)),
    }  # fmt: skip
    for name, how, why in (
        ("limit", "limit load", "limit load: 1.2 % of the initial stiffness is left"),
        ("stopped", "stopped", "apex: 31 % of the soil there has no confining stress left"),
    ):
        trees[name] = synthetic.make_springs()
        path = trees[name]["paths/pull"]
        ends = {"H": "end_H_N", "M": "end_M_Nm", "u": "end_u_m", "rotation": "end_rotation_rad"}
        path.attrs |= {"end": how, "end_reason": why, "status": "limit load" if how == "limit load" else "partial"}
        path.attrs |= {key: float(path[quantity][-1]) for quantity, key in ends.items()}
    return trees


def _write_broken(folder: Path) -> None:
    whole = (folder / "one.nc").read_bytes()
    (folder / "short.nc").write_bytes(whole[: len(whole) // 2])
    doubled = synthetic.make_springs()
    for name in ("p", "p_component"):
        doubled[f"paths/pull/{name}"].values = 2.0 * doubled[f"paths/pull/{name}"].values
    doubled.to_netcdf(folder / "doubled.nc")
    (folder / "empty").mkdir()
    for name, status in (("killed", "writing"), ("broken", "interrupted")):
        (folder / name).mkdir()
        (folder / name / "springs.nc").write_bytes(whole)
        (folder / name / "run.json").write_text(json.dumps({"status": status, "scene_sha256": "0" * 64}))


_STUDY = 'scene = "tight.toml"\n[[axis]]\nkey = "{}"\nvalues = [{}]\n'
_GROUND = (
    'young_modulus = "200 MPa"\nfriction_angle_final = "30 deg"\neffective_unit_weight = "10 kN/m^3"\nK0 = 1.0\n'
    'surcharge = "10 kPa"\n'
)
_SCENES = {
    "key": "[interface]\nfriction_coeficient = 0.5\n",
    "unit": '[soil]\nyoung_modulus = "200 m"\n',
    "domain": '[caisson]\nouter_diameter = "20 m"\n[domain]\nradius = "9 m"\ndepth = "12 m"\n',
    "tight": f'[domain]\nradius = "6 m"\ndepth = "7 m"\n[soil]\n{_GROUND}[mesh]\nrefinement = 0.4\n{_PULL}',
    "large": f"[soil]\n{_GROUND}[mesh]\nrefinement = 0.4\n{_PULL}".replace("5 mm", "3 m"),
    "weak": f"[soil]\n{_GROUND}[mesh]\nrefinement = 0.4\n{_PULL}".replace("200 MPa", "200 kPa"),
    "twice": _PULL + _PULL,
    "zero": "",
    "arm": '[design]\narm = "20 m"\n',
    "key_study": _STUDY.format("soil.E", '"50 MPa"'),
    "unit_study": _STUDY.format("soil.young_modulus", '"80 m"'),
    "twice_study": _STUDY.format("soil.K0", "0.9") + _STUDY.format("soil.K0", "0.8").split("\n", 1)[1],
    "path": '[[path]]\nname = "pull"\nkind = "pull"\n',
}
_CASES = {
    "nounit": "name,H,arm [m]\na,100,2\n",
    "direction": "name,H [kN],arm [m],direction\na,100,2,45\n",
    "twice": "name,H [kN],H [MN],arm [m]\na,100,0.1,2\n",
    "nan": "name,H [kN],arm [m]\na,nan,2\nb,1e400,2\n",
    "sizes": "diameter [m],length [m]\n9,6\n",
    "pressure": "name,H [kPa],arm [m]\na,100,2\n",
    "percent": "name,H [kN],arm [m],factor H\na,100,2,135\n",
    "radians": "name,M [kN m],M direction [rad]\na,100,45\n",
    "heavy": "name,H [kN],arm [m],V [MN]\na,100,2,900\n",
    "uplift": "name,V [kN]\na,-5000\n",
    "zero": "",
    "far": "name,H [MN],arm [m]\na,500,2\n",
}
