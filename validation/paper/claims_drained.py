# SPDX-License-Identifier: MIT
"""The paper's claims about the drained pull, measured (1 to 7)."""

import numpy as np
import xarray as xr

from validation.paper import measures as m
from validation.paper.cases import DEPTHS, END, SHOWN
from validation.paper.findings import Finding, Paths, at_depths, every, joined, mm, which, within

_OPEN = 1e-9  # of the initial stress


def slope_change(paths: Paths) -> Finding:
    """Judge the load-displacement curve: where it bends, and whether it is straight before."""
    path = paths["drained"]
    place, sharpness = m.load_bend(path)
    share = m.secant_share(path, 1e-3)
    ratio = m.slope_ratio(path)
    figure = (
        f"tangent at 0.3 mm {ratio:.1f} times that at 3 mm; secant at 1 mm {100 * share:.0f} % of that at 0.1 mm; "
        f"sharpest bend at {1e3 * place:.1f} mm, where the tangent falls by {sharpness:.1f} % a per cent of u"
    )
    bends = every((within(1e3 * place, 1.0, 3.0), within(sharpness, 1.0, np.inf)))
    holds = (bends, within(share, 0.8, 1.2))
    reason = "" if all(holds) else "the sand yields from the start (phi_i 5 deg): the curve bends smoothly"
    return Finding(figure, holds, reason)


def front_stress(paths: Paths) -> Finding:
    """Judge the normal effective stress in front."""
    ratio = m.stress_ratio(paths["drained"], SHOWN, m.FRONT, DEPTHS)
    holds = [within(value, 1.25, 1.75) for value in ratio]
    reason = "" if all(holds) else "larger near the mudline, where the initial stress is small"
    return Finding(f"{joined(ratio)} times initial {at_depths()}", holds, reason)


def rear_gap(paths: Paths) -> Finding:
    """Judge stress, opening and shear behind."""
    path = paths["drained"]
    back = m.stress_ratio(path, SHOWN, m.BACK, DEPTHS)
    gap = m.rear_gap(path, END)
    top, bottom = gap[path["depth"].values <= 2.0].max(), gap[path["depth"].values > 2.0].max()
    share = m.open_share(path, SHOWN)
    figure = (
        f"back p'_N {joined(back)} times initial {at_depths()}, {100 * share:.0f} % of the back line open at 2.5 mm; "
        f"at 20 mm widest opening {mm(top)} above and {mm(bottom)} below half the skirt"
    )
    lateral, down = (np.abs(m.field(path, name, SHOWN, m.BACK)) for name in ("shear_lateral", "shear_vertical"))
    shear = float(np.interp(DEPTHS[0], path["depth"].values, np.hypot(lateral, down)))
    holds = (
        within(back[0], -1.0, _OPEN), bool(top > bottom) if np.isfinite(top) else None, within(1e-3 * shear, 0.0, 0.01),
    )  # fmt: skip
    reason = ""
    if not all(item is True for item in holds):
        reason = (
            "the yielding sand follows the caisson: contact is kept, at less stress; see the sensitivities for the "
            "readings with a gap"
        )
    return Finding(f"{figure}; shear behind at {DEPTHS[0]:g} m {1e-3 * shear:.2g} kPa", holds, reason)


def lateral_shear(paths: Paths) -> Finding:
    """Judge the lateral shear around the skirt."""
    path = paths["drained"]
    shear = m.at(path[["shear_lateral", "u"]].sel(side="outside").transpose("step", "azimuth", "depth"),
                 "shear_lateral", SHOWN)  # fmt: skip
    azimuth, depth = path["azimuth"].values, path["depth"].values
    rings = np.array([m.by_depth(depth, shear[k], DEPTHS) for k in range(len(azimuth))])
    front = np.abs(rings[0]) / np.abs(rings).max(axis=0)
    sixty = np.array([np.interp(np.pi / 3.0, azimuth, ring) for ring in rings.T])
    thirty = np.array([np.interp(np.pi / 6.0, azimuth, ring) for ring in rings.T])
    grows = bool((np.abs(sixty) > np.abs(thirty)).all() and (np.abs(thirty) > np.abs(rings[0])).all())
    figure = (
        f"outside, at 2.5 mm: front {joined(100 * front, '.0f')} % of the ring's largest {at_depths()}; 30 deg "
        f"{joined(1e-3 * thirty, '.1f')} kPa, 60 deg {joined(1e-3 * sixty, '.1f')} kPa"
    )
    if not np.isfinite(front).all():
        return Finding(figure, (None,))
    return Finding(figure, (bool((front < 0.05).all()), grows))


def vertical_shear(paths: Paths) -> Finding:
    """Judge the vertical shear in front and behind, inside and outside, and its late change."""
    path = paths["drained"]
    front = m.by_depth(path["depth"].values, m.field(path, "shear_vertical", SHOWN, m.FRONT), DEPTHS).mean()
    back = m.by_depth(path["depth"].values, m.field(path, "shear_vertical", SHOWN, m.BACK), DEPTHS).mean()
    inside, outside = (float(m.at(path, name, END)) for name in ("F_in", "F_out"))
    change = [_late_change(path, name) for name in ("F_in", "F_out")]
    figure = (
        f"on the soil at 2.5 mm, outside: {1e-3 * front:.1f} kPa in front, {1e-3 * back:.1f} kPa behind (down +); at "
        f"20 mm F_in {1e-3 * inside:.0f} kN, F_out {1e-3 * outside:.0f} kN; change from 15 to 20 mm "
        f"{joined(100 * np.array(change), '.0f')} % of the largest"
    )
    if not np.isfinite([front, back, inside, outside, *change]).all():
        return Finding(figure, (None,))
    # on the caisson up in front and down behind: on the soil the other way round
    holds = (front > 0.0 > back, abs(inside - outside) > 0.2 * max(abs(inside), abs(outside)), max(change) < 0.1)
    reason = "" if all(holds) else which(holds, ("not opposite in front and behind", "not different", "no plateau"))
    return Finding(figure, tuple(bool(item) for item in holds), reason)


def _late_change(path: xr.Dataset, name: str) -> float:
    """Return the change of a force from 15 mm to 20 mm over its largest value on the path."""
    largest = float(np.abs(path[name].values).max())
    return abs(float(m.at(path, name, END) - m.at(path, name, 15e-3))) / largest if largest else 0.0


def base(paths: Paths) -> Finding:
    """Judge base shear, plug, and the motion of the caisson."""
    path = paths["drained"]
    if "section_ux" not in path:
        return Finding("needs the symmetry plane", (None,))
    lid, tip, load = (float(m.at(path, name, END)) for name in ("H_lid", "H_tip", "H"))
    growing = m.tangent(path, 16e-3) * END / load
    rotation, sink = float(m.at(path, "rotation", SHOWN)), float(m.at(path, "w", SHOWN))
    length = float(path["depth_bounds"].values.max())
    follows = plug_motion(path)
    figure = (
        f"tip and lid carry {100 * (tip + lid) / load:.0f} % of H at 20 mm, where the load still grows by "
        f"{100 * growing:.0f} % a doubling of u; plug moves {joined([follows])} times the caisson; at 2.5 mm "
        f"rotation*L/u {rotation * length / SHOWN:.2f}, vertical {-1e3 * sink:.2f} mm (up +)"
    )
    if not np.isfinite([growing, rotation, sink, follows]).all():
        return Finding(figure, (None,))
    moves = rotation > 0.0 and abs(sink) < 0.5 * SHOWN
    return Finding(figure, (growing > 0.02, 0.8 <= follows <= 1.2, bool(moves)))


def plug_motion(path: xr.Dataset, u: float = SHOWN) -> float:
    """Return the lateral motion of the plug on the axis over that of the caisson, fitted over the skirt."""
    x, depth = path["section_x"].values, path["section_depth"].values
    length = float(path["depth_bounds"].values.max())
    axis = np.flatnonzero((np.abs(x) < 1e-6 * np.abs(x).max()) & (depth <= length + 1e-6))
    order = axis[np.argsort(depth[axis])]
    soil = m.at(path, "section_ux", u)[order]
    caisson = float(m.at(path, "u", u)) - float(m.at(path, "rotation", u)) * depth[order]
    weight = np.gradient(depth[order])
    return float((soil * caisson * weight).sum() / (caisson**2 * weight).sum())


def wedge(paths: Paths) -> Finding:
    """Judge motion and stress of the soil in front."""
    path = paths["drained"]
    if "section_ux" not in path:
        return Finding("needs the symmetry plane", (None,))
    radius = _outer_radius(path)
    shift = [front_motion(path, radius, depth) for depth in (0.25, 2.0, 4.0)]
    lift = front_heave(path, radius)
    figure = (
        f"soil 1 m in front of the skirt at 2.5 mm moves {joined(1e3 * np.array(shift))} mm at 0.25, 2 and 4 m depth; "
        f"the surface there rises by up to {1e3 * lift:.2f} mm within 4 m"
    )
    if not np.isfinite([*shift, lift]).all():
        return Finding(figure, (None,))
    ratio = m.stress_ratio(path, SHOWN, m.FRONT, DEPTHS)
    return Finding(f"{figure}; front stress over initial {ratio[0]:.1f} at 0.25 m, {ratio[-1]:.1f} at 3.25 m",
                   (shift[0] > shift[1] > shift[2], lift > 0.0, bool(ratio[0] > ratio[-1])))  # fmt: skip


def _outer_radius(path: xr.Dataset) -> float:
    return 0.5 * float(path.attrs["outer_diameter_m"])


def front_motion(path: xr.Dataset, radius: float, depth: float, u: float = SHOWN, ahead: float = 1.0) -> float:
    """Return the lateral motion [m] of the soil at a distance [m] ahead of the skirt and a depth [m].

    In front of the skirt the nodes stand in layers of equal depth: linear in each, and between them.
    """
    x, layer = path["section_x"].values, np.round(path["section_depth"].values, 9)
    front = x >= radius - 1e-6
    x, layer, values = x[front], layer[front], m.at(path, "section_ux", u)[front]
    depths, motion = np.unique(layer), []
    for each in depths:
        order = np.flatnonzero(layer == each)[np.argsort(x[layer == each])]
        motion.append(np.interp(radius + ahead, x[order], values[order]))
    return float(np.interp(depth, depths, motion))


def front_heave(path: xr.Dataset, radius: float, u: float = SHOWN, reach: float = 4.0) -> float:
    """Return the largest rise [m] of the mudline in front of the skirt within a reach [m]."""
    x, depth = path["section_x"].values, path["section_depth"].values
    near = (depth <= 1e-9) & (x >= radius - 1e-6) & (x <= radius + reach)
    return float((-m.at(path, "section_uz", u)[near]).max())
