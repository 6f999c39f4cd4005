# SPDX-License-Identifier: MIT
"""The whole caisson in six degrees of freedom: torsion, directions, and the half model as its special case."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.clock import Clock
from fe_engine.elements import fourier as elements
from fe_engine.errors import MeshError
from fe_engine.model import Stage
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings import Scene
from pysprings.core.variables import TORSION
from pysprings.full_model import compute, work as work_module
from pysprings.full_model.work import newton_of, prepare
from pysprings.model.contact import SURFACE
from pysprings.model.fourier import BuiltFourier, build_fourier
from pysprings.scene.sections import PAPER, PAPER_SOIL

PATH = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3}
G, NU = 10e6, 0.3
ELASTIC = {"yield_surface": "elastic", "shear_modulus": G, "poisson_ratio": NU, "effective_unit_weight": 10e3,
           "surcharge": 10e3, "K0": 0.5}  # fmt: skip
CLAY = {"yield_surface": "tresca", "undrained_shear_strength": {"top": 10e3, "gradient": 2e3}, "rigidity_ratio": 200.0,
        "effective_unit_weight": 7e3, "K0": 1.0}  # fmt: skip


@dataclass
class Rig:
    """A model on its way: ``rows`` are motions (nb,) and forces (nb,) of its steps."""

    built: BuiltFourier
    newton: Newton
    driver: Driver
    rows: list

    def drive(self, control, target, first=1.0):
        """Impose motions (nc,) along rows (nc, nb), by forces along the same; return the last row."""
        control, nb = np.atleast_2d(control).astype(float), self.built.model.n_border
        stage = Stage("way", control, np.atleast_1d(target), control.T, np.zeros(nb), (1.0,), first, 0.05)
        fields = self.driver.state.committed
        self.driver.run(stage, lambda s: self.rows.append((fields.border.copy(), s.increment.residual.border.copy())))
        return self.rows[-1]


def rig(scene, whole=True):
    """Return a model at rest."""
    built = build_fourier(scene, whole)
    newton = newton_of(scene, built, Clock())
    return Rig(built, newton, Driver(newton, State(built.model)), [])


def scene_of(soil, preset="coarse", harmonics=2, **sections):
    caisson = {"outer_diameter": 8.0, "skirt_length": 4.0, "skirt_thickness": 0.08} | sections.pop("caisson", {})
    return Scene(soil=soil, caisson=caisson, paths=(PATH,), mesh={"preset": preset, "harmonics": harmonics}, **sections)


def stiffness(scene, whole=True):
    each = rig(scene, whole)
    return each.newton.border_stiffness(each.driver.state)


def test_the_stiffness_is_isotropic_symmetric_and_that_of_the_half_model():
    scene = Scene(domain=PAPER, soil=PAPER_SOIL, paths=(PATH,), mesh={"preset": "coarse", "harmonics": 2})
    matrix, half = stiffness(scene), 2.0 * stiffness(scene, whole=False)
    size = np.abs(matrix).max()
    turn = np.kron(np.eye(2), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter of a turn about z
    np.testing.assert_allclose(turn @ matrix @ turn.T, matrix, atol=1e-11 * size)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * size)
    np.testing.assert_allclose(matrix[np.ix_([0, 2, 4], [0, 2, 4])], half, atol=1e-11 * size)
    alone = [(5, j) for j in range(5)] + [(0, 1), (0, 3), (1, 4)]
    assert max(abs(matrix[at]) for at in alone) < 1e-11 * size


def torsion_alone(mesh, held, turned):
    """Return the torque over rotation of bonded nodes by a series of its own, of u_theta alone (3 x 3 points), N m."""
    gauss, weight = np.polynomial.legendre.leggauss(3)
    corner, matrix = mesh.nodes[mesh.quads], np.zeros((mesh.n_elements, 8, 8))
    for i, j in np.ndindex(3, 3):
        value = elements.shape(gauss[i], gauss[j])
        slope = elements.shape_gradient(gauss[i], gauss[j])
        jacobian = np.einsum("ai,eaj->eij", slope, corner)
        radius = corner[:, :, 0] @ value
        strain = np.einsum("eji,ai->eja", np.linalg.inv(jacobian), slope)
        strain[:, 0] -= value / radius[:, None]
        volume = 2.0 * np.pi * G * weight[i] * weight[j] * radius * np.linalg.det(jacobian)
        matrix += np.einsum("eja,ejb,e->eab", strain, strain, volume)
    at = np.repeat(mesh.quads, 8, axis=1).ravel(), np.tile(mesh.quads, (1, 8)).ravel()
    whole = sparse.coo_matrix((matrix.ravel(), at), shape=(mesh.n_nodes,) * 2).tocsr()
    move = np.zeros(mesh.n_nodes)
    move[turned] = mesh.nodes[turned, 0]
    free = ~(held | mesh.on_axis | np.isin(np.arange(mesh.n_nodes), turned))
    move[free] = spsolve(whole[free][:, free].tocsc(), -(whole @ move)[free])
    return move @ (whole @ move)


@pytest.mark.parametrize("ratio", [0.25, 0.5, 1.0])
def test_torsion_of_bonded_caissons_is_that_of_a_scalar_series(ratio):
    """Within 1 %, which the interface yields, and within 0.2 % at ten times its stiffness."""
    found = {}
    for penalty in ("auto", 390 * 10 * 26e6 / 8.0):
        interface = {"normal_stiffness": penalty, "shear_stiffness": penalty}
        scene = scene_of(ELASTIC, "medium", 1, caisson={"skirt_length": 8.0 * ratio}, interface=interface,
                         domain={"radius": 80.0, "depth": 80.0})  # fmt: skip
        section = (each := rig(scene)).built.section
        turned = np.unique(np.concatenate([*section.walls.values(), section.lid, section.tip]))
        alone = torsion_alone(section.mesh, each.built.model.fixed[:, 1], turned)
        found[penalty] = each.newton.border_stiffness(each.driver.state)[5, 5] / alone
    assert list(found.values()) == pytest.approx([1.0, 1.0], abs=0.01)
    assert found["auto"] < list(found.values())[1] == pytest.approx(1.0, abs=2e-3)


def test_the_limit_of_torsion_is_that_of_friction():
    """Elastic soil: sum of mu p r over walls, lid and tip; the lid's ring at the skirt is smooth (0.2 %)."""
    rough, domain = {"friction_coefficient": 0.4}, {"radius": 40.0, "depth": 30.0}
    each = rig(scene_of(ELASTIC, harmonics=1, interface=rough, domain=domain))
    outer, inner, tip, mu = 4.0, 3.92, 4.0, 0.4
    walls = 2.0 * np.pi * (outer**2 + inner**2) * 0.5 * (10e3 * tip + 0.5 * 10e3 * tip**2)
    lid, base = inner**3 * 10e3, (outer**3 - inner**3) * (10e3 + 10e3 * tip)
    closed = mu * (walls + 2.0 / 3.0 * np.pi * (lid + base))
    motion, force = each.drive(np.eye(6)[5], 5e-3, 1e-3)
    assert force[5] == pytest.approx(closed, rel=5e-3)
    assert np.abs(np.delete(force, 5)).max() < 1e-6 * force[5] and np.abs(motion[:5]).max() < 1e-9
    s, model = each.built.model.stations, each.built.model
    radius = np.hypot(s.position[:, 0], s.position[:, 1])
    smooth = (s.surface == SURFACE["lid"]) & np.isin(s.nodes[:, 0], each.built.section.walls["inside"])
    carried = mu * (model.initial_pressure * s.area * radius)[~smooth].sum()
    assert force[5] == pytest.approx(carried, rel=1e-6)


@pytest.mark.slow
def test_in_clay_the_plug_turns_along():
    """Outer wall, tip, and strength of the plug's base carry the torque: less than all interfaces.

    Adhesion ends at the stress on a wall that may open: near mudline 7 kPa/m z is less than it.
    """
    each = rig(scene_of(CLAY, "medium", 1, interface={"adhesion_factor": 0.65}, solver={"tolerance": 1e-4}))
    _, force = each.drive(np.eye(6)[5], 5e-2, 1e-4)
    outer, inner, tip, adhesion = 4.0, 3.92, 4.0, 0.65
    meet = adhesion * 10e3 / (7e3 - adhesion * 2e3)
    wall = 0.5 * 7e3 * meet**2 + adhesion * (10e3 * (tip - meet) + 0.5 * 2e3 * (tip**2 - meet**2))
    base = 2.0 / 3.0 * np.pi * (10e3 + 2e3 * tip)
    closed = 2.0 * np.pi * outer**2 * wall + base * (inner**3 + adhesion * (outer**3 - inner**3))
    assert force[5] == pytest.approx(closed, rel=5e-3)


@pytest.mark.slow
def test_a_pull_has_the_same_answer_in_every_direction():
    scene = Scene(
        domain=PAPER,
        soil=PAPER_SOIL,
        paths=(PATH,),
        mesh={"preset": "medium", "harmonics": 3},
        solver={"tolerance": 1e-4},
    )
    each, answers = rig(scene), []
    first = 2e-5 / 2.5e-3
    for angle in np.radians([0.0, 22.5, 37.0, 45.0, 90.0]):
        each.driver = Driver(each.newton, State(each.built.model))
        along, across = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ np.eye(6)[:2]
        motion, force = each.drive([along, across], [2.5e-3, 0.0], first)
        turned = -np.sin(angle) * motion[3] + np.cos(angle) * motion[4]
        answers.append((along @ force, turned, across @ force))
    load, turned, across = np.array(answers).T
    np.testing.assert_allclose(load, load[0], rtol=1e-3)
    np.testing.assert_allclose(turned, turned[0], rtol=1e-3)
    assert np.abs(across / load).max() < 2e-3
    half = rig(scene, whole=False)
    motion, force = half.drive(np.eye(3)[0], 2.5e-3, first)
    assert [2.0 * force[0], motion[2]] == pytest.approx([load[0], turned[0]], rel=3e-3)  # other azimuths


@pytest.mark.parametrize("changes", [
    {}, {"caisson": {"behaviour": "elastic"}},
    {"mesh": {"preset": "coarse", "discretisation": "hex8", "refinement": 0.5}},
    {"drainage": {"mode": "undrained"}, "soil": ELASTIC | {"hydraulic_conductivity": 1e-6}},
])  # fmt: skip
def test_the_torsion_of_any_scene_is_that_of_the_whole_caisson(changes):
    """Of steel it is less; water takes no part, and bricks have that of the series."""
    given = {"soil": ELASTIC, "domain": {"radius": 40.0, "depth": 30.0}, "mesh": {"preset": "coarse"}, "paths": (PATH,)}
    found = prepare(Scene(**given | changes), Clock(), lambda *_: None)._initial_torsion()[0]
    mesh = {"preset": "coarse", "refinement": changes.get("mesh", {}).get("refinement", 1.0)}
    whole = stiffness(Scene(**given | {"mesh": mesh}))[5, 5]
    if "caisson" in changes:
        assert 0.9 * whole < found < 0.9999 * whole
    else:
        assert found == pytest.approx(whole, rel=1e-9)


def test_torsion_at_rest_needs_no_soil_law(monkeypatch):
    """Nor is it silent where it cannot be computed: the record states it, and nothing has a number."""
    given = {"soil": ELASTIC, "domain": {"radius": 40.0, "depth": 30.0}, "paths": (PATH,)}
    bricks = Scene(**given, mesh={"preset": "coarse", "discretisation": "hex8", "refinement": 0.4})
    work = prepare(bricks, Clock(), lambda *_: None)
    for name in ("residual", "linearise"):
        monkeypatch.setattr(FourierSystem, name, None)
    work.take_up(False, "")
    assert work.torsion > 0.0 and not any("torsion" in text for text in work.warnings)

    def fails(_scene):
        raise MeshError("cells cannot be graded")

    monkeypatch.setattr(work_module, "build_torsion", fails)
    run = compute.compute(bricks)
    assert "the torsional stiffness cannot be computed" in " ".join(run.record.warnings)
    assert run.record.stiffness_initial[TORSION] is None and TORSION not in run.tree.attrs
