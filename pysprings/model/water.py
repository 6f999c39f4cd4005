# SPDX-License-Identifier: MIT
"""Scene -> pore water of soil and interface: what flows, where it drains, which film joins the faces."""

from dataclasses import replace

import numpy as np

from fe_engine.elements import biot, fourier as elements, interface
from fe_engine.elements.interface import Film, Stations
from fe_engine.fourier_model import RingFilm, RingStations, SectionMesh, SeriesWater
from fe_engine.mesh import Mesh
from fe_engine.model import Water
from fe_engine.soil.elastic import moduli
from pysprings.model.fourier_mesh import CaissonSection
from pysprings.model.mesh import SURFACES, CaissonMesh
from pysprings.scene.model import Scene

# An undrained path lasts this share of the time in which water crosses the smallest cell: nothing flows.
_UNDRAINED = 1.0e-6
_BELOW = 1.0e-6  # m: the soil below a horizontal surface is that of this depth below it


def make_water(scene: Scene, caisson: CaissonMesh, stations: Stations) -> tuple[Water | None, np.ndarray]:
    """Return the water of the scene, and the mesh node of each film node; None and no film where it is drained."""
    if scene.drainage.mode == "drained":
        return None, np.zeros(0, dtype=np.int64)
    mesh, drainage = caisson.mesh, scene.drainage
    film_mesh_node, film = _film(scene, mesh, stations)
    fixed = _drained_nodes(scene, caisson)
    depth = _depths(scene, mesh)
    bulk, shear = _moduli(scene, depth)
    wet = _wet(scene, depth)
    outside = np.isin(np.arange(film.n_nodes), film.faces[film.area.any(axis=1)], invert=True)  # no face has a film
    diagonal = np.linalg.norm(mesh.nodes[mesh.hexes[:, 6]] - mesh.nodes[mesh.hexes[:, 0]], axis=1)
    water = Water(
        mobility=mobility(scene, depth),
        storage=_storage(scene),
        stabilisation=drainage.stabilisation * biot.projection_factor(bulk, shear),
        fixed=np.concatenate([fixed, fixed[film_mesh_node] | outside]),
        initial=np.zeros(mesh.n_nodes + film.n_nodes),
        scale=float(np.median(shear if wet is None else shear[wet])) / float(np.median(diagonal)),
        film=film,
        wet=wet,
    )
    return water, film_mesh_node


def beside_steel(water: Water, n: int, k: int) -> Water:
    """Return the water of a model whose n nodes are followed by k of impervious steel, which hold no pressure."""
    return replace(
        water,
        fixed=np.insert(water.fixed, n, np.ones(k, dtype=bool)),
        initial=np.insert(water.initial, n, np.zeros(k)),
        film=None if water.film is None else replace(water.film, sealed=True),
    )


def make_series_water(
    scene: Scene, section: CaissonSection, stations: RingStations, harmonics: int, whole: bool = False
) -> SeriesWater | None:
    """Return the water of the scene on a section, around half a circle or the whole one; None where it is drained."""
    if scene.drainage.mode == "drained":
        return None
    mesh, depth = section.mesh, _depths(scene, section.mesh)
    film = _ring_film(scene, section, stations, elements.span(whole))
    edge = mesh.nodes[mesh.quads[:, 2]] - mesh.nodes[mesh.quads[:, 0]]
    fixed = drained_corners(scene, section)
    fixed = np.concatenate([fixed, fixed_film(scene, section, fixed)])
    wet, shear = _wet(scene, depth), _moduli(scene, depth)[1]
    return SeriesWater(
        mobility=mobility(scene, depth),
        storage=_storage(scene),
        fixed=fixed,
        initial=np.zeros((len(fixed), len(elements.numbers(harmonics, whole)))),
        scale=float(np.median(shear if wet is None else shear[wet]) / np.median(np.linalg.norm(edge, axis=1))),
        film=film,
        wet=wet,
    )


def _storage(scene: Scene) -> float:
    """Return the porosity over the bulk modulus of water, 1/Pa; 0 where it is incompressible."""
    modulus = scene.drainage.water_bulk_modulus
    return 0.0 if isinstance(modulus, str) else scene.drainage.porosity / modulus


def drained_corners(scene: Scene, section: CaissonSection) -> np.ndarray:
    """Return the corners (nc,) bool whose pressure is no unknown: see `_drained_nodes`.

    Where nothing drains only those of dry soil: a first layer below mudline would, however short the time.
    """
    mesh, node = section.mesh, section.mesh.corners
    rim = mesh.nodes[section.walls["outside"][0], 0]
    fixed = _without_pressure(scene, mesh.corner_numbers(mesh.quads[:, :4]), _depths(scene, section.mesh), len(node))
    if scene.drainage.mode == "undrained":
        return fixed
    fixed |= (mesh.nodes[node, 1] == 0.0) & (mesh.nodes[node, 0] > rim * (1.0 - 1e-9))
    if scene.domain.side_drainage == "drained":
        fixed |= np.isin(node, mesh.node_sets["side"])
    return fixed


def fixed_film(scene: Scene, section: CaissonSection, fixed: np.ndarray) -> np.ndarray:
    """Return the film nodes (nf,) bool whose pressure is no unknown, from the ``fixed`` (nc,) corners of the soil."""
    corner = film_corners(section)
    held = ~np.isin(corner, np.concatenate([piece[:, ::2].ravel() for piece in _wet_pieces(scene, section).values()]))
    return np.asarray(held | fixed[section.mesh.corner_numbers(corner)])


def _wet_pieces(scene: Scene, section: CaissonSection) -> dict[str, np.ndarray]:
    """Return the pieces of every line of the section with water beside them: nodes (k, 3), corners at the ends."""
    wet = {}
    for name, line in section.lines.items():
        pieces = np.stack([line[:-2:2], line[1:-1:2], line[2::2]], axis=1)
        wet[name] = pieces[_beside_water(scene, name, section.mesh.nodes[pieces[:, 1], 1])]
    return wet


def film_corners(section: CaissonSection) -> np.ndarray:
    """Return the corners (nf,) of the section's faces, ascending: the nodes of the film."""
    return np.unique(np.concatenate([line[::2] for line in section.lines.values()]))


def _ring_film(scene: Scene, section: CaissonSection, stations: RingStations, span: float) -> RingFilm:
    """Return one film from mudline outside round the tip to the lid, through the angle ``span`` (rad).

    Its nodes are corners of the section. Pieces of it beside soil that holds no water have no film.
    """
    mesh, lines, wet = section.mesh, section.lines, _wet_pieces(scene, section)
    corner = film_corners(section)
    number = np.full(mesh.n_nodes, -1)
    number[corner] = np.arange(len(corner))
    nodes, wetted = np.full((len(stations), 2), -1), np.empty(len(stations))
    parts = []
    for code, name in enumerate(SURFACES):
        line, mine = lines[name], stations.surface == code
        place = np.full(mesh.n_nodes, -1)
        place[line] = np.arange(len(line))
        at = place[stations.nodes[mine, 0]]
        nodes[mine] = number[np.stack([line[at - at % 2], line[at + at % 2]], axis=1)]
        wetted[mine] = _wet_share(mesh, line, wet[name])[at]
        parts.append(_flow_points(mesh, wet[name], np.flatnonzero(mine), place, stations, span))
    ends, station, slope, over_radius, area = (np.concatenate(part) for part in zip(*parts, strict=True))
    return RingFilm(
        soil=mesh.corner_numbers(corner),
        nodes=nodes,
        weight=np.full((len(stations), 2), 0.5),
        station=station,
        ends=number[ends],
        slope=slope,
        over_radius=over_radius,
        area=area,
        residual_aperture=scene.interface.residual_aperture,
        transfer=scene.interface.transversal_conductivity,
        viscosity=scene.drainage.water_viscosity,
        wetted=None if wetted.all() and np.ptp(wetted) == 0.0 else wetted,
    )


def _wet_share(mesh: SectionMesh, line: np.ndarray, pieces: np.ndarray) -> np.ndarray:
    """Return the share (n,) of each node of a line in its pieces (k, 3) with water, by their lengths."""
    length = np.linalg.norm(mesh.nodes[line[2::2]] - mesh.nodes[line[:-2:2]], axis=1)
    held = length * np.isin(line[1::2], pieces[:, 1])
    share = np.empty(len(line))
    share[1::2] = held / length
    share[::2] = np.append(held, 0.0) + np.insert(held, 0, 0.0)
    share[::2] /= np.append(length, 0.0) + np.insert(length, 0, 0.0)
    return share


def _flow_points(
    mesh: SectionMesh, pieces: np.ndarray, mine: np.ndarray, place: np.ndarray, stations: RingStations, span: float
) -> tuple[np.ndarray, ...]:
    """Return the points of the film along pieces (m, 3) of a line: on its nodes (Simpson), at every station's azimuth.

    ``mine`` (k,) are the stations of the line, ``place`` (n,) are the places of nodes in it. A node without stations,
    as at the corners of the tip, has the gap of the next one that has some; on the axis nothing flows.
    """
    azimuths, at = np.unique(stations.azimuth), place[stations.nodes[mine, 0]]
    of_place = {place: mine[at == place] for place in np.unique(at)}
    held = np.array(sorted(of_place))
    ends, station, slope, over_radius, area = [], [], [], [], []
    for piece in pieces:
        first, a, b = place[piece[0]], piece[0], piece[2]
        length = float(np.linalg.norm(mesh.nodes[b] - mesh.nodes[a]))
        for i, weight in enumerate((1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0)):
            radius = float(mesh.nodes[piece[i], 0])
            if radius == 0.0:
                continue
            nearest = held[np.argmin(np.abs(held - first - i))]
            share = np.array([1.0 - 0.5 * i, 0.5 * i])
            for each in of_place[nearest]:
                ends.append((a, b))
                station.append(each)
                slope.append((-1.0 / length, 1.0 / length))
                over_radius.append(share / radius)
                area.append(weight * length * radius * span / len(azimuths))
    shapes = (2,), (), (2,), (2,), ()
    parts = zip((ends, station, slope, over_radius, area), shapes, (int, int, float, float, float), strict=True)
    return tuple(np.array(values, dtype=kind).reshape(-1, *shape) for values, shape, kind in parts)


def mobility(scene: Scene, depth: np.ndarray) -> np.ndarray:
    """Return the hydraulic conductivity over the unit weight of water, m2/(Pa s), at depths (...,) in m."""
    return scene.ground.value("hydraulic_conductivity", depth) / scene.drainage.water_unit_weight


def _depths(scene: Scene, mesh: Mesh | SectionMesh) -> np.ndarray:
    """Return depths (ne,) m of the centres of the elements; one depth, (), where the ground is the same everywhere."""
    if scene.ground.is_uniform:
        return np.array(0.0)
    return np.asarray(mesh.nodes[_corners_of(mesh)].mean(axis=1)[:, -1])


def _corners_of(mesh: Mesh | SectionMesh) -> np.ndarray:
    """Return the corners (ne, k) of the elements."""
    return mesh.quads[:, :4] if isinstance(mesh, SectionMesh) else mesh.hexes


def _moduli(scene: Scene, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return K and G in Pa at depths (...,) in m."""
    ground = scene.ground
    bulk, shear = moduli(ground.value("young_modulus", depth), ground.value("poisson_ratio", depth))
    return np.asarray(bulk), np.asarray(shear)


def undrained_time(scene: Scene, mesh: Mesh | SectionMesh) -> float:
    """Return the time of an undrained path, s: a millionth of h2/c_v, with the shortest edge h and the largest c_v.

    c_v = k M/gamma_w, M = K + 4 G/3.
    """
    depth = np.unique(mesh.nodes[:, -1])
    wet = scene.ground.holds_water(depth, scene.drainage.mode)
    depth = depth[wet] if wet.any() else depth  # a drained scene does not use it
    bulk, shear = _moduli(scene, depth)
    consolidation = float(np.max(mobility(scene, depth) * (bulk + 4.0 * shear / 3.0)))
    return _UNDRAINED * mesh.shortest_edge() ** 2 / consolidation


def mudline_time(scene: Scene, mesh: Mesh | SectionMesh) -> float:
    """Return the time in which water crosses the first element below mudline, s: h2/c_v with its height h; 0 if dry."""
    depth = mesh.nodes[_corners_of(mesh), -1]
    top = np.array(0.5 * depth[depth > 0.0].min())
    if not scene.ground.holds_water(top, scene.drainage.mode):
        return 0.0
    bulk, shear = _moduli(scene, top)
    return float((2.0 * top) ** 2 / (mobility(scene, top) * (bulk + 4.0 * shear / 3.0)))


def _drained_nodes(scene: Scene, caisson: CaissonMesh) -> np.ndarray:
    """Return nodes (n,) bool without unknown pressure: mudline outside the caisson, a side that drains, dry soil."""
    mesh = caisson.mesh
    radius = np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1])
    rim = radius[caisson.walls["outside"][:, 0]].min()
    fixed: np.ndarray = (mesh.nodes[:, 2] == 0.0) & (radius > rim * (1.0 - 1e-9))
    if scene.domain.side_drainage == "drained":
        fixed[mesh.node_sets["side"]] = True
    return fixed | _without_pressure(scene, mesh.hexes, _depths(scene, mesh), mesh.n_nodes)


def _without_pressure(scene: Scene, elements: np.ndarray, depth: np.ndarray, n: int) -> np.ndarray:
    """Return nodes (n,) bool of elements (ne, k) at depths (ne,) m of which none holds water.

    In a coupled scene the nodes of drained layers, too: these drain what lies beside them.
    """
    fixed, wet = np.zeros(n, dtype=bool), _wet(scene, depth)
    if wet is None:
        return fixed
    fixed[:] = True
    fixed[elements[wet]] = False
    if scene.drainage.mode == "coupled":
        fixed[elements[~wet & ~scene.ground.in_total_stress(depth)]] = True
    return fixed


def _wet(scene: Scene, depth: np.ndarray) -> np.ndarray | None:
    """Return whether elements with centres at depths (ne,) m hold water; None where all do."""
    wet = scene.ground.holds_water(depth, scene.drainage.mode)
    return None if np.all(wet) else wet


def _beside_water(scene: Scene, surface: str, depth: np.ndarray) -> np.ndarray:
    """Return whether the soil beside pieces of a surface at depths (k,) m holds water; that below lid and tip."""
    below = _BELOW if surface in ("lid", "tip") else 0.0
    return scene.ground.holds_water(depth + below, scene.drainage.mode)


def _film(scene: Scene, mesh: Mesh, stations: Stations) -> tuple[np.ndarray, Film]:
    """Return one film from mudline outside round the tip to the lid: mesh node of each film node, and the film.

    Faces beside soil that holds no water have no film.
    """
    faces = np.concatenate([mesh.face_sets[name] for name in SURFACES])
    surface = np.repeat(np.arange(len(SURFACES)), [len(mesh.face_sets[name]) for name in SURFACES])
    node = np.unique(faces)
    number = np.full(mesh.n_nodes, -1)
    number[node] = np.arange(len(node))
    gradient, area = interface.film_geometry(mesh.nodes[node], number[faces])
    middle = mesh.nodes[faces].mean(axis=1)[:, 2]
    wet = [_beside_water(scene, name, middle[surface == code]) for code, name in enumerate(SURFACES)]
    beside = np.concatenate(wet)
    area[~beside] = 0.0
    film = Film(
        n_nodes=len(node),
        nodes=number[stations.nodes],
        weight=stations.weight,
        faces=number[faces],
        corners=_corners(faces, surface, stations),
        gradient=gradient,
        area=area,
        residual_aperture=scene.interface.residual_aperture,
        transfer=scene.interface.transversal_conductivity,
        viscosity=scene.drainage.water_viscosity,
        wetted=None if beside.all() else _wetted(mesh, faces, surface, beside, stations),
    )
    return node, film


def _wetted(mesh: Mesh, faces: np.ndarray, surface: np.ndarray, beside: np.ndarray, stations: Stations) -> np.ndarray:
    """Return the share (ns,) of each station's area on faces with water ``beside`` them, (m,) bool."""
    shares = np.empty(len(stations))
    for code in range(len(SURFACES)):
        whole, wet = faces[surface == code], faces[(surface == code) & beside]
        size, held = (np.linalg.norm(interface.nodal_area_vectors(mesh.nodes, each), axis=1) for each in (whole, wet))
        mine, of_face = stations.surface == code, {tuple(nodes) for nodes in wet}
        node = stations.nodes[mine]
        central = np.array([tuple(each) in of_face for each in node], dtype=float)
        nodal = held[node[:, 0]] / size[node[:, 0]]
        shares[mine] = np.where(stations.weight[mine, 0] < 1.0, central, nodal)
    return shares


def _corners(faces: np.ndarray, surface: np.ndarray, stations: Stations) -> np.ndarray:
    """Return the station (m, 4) of the gap at each corner of each face: the central one of the face or the node's."""
    central = stations.weight[:, 0] < 1.0
    of_face = {tuple(stations.nodes[k]): k for k in np.flatnonzero(central)}
    of_node = {(stations.surface[k], stations.nodes[k, 0]): k for k in np.flatnonzero(~central)}
    corners = []
    for nodes, on in zip(faces, surface, strict=True):
        own = of_face.get(tuple(nodes))
        corners.append([own] * 4 if own is not None else [of_node[on, node] for node in nodes])
    return np.array(corners)
