# SPDX-License-Identifier: MIT
"""Scene -> model: what the engine is given, and that every value of a scene decides something."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from fe_engine.assembly.system import System
from fe_engine.contact import coulomb
from fe_engine.errors import MeshError
from fe_engine.settings import Settings
from fe_engine.soil import plasol
from fe_engine.state import State
from pysprings import Scene
from pysprings.core.path_kinds import LOADS
from pysprings.model import build, fourier
from pysprings.model.build import Built, build_model
from pysprings.model.contact import SURFACE
from pysprings.model.forecast.omissions import left_out
from pysprings.model.stages import path_stages
from pysprings.scene.checks import TURNS
from pysprings.scene.fields import Choice, Count, Flag, Number, Quantity, QuantityList, Text, field_of
from pysprings.scene.load import SECTIONS
from pysprings.scene.soils.clay import TABLES
from tests.support import tiny

R_OUT, R_IN, LENGTH = 3.9, 3.8, 4.0
WEIGHT, SURCHARGE = 10.56e3, 10.56e3


@pytest.fixture(scope="module")
def built() -> Built:
    return build_model(tiny.scene())


def test_dead_load_balances_the_initial_contact(built: Built) -> None:
    """Half of lid area times surcharge, and tip area times vertical stress at the tip."""
    lid, tip = np.pi * R_IN**2, np.pi * (R_OUT**2 - R_IN**2)
    expected = 0.5 * (lid * SURCHARGE + tip * (SURCHARGE + WEIGHT * LENGTH))
    assert built.balanced_load == pytest.approx(expected, rel=1e-9)
    assert built.extra_load == 0.0
    heavy = build_model(tiny.scene(caisson={"vertical_load": "3 MN"}))
    assert heavy.extra_load == pytest.approx(1.5e6 - expected, rel=1e-9)


def test_the_initial_state_is_in_equilibrium_exactly(built: Built) -> None:
    system, state = System(built.model), State(built.model)
    residual = system.residual(state)
    assert np.abs(residual.free).max() == 0.0
    assert np.abs(residual.border).max() == 0.0


def test_initial_stresses_follow_depth_and_k0() -> None:
    built = build_model(tiny.scene(soil={"K0": 0.9}))
    stations, depth = built.model.stations, built.model.mesh.nodes[:, 2]
    assert stations is not None
    vertical = SURCHARGE + WEIGHT * stations.position[:, 2]
    wall = np.isin(stations.surface, [SURFACE["outer"], SURFACE["inner"]])
    np.testing.assert_allclose(built.model.initial_pressure, np.where(wall, 0.9, 1.0) * vertical)
    stress = built.model.initial_stress
    np.testing.assert_allclose(stress[..., 0], 0.9 * stress[..., 2])
    np.testing.assert_allclose(stress[..., 1], stress[..., 0])
    assert np.abs(stress[..., 3:]).max() == 0.0
    assert -SURCHARGE - WEIGHT * depth.max() < stress[..., 2].min() and stress[..., 2].max() < -SURCHARGE


def test_stations_carry_the_exact_normals_of_the_caisson(built: Built) -> None:
    stations = built.model.stations
    assert stations is not None
    x, y, _ = stations.position.T
    radial = np.stack([x, y, 0.0 * x], axis=1) / np.maximum(np.hypot(x, y), 1e-300)[:, None]
    for name, sign in (("outer", 1.0), ("inner", -1.0)):
        mine = stations.surface == SURFACE[name]
        np.testing.assert_allclose(stations.frame[mine, 0], sign * radial[mine], atol=1e-12)
    for name in ("lid", "tip"):
        mine = stations.surface == SURFACE[name]
        np.testing.assert_allclose(stations.frame[mine, 0], np.broadcast_to([0, 0, 1.0], (mine.sum(), 3)), atol=1e-12)
    assert set(stations.surface) == set(SURFACE.values())
    assert stations.area.min() > 0.0


def test_the_body_moves_as_the_axes_say(built: Built) -> None:
    stations = built.model.stations
    assert stations is not None
    u, w, rotation = 1e-3, 2e-3, 3e-4
    moved = stations.body @ np.array([u, w, rotation])
    x, _, z = stations.position.T
    np.testing.assert_allclose(moved, np.stack([u - rotation * z, 0.0 * x, w + rotation * x], axis=1), atol=1e-18)


@pytest.mark.parametrize("side", ["roller", "fixed"])
def test_boundaries(side: str) -> None:
    model = build_model(tiny.scene(domain={"side": side})).model
    fixed, sets = model.fixed, model.mesh.node_sets
    assert fixed[sets["bottom"]].all()
    assert fixed[sets["symmetry"], 1].all()
    free_side = np.setdiff1d(sets["side"], sets["bottom"])
    assert fixed[free_side, 0].all()
    assert fixed[free_side, 2].all() == (side == "fixed")
    other = np.setdiff1d(np.arange(model.mesh.n_nodes), np.concatenate([sets[name] for name in sets]))
    assert not fixed[other].any()
    for node, frame in model.frames.items():  # first axis radial, right-handed
        radial = model.mesh.nodes[node, :2] / np.hypot(*model.mesh.nodes[node, :2])
        np.testing.assert_allclose(frame[0, :2], radial)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
    off_plane = np.setdiff1d(sets["side"], sets["symmetry"])
    assert set(model.frames) == (set(off_plane.tolist()) if side == "roller" else set())


def test_names_change_here_and_nowhere_else(built: Built) -> None:
    scene = tiny.scene(
        interface={"friction_coefficient": 0.31, "normal_stiffness": 3e9, "shear_stiffness": 2e9},
        soil={"cohesion": 7e3, "dilation_angle": 0.01},
    )
    model = build_model(scene).model
    stations = model.stations
    assert stations is not None
    assert model.contact.shape == (len(stations), len(coulomb.PARAMETERS))
    radius = np.hypot(*stations.position[:, :2].T)
    corner = (stations.surface == SURFACE["lid"]) & (radius > radius[stations.surface == SURFACE["inner"]].min() - 1e-9)
    assert corner.sum() == len(built.caisson.azimuth)
    np.testing.assert_array_equal(model.contact[:, coulomb.MU], np.where(corner, 0.0, 0.31))
    assert (model.contact[:, coulomb.KN] == 3e9).all()
    assert (model.contact[:, coulomb.KT] == 2e9).all()
    soil = scene.soil
    expected = plasol.pack(
        young=soil.young_modulus, poisson=soil.poisson_ratio, phi_i=soil.friction_angle_initial,
        phi_f=soil.friction_angle_final, b_phi=soil.hardening_parameter, psi=soil.dilation_angle, cohesion=7e3,
    )  # fmt: skip
    np.testing.assert_array_equal(model.materials[0].parameters, expected)


def test_a_geometry_that_cannot_be_meshed_is_a_mesh_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ValueError("f(a) and f(b) must have different signs")

    monkeypatch.setattr(build, "make_mesh", fail)
    with pytest.raises(MeshError, match="cells cannot be graded in this geometry"):
        build_model(tiny.scene())


# --- every value of a scene decides something ---

# Fields that change nothing today. `pysprings check` and the report name them in what the scene leaves out.
UNUSED = {
    ("caisson", "young_modulus"): 2e11,  # rigid
    ("caisson", "poisson_ratio"): 0.25,  # rigid
}
# Fields that need water: they change nothing in a drained scene.
WATER = {
    ("soil", "hydraulic_conductivity"): 1e-5,
    ("interface", "transversal_conductivity"): 1e-9,
    ("interface", "residual_aperture"): 2e-5,
    ("domain", "side_drainage"): "drained",
    ("drainage", "porosity"): 0.3,
    ("drainage", "water_bulk_modulus"): "incompressible",
    ("drainage", "water_unit_weight"): 1e4,
    ("drainage", "water_viscosity"): 2e-3,
    ("drainage", "water_depth"): 30.0,
    ("drainage", "stabilisation"): 0.5,
}
# Fields with one value so far.
OF_SAND = {
    "relative_density": 0.7, "critical_friction_angle": 0.6, "mobilisation_strain": 0.02, "softening_strain": 0.1,
    "contraction": 0.2,
}  # fmt: skip
SINGLE: set[tuple[str, str]] = set()
# Another value, where a change by a tenth is not one.
CLAY = {
    "soil": tiny.only(yield_surface="tresca", undrained_shear_strength=20e3, rigidity_ratio=200.0),
    "interface": {"adhesion_factor": 0.5},
}
OF_CLAY = (
    "undrained_shear_strength", "rigidity_ratio", "strain_at_half_strength", "adhesion_factor", "plasticity_index",
    "overconsolidation_ratio",
)  # fmt: skip
FACTORS = ("compression_factor", "direct_shear_factor", "extension_factor")
CHANGES: dict[tuple[str, str], Any] = {
    ("design", "cases"): "loads.csv",
    ("soil", "layers"): ({"top": 0.0, "cohesion": 3e3},),
    ("interface", "normal_stiffness"): 3e9,
    ("interface", "shear_stiffness"): 3e9,
    ("caisson", "vertical_load"): 3e6,
    ("solver", "viscous_displacement"): 1e-7,
    ("caisson", "behaviour"): "elastic",
    ("domain", "side"): "fixed",
    ("soil", "yield_surface"): "elastic",
    ("soil", "dilation_angle"): 0.05,
    ("soil", "cohesion"): 1e3,
    ("soil", "shear_modulus"): 2e7,
    ("soil", "undrained_shear_strength"): 30e3,
    ("soil", "rigidity_ratio"): 100.0,
    ("soil", "strain_at_half_strength"): 0.02,
    ("soil", "shear_modulus_reduction"): [[1e-4, 0.9], [1e-3, 0.5], [1e-2, 0.1]],
    ("soil", "cyclic"): {"contours": [[9, 0, 0.4, 0, 0.01], [9, 0, 0.5, 0, 0.1]], "cycles": 9.0},
    ("soil", "plasticity_index"): 40.0,
    ("soil", "overconsolidation_ratio"): 2.0,
    **{("soil", name): 1.2 for name in FACTORS},
    **{("soil", name): value for name, value in OF_SAND.items()},
    ("soil", "degradation_strain"): 3e-4,
    ("soil", "degradation_limit"): 0.5,
    ("interface", "adhesion_factor"): 0.6,
    ("interface", "opening"): "bonded",
    ("mesh", "preset"): "medium",
    ("mesh", "azimuth"): 12,
    ("mesh", "discretisation"): "fourier",
    ("springs", "vertical_loads"): (1e6,),
    ("springs", "rates"): (1e-4,),
    ("springs", "rays"): (0.0, -0.5),
    ("mesh", "harmonics"): 2,
    ("mesh", "refinement"): 0.6,
    ("solver", "linear"): "superlu",
    ("path", "name"): "push",
    ("path", "kind"): "translation",
    ("path", "rotation"): 1e-4,
    ("path", "lateral_force"): 2e6,
    ("path", "arm"): 2.0,
    ("path", "heave"): "fixed",
    ("path", "role"): "held-back",
    ("path", "report_at"): (0.25e-3,),
    ("path", "duration"): 100.0,
    ("path", "then"): ("1 mm",),
    ("path", "arm_from"): 1.0,
    ("path", "vertical_load"): 3e6,
    ("drainage", "mode"): "coupled",
}
_HELD = {"lateral_displacement": None, "role": "held-back"}
_SPACE: dict[str, dict[str, Any]] = {
    "torsion_angle": {"kind": "probe", "load_angle": 0.3, "role": "held-back"},
    "twist": _HELD | {"kind": "twist", "twist": 1e-3}, "radius": _HELD | {"kind": "circle", "radius": 1e-3},
    **dict.fromkeys(TURNS, _HELD | {"kind": "motion", "u_x": 1e-3}),
    **dict.fromkeys(LOADS, _HELD | {"kind": "load", "H_y": 1e6}),
}  # fmt: skip
# What a path must be for a field of it to be used.
PATHS: dict[str, dict[str, Any]] = {
    "rotation": {"kind": "translation"},
    "lateral_force": {"name": "a", "kind": "load", "lateral_force": 1e6, "lateral_displacement": None},
    "vertical_displacement": {"kind": "vertical", "lateral_displacement": None, "vertical_displacement": 1e-3},
    "rate": {"rate": 1e-4},
    "then": {"role": "held-back"},
    "load_angle": {"kind": "probe", "load_angle": 0.3, "role": "held-back"},
    **_SPACE,
    "arm_from": {"kind": "load", "lateral_force": 1e6, "lateral_displacement": None, "role": "held-back", "arm": 2.0},
}


def outputs(scene: Scene) -> dict[str, Any]:
    """Everything that a run computes from, and what it writes about the scene, without solving anything."""
    built = fourier.build(scene)
    path = scene.paths[0]
    return {
        "model": flat(built.model),
        "stages": flat(path_stages(scene, path, built.extra_load_of(scene.vertical_load_of(path)))),
        "newton": flat(Settings(scene.solver.tolerance, scene.solver.max_iterations)), "linear": scene.solver.linear,
        "kept": scene.output, "paths": scene.all_paths, "limit": scene.limit, "design": scene.design,
        "names": (scene.title, path.name, path.role), "sea": scene.drainage.water_depth,
        # the lid is only drawn; the diameter and skirt are measured in the mesh
        "drawn": scene.caisson.lid_thickness,
    }  # fmt: skip


def flat(value: Any) -> Any:
    """Nested dataclasses and arrays as lists that compare."""
    if is_dataclass(value) and not isinstance(value, type):
        return [flat(getattr(value, item.name)) for item in fields(value)]
    if isinstance(value, dict):
        return [(key, flat(item)) for key, item in value.items()]
    if isinstance(value, list | tuple):
        return [flat(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def changed(scene: Scene, section: str, name: str, value: Any) -> Scene:
    if section == "path":
        return scene.replace(paths=({**scene.paths[0].model_dump(), name: value},))
    extra = {"young_modulus": None} if name == "shear_modulus" else {}
    return scene.replace(**{section: {name: value, **extra}})


# soil.estimate is used where a scene is read
ALL = [(section, name) for section, model in SECTIONS.items() for name in model.model_fields if name != "estimate"]


def other_value(section: str, name: str, scene: Scene) -> Any:
    """Another valid value of a field: from the list above, or the present one a tenth larger."""
    key = (section, name)
    if key in {**CHANGES, **UNUSED, **WATER}:
        return {**CHANGES, **UNUSED, **WATER}[key]
    field = field_of(SECTIONS[section].model_fields[name])
    table = scene.paths[0] if section == "path" else getattr(scene, section)
    value = getattr(table, name)
    if isinstance(field, Flag):
        return not value
    assert isinstance(field, Quantity | Number | Count), f"say in CHANGES to what {section}.{name} changes"
    if value is None:
        return 0.02
    return value + 1 if isinstance(field, Count) else 1.1 * value


@pytest.fixture(scope="module")
def base_outputs() -> dict[str, Any]:
    return {}


@pytest.mark.parametrize(("section", "name"), [key for key in ALL if key not in SINGLE])
def test_every_field_changes_some_output(section: str, name: str, base_outputs: dict[str, Any]) -> None:
    # no step sizes and a surcharge that K0 and cohesion can work with
    scene = tiny.scene(solver={"first_step_fraction": None, "max_step_fraction": None})
    if section == "path" and name in PATHS:
        scene = scene.replace(mesh={"discretisation": "fourier"}) if name in _SPACE else scene
        path = {key: v for key, v in (scene.paths[0].model_dump() | PATHS[name]).items() if v is not None}
        scene = scene.replace(paths=(path,))
    if (section, name) in (("mesh", "harmonics"), ("mesh", "halvings")):
        scene = scene.replace(mesh={"discretisation": "fourier"})
    if name in (*OF_CLAY, *FACTORS):
        scene = scene.replace(**CLAY).replace(soil={"yield_surface": "von-mises"} if name in FACTORS else {})
    if name in ("plasticity_index", "overconsolidation_ratio"):
        scene = scene.replace(soil={"rigidity_ratio": None, "plasticity_index": 30.0})
    if name in TABLES:
        scene = scene.replace(**CLAY).replace(soil={"yield_surface": "iwan-clay"})
    if name in OF_SAND:
        scene = scene.replace(soil=tiny.only(yield_surface="sand", relative_density=0.5, K0=0.6))
    if name == "degradation_limit":
        scene = scene.replace(soil={"degradation_strain": 2e-4})
    if section == "springs":
        scene = scene.replace(springs={"reach": 0.01})
    if name == "directions":
        scene = scene.replace(mesh={"discretisation": "fourier"}, springs={"memory": True})
    if (section, name) == ("design", "arm"):
        scene = scene.replace(design={"lateral_force": 1e6})
    if (section, name) == ("soil", "K0"):
        scene = scene.replace(soil={"cohesion": 50e3})
    before = base_outputs.setdefault(scene.sha256, outputs(scene))
    if (section, name) == ("drainage", "mode"):
        scene = changed(scene, "path", "rate", 1e-4)
    after = outputs(changed(scene, section, name, other_value(section, name, scene)))
    differs = [key for key in before if before[key] != after[key] and key != "sea"]
    if (section, name) in {**UNUSED, **WATER}:
        assert differs == []
        assert any(f"{section}.{name}" in omission.what for omission in left_out(scene))
    else:
        assert differs


@pytest.mark.parametrize(("section", "name"), WATER)
def test_every_field_of_the_water_changes_some_output_of_a_coupled_scene(section: str, name: str) -> None:
    path = {**tiny.PULL, "rate": 1e-4}
    scene = tiny.scene(drainage={"mode": "coupled"}, paths=(path,))
    before, after = outputs(scene), outputs(changed(scene, section, name, WATER[section, name]))
    assert any(before[key] != after[key] for key in before)


def test_the_lists_of_fields_are_current() -> None:
    assert {*UNUSED, *WATER, *SINGLE, *CHANGES} <= set(ALL)
    for section, name in SINGLE:
        field = field_of(SECTIONS[section].model_fields[name])
        assert isinstance(field, Choice) and len(field.words) == 1
    assert isinstance(field_of(SECTIONS["path"].model_fields["report_at"]), QuantityList)
    assert isinstance(field_of(SECTIONS["path"].model_fields["name"]), Text)
