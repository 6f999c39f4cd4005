# SPDX-License-Identifier: MIT
"""`pysprings init` and `pysprings check`: write a scene, describe a scene."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pysprings.cli.options import Changes, Json, Mesh, SceneFile, Series, Target, argument, option
from pysprings.cli.support import print_json, print_table, refuse, to_stderr
from pysprings.core.columns import Column, Table, filled
from pysprings.core.errors import printable
from pysprings.core.text import number
from pysprings.scene.template import template_names, write_scene

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

# Entries of a description whose name needs a unit or more words
LABELS = {
    "vertical_load_N": "vertical load [N]",
    "memory_GB": "memory, estimated [GB]",
    "disk_GB": "full_model.nc, estimated [GB]",
    "time_s": "time, estimated [s]",
    "runs_at_most": "runs, at most; memory and time below are of the first",
    "further_run_least": "time of a further run over that of the one before, from",
    "further_run_most": "to",
    "memory_with_pardiso_GB": "memory with Pardiso (extra mkl) [GB]",
    "time_with_pardiso_s": "time with Pardiso (extra mkl) [s]",
    "domain_radius_over_diameter": "radius of the domain over the diameter",
    "soil_below_tip_over_diameter": "soil below the tip over the diameter",
    "stiffening_by_the_domain_percent": "stiffer than unbounded soil, at most [%]",
    "stiffening_of_K_H_percent": "of it K_H, at most [%]",
    "stiffening_of_K_V_percent": "of it K_V, at most [%]",
    "stiffening_of_K_M_percent": "of it K_M, at most [%]",
    "normal_stiffness_N_per_m3": "penalty, normal [N/m3]",
    "shear_stiffness_N_per_m3": "penalty, shear [N/m3]",
    "largest_initial_penetration_m": "its largest initial penetration [m]",
    "loss_of_elastic_stiffness_percent": "its loss of elastic stiffness [%]",
}


def init(
    file: Annotated[Path, argument("FILE", "scene file to write")] = Path("caisson.toml"),
    template: Annotated[
        str, option("--template", f"scene to start from: {', '.join(template_names())}", "NAME")
    ] = "caisson",
    force: Annotated[bool, option("--force", "replace existing files")] = False,
) -> None:
    """Write a commented scene, and a JSON schema for editors."""
    written = write_scene(file, template, force)
    for path in written:
        print(path)
    note = "" if len(written) > 1 else "the schema that was there is kept; --force renews it\n"
    to_stderr(f"{note}next: pysprings check {shlex.quote(str(file))}")


def check(
    scene: SceneFile,
    mesh: Mesh = None,
    discretisation: Series = None,
    target: Target = None,
    changes: Changes = None,
    as_json: Json = False,
) -> None:
    """Validate a scene; print its defaults, omissions, size and cost. It solves nothing."""
    from pysprings.cli.run import target_start
    from pysprings.full_model.accuracy.target import runs_ahead
    from pysprings.model.forecast.estimate import describe

    loaded, chosen = on_mesh(load(scene, discretisation, changes), mesh), {}
    if target is not None:
        loaded = target_start(loaded, target, mesh)
        chosen = {"target_error": {"target": target, "begins_with": loaded.mesh.preset} | runs_ahead()}
    about = chosen | describe(loaded)
    if as_json:
        print_json(description(scene, loaded, about))
    else:
        print_description(scene, loaded, about)


def load(file: Path, discretisation: str | None = None, changes: Sequence[str] | None = None) -> Scene:
    """Load a scene with changed values; refuse a discretisation that cannot represent it."""
    from pysprings.core.tables.load_cases import read_load_cases
    from pysprings.scene.checks import clashes, dotted
    from pysprings.scene.load import load_scene

    scene = load_scene(file, changes or ())
    if scene.design.cases is not None:
        read_load_cases(scene.design.cases)  # what is wrong with them shows before anything is computed
    if discretisation is None or discretisation == scene.discretisation:
        return scene
    changed = scene.model_copy(update={"mesh": scene.mesh.model_copy(update={"discretisation": discretisation})})
    for clash in clashes(changed):
        refuse("--discretisation", f"{dotted(clash.keys[0])}: {clash.message}")
    return scene.replace(mesh={"discretisation": discretisation})


def on_mesh(scene: Scene, preset: str | None) -> Scene:
    """Return the scene on another mesh preset; as it is without one."""
    return scene.replace(mesh={"preset": preset}) if preset else scene


def description(file: Path, scene: Scene, about: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document that `pysprings check --json` prints."""
    paths = [{"name": path.name, "kind": path.kind, "role": path.role} for path in scene.all_paths]
    head = {"scene": str(file), "title": scene.title, "scene_sha256": scene.sha256, "paths": paths}
    return {**head, **estimate_of(scene), "left_out": [], **about}


def estimate_of(scene: Scene) -> dict[str, str]:
    """Return the entry of a document that names whose values of the ranges of a scene count; none without ranges."""
    return {"estimate": scene.estimate} if scene.estimate else {}


_GROUND = (
    Column("layer", "layer", words=True),
    Column("law", "law", words=True),
    Column("z [m]", "depth_m"),
    Column("unit weight [kN/m3]", "effective_unit_weight_N_per_m3", factor=1e-3),
    Column("vertical stress [kPa]", "vertical_effective_stress_Pa", factor=1e-3),
    Column("K0", "K0"),
    Column("G [MPa]", "shear_modulus_Pa", factor=1e-6),
    Column("phi [deg]", "friction_angle_deg"),
    Column("D_r", "relative_density"),
    Column("I_R, 0 to 4", "dilatancy_index"),
    Column("phi peak [deg]", "peak_friction_angle_deg"),
    Column("c [kPa]", "cohesion_Pa", factor=1e-3),
    Column("su [kPa]", "undrained_shear_strength_Pa", factor=1e-3),
    Column("su compression [kPa]", "su_compression_Pa", factor=1e-3),
    Column("su direct shear [kPa]", "su_direct_shear_Pa", factor=1e-3),
    Column("su extension [kPa]", "su_extension_Pa", factor=1e-3),
    Column("su after cycles [kPa]", "cyclic_strength_Pa", factor=1e-3),
    Column("alpha outside", "adhesion_factor_outside"),
    Column("alpha inside", "adhesion_factor_inside"),
)


_BACKBONE = (
    Column("layer", "layer", words=True), Column("contours", "contours", words=True), Column("N", "cycles"),
    Column("tau_a/su", "average"), Column("strain [%]", "strain", factor=100.0), Column("tau/su", "stress_over_su"),
)  # fmt: skip

_LOADS = (
    Column("V [MN]", "V_N", factor=1e-6), Column("paths", "paths"), Column("time, estimated [s]", "time_s", 3),
    Column("load cases", "cases"),
)  # fmt: skip


def print_estimate(scene: Scene) -> None:
    """Print which values of the ranges of a scene count; nothing of a scene without ranges."""
    if scene.estimate:
        print(f"of values with a range the {scene.estimate} ones count (soil.estimate)")


def print_description(file: Path, scene: Scene, about: Mapping[str, Any]) -> None:
    """Print the description of a scene that `pysprings check` has made."""
    from pysprings.model.forecast.omissions import saved_text
    from pysprings.scene.defaults import value_text

    print(printable(f"{file}: {scene.title}"))
    print(f"sha256 {scene.sha256}")
    print_estimate(scene)
    paths = ", ".join(f"{path.name} ({path.kind}, {path.role})" for path in scene.all_paths)
    print(f"mesh {scene.mesh.preset}; paths: {paths}\n")
    apart = ("ground", "cyclic", "vertical_loads", "left_out", "warnings", "defaulted")
    rows = [row for key, value in about.items() if key not in apart for row in _rows(key, value)]
    print_table(Table("", ("quantity", "value"), rows))
    if rows := about.get("ground", ()):
        print("\nground:")
        print_table(Table.of(filled(_GROUND, rows), rows))
    if rows := about.get("cyclic", ()):
        print("\nbackbone after cycles: a hyperbola from G, then")
        print_table(Table.of(filled(_BACKBONE, rows), rows))
    if rows := about.get("vertical_loads", ()):
        nearest = ", with the load cases that each is nearest to" if "cases" in rows[0] else ""
        print(f"\nsprings by vertical load{nearest}:")
        print_table(Table.of(filled(_LOADS, rows), rows))
    if rows := about.get("defaulted", ()):
        print("\ndefaults, which this scene does not give:")
        print_table(Table("", ("key", "value"), [(row["key"], value_text(row)) for row in rows]))
    print("\nleft out by this scene:")
    for omission in about.get("left_out", ()):
        print(f"- {omission['what']}: {omission['why']}")
        if saves := saved_text(omission["saved"]):
            print(f"  saves {saves}")
    for text in about.get("warnings", ()):
        to_stderr(f"warning: {text}")


def _rows(key: str, value: Any) -> list[tuple[str, str]]:
    """Return the lines of one entry of a description; a table of counts has one line each."""
    if isinstance(value, Mapping):
        return [(LABELS.get(str(name), str(name).replace("_", " ")), number(count)) for name, count in value.items()]
    return [(LABELS.get(key, key.replace("_", " ")), number(value))]
