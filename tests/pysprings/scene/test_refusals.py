# SPDX-License-Identifier: MIT
# ruff: noqa: E501  (messages are compared whole, on one line)
"""Every refusal of a scene, once, with the exact message and place; hostile files end in messages."""

import os
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from pysprings.core.errors import UserInputError
from pysprings.scene.load import MAX_BYTES, load_scene
from pysprings.scene.model import Scene
from pysprings.scene.template import template_text
from tests.support import tiny

PULL = '[[path]]\nname = "a"\nkind = "pull"\nlateral_displacement = "20 mm"\n'


def problems(text: str, file: str | None = None) -> list[str]:
    """Return what is wrong with a scene text, without the common beginning."""
    with pytest.raises(UserInputError) as error:
        tiny.parsed(text, file)
    lines = str(error.value).split("\n")
    assert all(line.startswith("fatal: user input: ") for line in lines)
    assert all(line.isprintable() for line in lines)
    return [line.removeprefix("fatal: user input: ") for line in lines]


def test_the_form_of_the_contract() -> None:
    """Both example lines of the public contract: unknown key at the key, wrong value at the value."""
    text = "\n" * 8 + "soil.poisson_ratio = 0.6\n\n\n[interface]\nfriction_coeficient = 0.5\n"
    assert problems(text, "caisson.toml") == [
        "caisson.toml:9:22: soil.poisson_ratio: 0.6 is not in [0, 0.5)",
        "caisson.toml:13:1: interface.friction_coeficient: unknown key (did you mean 'friction_coefficient'?)",
    ]


_LONG = "{}: a key of more than 16 parts; no key of a scene has more than two"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # keys
        ("[sol]\n", "1:1: sol: unknown key (did you mean 'soil'?)"),
        ("a = 1\n", "1:1: a: unknown key"),
        ("paths = []\n", "1:1: paths: unknown key (did you mean 'path'?)"),
        ('[soil]\nlaw = "tresca"\n', "2:1: soil.law: unknown key (did you mean 'yield_surface'?)"),
        ('[[soil.layer]]\ntop = "0 m"\nyield_surface = "tresca"\n',
         "3:1: soil.layer[0].yield_surface: unknown key (did you mean 'law'?)"),
        ("[soil]\nfriction_coefficient = 0.5\n", "2:1: soil.friction_coefficient: unknown key (it belongs in [interface])"),
        ('K0 = 1\n', "1:1: K0: unknown key (it belongs in [soil])"),
        ('rate = "1 mm/s"\n', "1:1: rate: unknown key (it belongs in [[path]])"),
        ("[soil.x]\ny = 1\n", "1:1: soil.x: unknown key"),
        ('"\\u001b\\n.x" = 2\n', '1:1: "\\u001b\\n.x": unknown key'),
        # tables
        ("soil = 3\n", "1:8: soil: expected a table [soil]"),
        ("[[soil]]\nK0 = 1\n", "1:1: soil: expected a table [soil]"),
        ("path = 3\n", "1:8: path: expected [[path]] sections (double brackets)"),
        ('[path]\nname = "a"\n', "1:1: path: expected [[path]] sections (double brackets)"),
        ("path = [3]\n", "1:9: path[0]: expected a table [[path]]"),
        # a fan
        ('[springs]\nreach = "20 mm"\nvertical_loads = ["2 MN", "2 m"]\n',
         '3:27: springs.vertical_loads[1]: "2 m" is a length; expected a force such as "4 MN"'),
        ('[caisson]\nvertical_load = "2 MN"\n[springs]\nreach = "20 mm"\nvertical_loads = ["3 MN", "2000.1 kN"]\n',
         "5:27: springs.vertical_loads[1]: 2.0001 MN is given twice (that of [caisson] counts): its paths would run twice"),
        ('[springs]\nreach = "15 m"\n', '2:9: springs.reach: "15 m" is not in [1e-6, 1e4] mm'),
        ('[springs]\nreach = "9 m"\n',
         "2:9: springs.reach: 9000 mm must be at most half of skirt_length (2000 mm)"),
        ('[springs]\nreach = "20 mm"\nrays = ["10 deg", "0 deg", "10 deg"]\n',
         "3:28: springs.rays[2]: 10 deg is given twice: its paths would run twice"),
        ('[springs]\nreach = "20 mm"\nrays = ["90 deg", "-90 deg"]\n',
         '3:19: springs.rays[1]: "-90 deg" is not in (-90, 90] deg'),
        ('[springs]\nreach = "20 mm"\nrates = ["100 m/s"]\n', '3:10: springs.rates[0]: "100 m/s" is not in [1e-9, 1e4] mm/s'),
        ('[springs]\nreach = "20 mm"\n[drainage]\nmode = "coupled"\n',
         '2:9: springs.rates: drainage.mode = "coupled" needs them, such as ["0.05 mm/s"]'),
        # a series
        ('[mesh]\nazimuth = 12\ndiscretisation = "fourier"\n', "2:11: mesh.azimuth: counts bricks; a series has mesh.harmonics"),
        ("[mesh]\nharmonics = 3\ndiscretisation = 'hex8'\n", '2:13: mesh.harmonics: are those of discretisation = "fourier"'),
        ("[mesh]\nhalvings = 1\ndiscretisation = 'hex8'\n", '2:12: mesh.halvings: are those of discretisation = "fourier"'),
        ('[mesh]\ndiscretisation = "fourier"\n[drainage]\nstabilisation = 0.5\n',
         "4:17: drainage.stabilisation: is one of bricks; pressures of a series need none"),
        # paths and layers
        ('[[path]]\nname = "a"\nkind = "vertical"\nvertical_displacement = "1 mm"\nheave = "fixed"\n',
         '5:9: path[0].heave: a path of kind "vertical" moves the caisson up or down'),
        (PULL + 'rate = "1 mm/s"\nduration = "1 s"\n', "6:12: path[0].duration: give rate or duration, not both"),
        ('[[soil.layer]]\ntop = "0 m"\n[[soil.layer]]\ntop = "3 m"\n[[soil.layer]]\ntop = "2 m"\n',
         "6:7: soil.layer[2].top: 2 m must be below the top of the layer before (3 m)"),
        ('[[soil.layer]]\ntop = "1 m"\n', "2:7: soil.layer[0].top: 1 m: the first layer begins at mudline (0 m)"),
        ('[domain]\ndepth = "12 m"\n[[soil.layer]]\ntop = "0 m"\n[[soil.layer]]\ntop = "13 m"\n',
         "6:7: soil.layer[1].top: 13 m is not above the bottom of the domain (12 m)"),
        ("[solver]\nfirst_step_fraction = 0.5\nmax_step_fraction = 0.1\n",
         "2:23: solver.first_step_fraction: 0.5 must not be more than max_step_fraction (0.1)"),
        ('[solver]\nviscous_displacement = "0.1 mm"\n',
         "2:24: solver.viscous_displacement: 0.1 mm is more than 1e-05 of outer_diameter (0.078 mm): the overstress would "
         "carry load"),
        # quantities
        ("[soil]\nyoung_modulus = 200\n",
         '2:17: soil.young_modulus: expected a quantity with unit such as "200 MPa", got 200'),
        ('[soil]\nyoung_modulus = "200"\n',
         '2:17: soil.young_modulus: expected a quantity with unit such as "200 MPa", got "200"'),
        ('[soil]\nyoung_modulus = "200 kN"\n',
         '2:17: soil.young_modulus: "200 kN" is a force; expected a pressure or stress such as "200 MPa"'),
        ('[soil]\nyoung_modulus = "200 MPA"\n',
         '2:17: soil.young_modulus: "200 MPA": unknown unit "MPA" (did you mean "MPa"?)'),
        ('[soil]\nyoung_modulus = "200 mPa"\n', '2:17: soil.young_modulus: "200 mPa" is not in [0.001, 1e6] MPa'),
        ('[caisson]\nvertical_load = "5 mN"\n',
         '2:17: caisson.vertical_load: "5 mN" is 0.005 N: m is milli, M is mega'),
        ('[soil]\nyoung_modulus = "1e400 Pa"\n', '2:17: soil.young_modulus: "1e400 Pa" is not a finite number'),
        ('[soil]\nsurcharge = nan\n',
         '2:13: soil.surcharge: expected a quantity with unit such as "10 kPa", got nan'),
        ('[soil]\nsurcharge = true\n',
         '2:13: soil.surcharge: expected a quantity with unit such as "10 kPa", got true'),
        ('[soil]\nsurcharge = ["1 kPa"]\n',
         '2:13: soil.surcharge: expected a quantity with unit such as "10 kPa", got a list'),
        ('[soil]\nsurcharge = {a = 1}\n',
         '2:13: soil.surcharge: expected a quantity with unit such as "10 kPa", got a table'),
        ('[soil]\nsurcharge = 1979-05-27\n',
         '2:13: soil.surcharge: expected a quantity with unit such as "10 kPa", got 1979-05-27'),
        ('[caisson]\nskirt_length = "-4 m"\n', '2:16: caisson.skirt_length: "-4 m" is not in [0.01, 200] m'),
        ("[caisson]\nvertical_load = 3\n",
         '2:17: caisson.vertical_load: expected a quantity with unit such as "4 MN" (or "balanced"), got 3'),
        ('[caisson]\nvertical_load = "balance"\n',
         '2:17: caisson.vertical_load: expected a quantity with unit such as "4 MN", got "balance"; '
         '"balanced" is possible too'),
        # numbers, counts, words, flags, texts
        ("[soil]\nK0 = inf\n", "2:6: soil.K0: inf is not in [0.01, 10]"),
        ("[soil]\nK0 = nan\n", "2:6: soil.K0: nan is not in [0.01, 10]"),
        ('[soil]\nK0 = "1"\n', '2:6: soil.K0: expected a number without unit and quotes such as 0.5 (or "auto"), got "1"'),
        ("[soil]\nK0 = true\n", "2:6: soil.K0: expected a number without unit and quotes such as 0.5 (or \"auto\"), got true"),
        (f"[soil]\nK0 = {'1' * 400}\n", "2:6: soil.K0: a number with hundreds of digits is not in [0.01, 10]"),
        ("[mesh]\nazimuth = 9\n", "2:11: mesh.azimuth: 9 is not a multiple of 4"),
        ("[mesh]\nazimuth = 4\n", "2:11: mesh.azimuth: 4 is not in [8, 256]"),
        ("[mesh]\nazimuth = 8.0\n", "2:11: mesh.azimuth: expected a whole number such as 8, got 8.0"),
        ('[mesh]\npreset = "papers"\n',
         '2:10: mesh.preset: "papers" is not one of "coarse", "medium", "paper", "fine" (did you mean \'paper\'?)'),
        ("[mesh]\npreset = 3\n", '2:10: mesh.preset: expected one of "coarse", "medium", "paper", "fine", got 3'),
        ('[output]\nfigures = "yes"\n', '2:11: output.figures: expected true, false, "none", "report" or "all", got "yes"'),
        ("title = 3\n", "1:9: title: expected a text in quotes, got 3"),
        ('title = ""\n', '1:9: title: "" is not 1 to 200 characters on one line'),
        ('title = "a\\nb"\n', '1:9: title: "a\\nb" is not 1 to 200 characters on one line'),
        # known, but not there yet
        ('[solver]\nlinear = "mumps"\n',
         '2:10: solver.linear: "mumps" is not available yet; choose "auto" or "pardiso" or "rslab" or "superlu"'),
        # values that do not go together
        ('[caisson]\nskirt_thickness = "4 m"\n',
         "2:19: caisson.skirt_thickness: must be less than half of outer_diameter (7.8 m)"),
        ('[domain]\nradius = "3.95 m"\n',
         "2:10: domain.radius: 3.95 m must be more than 1.02 times the caisson's radius (3.9 m)"),
        ('[caisson]\nouter_diameter = "50 m"\n[domain]\nradius = "24 m"\n',
         "4:10: domain.radius: 24 m must be more than 1.02 times the caisson's radius (25 m)"),
        ('[domain]\ndepth = "4.05 m"\n',
         "2:9: domain.depth: 4.05 m must be more than 1.02 times caisson.skirt_length (4 m)"),
        ('[soil]\nfriction_angle_initial = "31 deg"\n',
         "2:26: soil.friction_angle_initial: 31 deg must not be more than friction_angle_final (30 deg)"),
        ('[soil]\ndilation_angle = "31 deg"\n',
         "2:18: soil.dilation_angle: 31 deg must not be more than friction_angle_final (30 deg)"),
        ("[soil]\nK0 = 0.5\n",
         "2:6: soil.K0: 0.5 puts the initial stress outside the initial yield surface (5 deg allows 0.840 to 1.204); "
         'friction_angle_initial = "19.48 deg" or "auto" holds it'),
        ('[soil]\nK0 = 0.5\ncohesion = "1 kPa"\n',
         "2:6: soil.K0: 0.5 puts the initial stress outside the initial yield surface (5 deg, cohesion 1 kPa); "
         'friction_angle_initial = "19.48 deg" or "auto" holds it'),
        ('[soil]\nsurcharge = "0 kPa"\neffective_unit_weight = "0 N/m^3"\n',
         "2:13: soil.surcharge: a soil without weight, surcharge and cohesion has no strength"),
        ("[solver]\nfirst_step_fraction = 0.5\nmax_step_fraction = 0.1\n",
         "2:23: solver.first_step_fraction: 0.5 must not be more than max_step_fraction (0.1)"),
        # water
        ('[drainage]\nmode = "wet"\n', '2:8: drainage.mode: "wet" is not one of "drained", "coupled", "undrained"'),
        ('[drainage]\nwater_bulk_modulus = "2.2"\n',
         '2:22: drainage.water_bulk_modulus: expected a quantity with unit such as "2.2 GPa", got "2.2"; '
         '"incompressible" is possible too'),
        ('[drainage]\nmode = "coupled"\n' + PULL,
         '3:1: path[0]: drainage.mode = "coupled" needs rate or duration here'),
        ('[drainage]\nmode = "coupled"\n' + PULL + 'duration = "1 s"\nrole = "held-back"\nthen = ["2 mm"]\n',
         '9:9: path[0].then[0]: drainage.mode = "coupled" needs a time: "... in 10 min" or "... at 0.05 mm/s"'),
        (PULL + 'duration = "1 s"\nrate = "1 mm/s"\n', "5:12: path[0].duration: give rate or duration, not both"),
        (PULL + 'then = ["rest 1 s"]\n',
         '5:8: path[0].then: springs are made from monotonic paths only: a path with `then` needs role = "held-back"'),
        (PULL + 'role = "held-back"\nthen = ["rest"]\n', '6:9: path[0].then[0]: a rest needs its time: "rest 2 hour"'),
        (PULL + 'role = "held-back"\nthen = ["2 mm at 3 s"]\n',
         '6:9: path[0].then[0]: "3 s" is a time; expected a velocity such as "0.05 mm/s"'),
        (PULL + 'role = "held-back"\nthen = [4]\n',
         '6:9: path[0].then[0]: expected a text such as "rest 2 hour", got 4'),
        (PULL + 'role = "held-back"\nthen = ["2 mm, 1 mrad"]\n',
         '6:9: path[0].then[0]: a path of kind "pull" goes on with one value, such as "20 mm"'),
        (PULL + 'role = "memory"\nthen = ["-2 mm"]\n',
         '5:8: path[0].role: role = "memory" is for a translation or rotation that turns back: '
         'then = ["-8 mm", "8 mm"]'),
        ('[[path]]\nname = "a"\nkind = "translation"\nlateral_displacement = "1 mm"\nrole = "memory"\n',
         '5:8: path[0].role: role = "memory" is for a translation or rotation that turns back: '
         'then = ["-8 mm", "8 mm"]'),
        ('[[path]]\nname = "a"\nkind = "swipe"\nlateral_displacement = "5 mm"\nrotation = "1 mrad"\n'
         'role = "held-back"\nthen = ["2 mm"]\n',
         '7:9: path[0].then[0]: a path of kind "swipe" goes on with u and rotation: "5 mm, 2 mrad"'),
        (PULL + 'then = "rest 1 s"\n',
         """5:8: path[0].then: expected a list such as ["rest 2 hour", "20 mm at 0.5 mm/s"], got "rest 1 s\""""),
        ('[[path]]\nname = "a"\nkind = "rotation"\nrotation = "1 deg"\nrole = "held-back"\nthen = ["2 deg at 1 mm/s"]\n',
         '6:9: path[0].then[0]: a path of kind "rotation" has no velocity: write "... in 10 min"'),
        # parts that change the vertical load
        (PULL + 'role = "held-back"\nthen = ["V 3"]\n',
         '6:9: path[0].then[0]: expected a quantity with unit such as "3 MN", got "3"'),
        (PULL + 'role = "held-back"\nthen = ["V 2e4 MN"]\n',
         '6:9: path[0].then[0]: "2e4 MN" is not in [-1e4, 1e4] MN'),
        (PULL + 'role = "held-back"\nthen = ["V balanced"]\n',
         '6:9: path[0].then[0]: expected a quantity with unit such as "3 MN", got "balanced"'),
        (PULL + 'role = "held-back"\nthen = ["V 3 MN, 1 MN"]\n',
         '6:9: path[0].then[0]: "3 MN, 1 MN": "MN, 1 MN" is not a unit'),
        (PULL + 'role = "held-back"\nthen = ["V 3 MN at 1 mm/s"]\n',
         '6:9: path[0].then[0]: a vertical load has no velocity: write "V 3 MN in 10 min"'),
        (PULL + 'role = "held-back"\nthen = ["V 3 MN in 2 MN"]\n',
         '6:9: path[0].then[0]: "2 MN" is a force; expected a time such as "2 hour"'),
        (PULL + 'role = "held-back"\nthen = ["1 mm", "V"]\n',
         '6:17: path[0].then[1]: a vertical load needs its value: "V 3 MN"'),
        (PULL + 'then = ["V 3 MN"]\n',
         '5:8: path[0].then: springs are made from monotonic paths only: a path with `then` needs role = "held-back"'),
        (PULL + 'role = "held-back"\nheave = "fixed"\nthen = ["V 3 MN"]\n',
         '7:9: path[0].then[0]: heave = "fixed" imposes w: it cannot have a vertical load'),
        ('[[path]]\nname = "a"\nkind = "vertical"\nvertical_displacement = "5 mm"\nrole = "held-back"\nthen = ["V 3 MN"]\n',
         '6:9: path[0].then[0]: a path of kind "vertical" imposes w: it cannot have a vertical load'),
        ('[[path]]\nname = "a"\nkind = "translation"\nlateral_displacement = "1 mm"\nrole = "memory"\n'
         'then = ["-1 mm", "V 3 MN"]\n',
         '6:18: path[0].then[1]: a path of role = "memory" that changes the vertical load needs [springs] vertical_loads, '
         'without rates; else give it role = "held-back"'),
        ('[springs]\nreach = "8 mm"\nvertical_loads = ["3 MN"]\nrates = ["1 mm/s"]\n[drainage]\nmode = "coupled"\n'
         '[[path]]\nname = "a"\nkind = "translation"\nlateral_displacement = "1 mm"\nrole = "memory"\nduration = "1 s"\n'
         'then = ["-1 mm in 1 s", "V 3 MN in 1 s"]\n',
         '13:25: path[0].then[1]: a path of role = "memory" that changes the vertical load needs [springs] vertical_loads, '
         'without rates; else give it role = "held-back"'),
        ('[drainage]\nmode = "coupled"\n' + PULL + 'duration = "1 s"\nrole = "held-back"\nthen = ["V 3 MN"]\n',
         '9:9: path[0].then[0]: drainage.mode = "coupled" needs a time: "V ... in 10 min"'),
        ('[drainage]\nmode = "coupled"\n[[path]]\nname = "a"\nkind = "swipe"\nlateral_displacement = "5 mm"\n'
         'rotation = "1 mrad"\nrole = "held-back"\n',
         '3:1: path[0]: drainage.mode = "coupled" needs rate here'),
        ('[[path]]\nname = "a"\nkind = "swipe"\nlateral_displacement = "5 mm"\nrole = "held-back"\n',
         '3:8: path[0].rotation: a path of kind "swipe" needs a rotation'),
        ('[[path]]\nname = "a"\nkind = "swipe"\nlateral_displacement = "5 mm"\nrotation = "1 mrad"\nduration = "1 s"\n',
         ['3:8: path[0].role: springs are made from paths of one direction only: a swipe needs role = "held-back"',
          '6:12: path[0].duration: a path of kind "swipe" does not use it']),
        ('[[path]]\nname = "a"\nkind = "probe"\nlateral_displacement = "5 mm"\narm = "2 m"\n',
         ['3:8: path[0].load_angle: a path of kind "probe" needs a load_angle',
          '3:8: path[0].role: springs are made from paths of one direction only: a probe needs role = "held-back"',
          '5:7: path[0].arm: a path of kind "probe" does not use it']),
        (PULL + 'load_angle = "0 deg"\n', '5:14: path[0].load_angle: a path of kind "pull" does not use it'),
        ('[[path]]\nname = "a"\nkind = "load"\nlateral_force = "1 MN"\narm_from = "0 m"\n',
         '5:12: path[0].role: springs are made from paths of one direction only: a load that climbs needs role = "held-back"'),
        (PULL + 'arm_from = "0 m"\n' + 'role = "held-back"\n',
         '5:12: path[0].arm_from: a path of kind "pull" does not use it'),
        # paths
        ('[[path]]\nkind = "pull"\nlateral_displacement = "1 mm"\n', "1:1: path[0].name: missing; every [[path]] needs it"),
        ('[[path]]\nname = "a"\n', "1:1: path[0].kind: missing; every [[path]] needs it"),
        (PULL.replace('"a"', '"1/a"'),
         '2:8: path[0].name: "1/a" is not a name (a letter, then letters, digits, _ or -, at most 60)'),
        (PULL + PULL.replace('"a"', '"A"'), "6:8: path[1].name: 'A' is the name of path[0] too (case does not count)"),
        ('[[path]]\nname = "a"\nkind = "pull"\n', '1:1: path[0]: a path of kind "pull" needs lateral_displacement'),
        ('[[path]]\nname = "a"\nkind = "rotation"\n', '1:1: path[0]: a path of kind "rotation" needs rotation'),
        ('[[path]]\nname = "a"\nkind = "load"\n', '1:1: path[0]: a path of kind "load" needs lateral_force'),
        (PULL.replace("20 mm", "0 mm"), "4:24: path[0].lateral_displacement: must not be zero"),
        (PULL + 'rotation = "1 deg"\n', '5:12: path[0].rotation: a path of kind "pull" does not use it'),
        (PULL + 'lateral_force = "1 MN"\n', '5:17: path[0].lateral_force: a path of kind "pull" does not use it'),
        (PULL.replace("pull", "translation") + 'arm = "1 m"\n',
         '5:7: path[0].arm: a path of kind "translation" does not use it'),
        ('[[path]]\nname = "a"\nkind = "rotation"\nrotation = "1 deg"\nrate = "1 mm/s"\n',
         '5:8: path[0].rate: a path of kind "rotation" does not use it'),
        (PULL + 'report_at = "3 mm"\n',
         '5:13: path[0].report_at: expected a list of quantities such as ["20 mm"], got "3 mm"'),
        (PULL + 'report_at = ["3 mm", 4]\n',
         '5:22: path[0].report_at[1]: expected a quantity with unit such as "20 mm", got 4'),
        (PULL + 'report_at = ["3 mm",\n  "4 kN"]\n',
         '6:3: path[0].report_at[1]: "4 kN" is a force; expected a length such as "20 mm"'),
        (PULL + 'report_at = ["21 mm"]\n',
         "5:14: path[0].report_at[0]: 21 mm is not on the way from 0 to lateral_displacement (20 mm)"),
        (PULL + 'report_at = ["3 mm", "2 mm"]\n',
         "5:22: path[0].report_at[1]: 2 mm must be further than the value before it (3 mm)"),
        # not TOML
        ("[soil]\nyoung_modulus = 200 MPa\n",
         '2:21: not valid TOML: Expected newline or end of document after a statement (a quantity needs quotes: "200 MPa")'),
        ("[soil\n", "1:6: not valid TOML: Expected ']' at the end of a table declaration"),
        ('a = "', "1:6: not valid TOML: Unterminated string"),
        (f"a = {'1' * 5000}\n",
         "1:1: not valid TOML: Exceeds the limit (4300 digits) for integer string conversion: value has 5000 digits"),
        ("", "the file is empty; `pysprings init` writes a commented scene"),
        ("# nothing\n", "the file is empty; `pysprings init` writes a commented scene"),
        ("a = " + "[" * 5000, "1:69: lists or tables are nested too deeply (more than 64 levels)"),
        ("a = " + "{b=" * 5000, "1:197: lists or tables are nested too deeply (more than 64 levels)"),
        ("[soil]\nK0 = 0.9\nx = {" + "a." * 1000 + "a = 1}", _LONG.format("3:6")),
        ("\n" + "a." * 20_000 + "a = 1", _LONG.format("2:1")),
        ("[[" + '"a" . ' * 20_000 + "a]]", _LONG.format("1:3")),
        ("x = {" + "a.a.a.a.a.a.a.a={" * 100 + "b=1" + "}" * 101,
         "1:141: lists or tables are nested too deeply (more than 64 levels)"),
    ],
    ids=lambda value: value.split(": ")[1][:40] if ": " in value and isinstance(value, str) else "",
)  # fmt: skip
def test_message(text: str, expected: str | list[str]) -> None:
    assert problems(text) == (expected if isinstance(expected, list) else [expected])


@pytest.mark.parametrize(
    ("law", "most", "words"),
    [("drucker-prager", 1.2039, "initial yield surface"), ("van-eekelen", 1.1909, "allows 0.840 to 1.191")],
)
def test_k0_range_in_the_message_is_where_the_refusal_begins(law: str, most: float, words: str) -> None:
    """At 5 deg |1 - K0|/sqrt(3) = m (1 + 2 K0) at 0.83966 and 1.20393; (1 - sin phi)/(1 + sin phi) 0.83966, 1/1.19096."""
    text = f'[soil]\nyield_surface = "{law}"\nK0 = '
    for inside in (0.8397, most):
        assert tiny.parsed(f"{text}{inside}\n").model_dump()["soil"]["K0"] == inside
    for outside in (0.8396, most + 1e-4):
        assert words in problems(f"{text}{outside}\n")[0]


def test_everything_at_once_in_the_order_of_the_file() -> None:
    """Wrong keys, wrong values and clashes among the right ones; nothing that follows only from another fault."""
    text = (
        'title = "t"\n'
        "[caisson]\n"
        'skirt_lenght = "20 m"\n'  # not also: the domain is too shallow
        "[soil]\n"
        'friction_angle_initial = "35 deg"\n'
        "poisson_ratio = 0.6\n"
        "[solver]\n"
        "first_step_fraction = 0.5\n"
        "max_step_fraction = 0.1\n"
        "[domain]\n"
        'radius = "3 m"\n'
        "[[path]]\n"
        'name = "a"\n'
        'kind = "pull"\n'
        'lateral_displacment = "3 mm"\n'  # not also: needs lateral_displacement
        "[[path]]\n"
        'name = "b"\n'
        'kind = "rot"\n'  # not also: uses arm
        'arm = "3 m"\n'
        "[[path]]\n"
        'name = "A"\n'
        'kind = "load"\n'
        'lateral_force = "0 N"\n'
    )
    keys = [problem.split(": ")[1] for problem in problems(text, "c.toml")]
    assert keys == [
        "caisson.skirt_lenght",
        "soil.friction_angle_initial",
        "soil.poisson_ratio",
        "solver.first_step_fraction",
        "domain.radius",
        "path[0].lateral_displacment",
        "path[1].kind",
        "path[2].name",
        "path[2].lateral_force",
    ]


def test_problems_are_data_too() -> None:
    (problem,) = tiny.problems(tiny.parsed, "[soil]\nK0 = -1\n", "c.toml")
    assert (problem.file, problem.line, problem.col, problem.key) == ("c.toml", 2, 6, "soil.K0")
    assert problem.message == "-1 is not in [0.01, 10]"


# --- files ---


def refusal(path: Path | str) -> str:
    with pytest.raises(UserInputError) as error:
        load_scene(path)
    return str(error.value)


def test_missing_file(tmp_path: Path) -> None:
    assert refusal(tmp_path / "no.toml") == f"fatal: user input: {tmp_path}/no.toml: no such file"


def test_folder(tmp_path: Path) -> None:
    assert refusal(tmp_path) == f"fatal: user input: {tmp_path}: is a folder, not a scene file"


def test_device() -> None:
    assert refusal(os.devnull).endswith("is not a regular file")


def test_name_with_null_character() -> None:
    assert refusal("a\0b").startswith("fatal: user input: a\\x00b: cannot be read")


def test_name_that_is_too_long() -> None:
    assert "cannot be read (File name too long)" in refusal("a" * 5000)


def test_file_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert "cannot be read (Not a directory)" in refusal(tmp_path / "file" / "scene.toml")


def test_huge_file(tmp_path: Path) -> None:
    (tmp_path / "big.toml").write_bytes(b"#" * (MAX_BYTES + 1))
    assert "is too large for a scene (more than 256 KiB)" in refusal(tmp_path / "big.toml")


def test_not_utf8(tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes('title = "a"\n# 30 °\n'.encode("latin-1"))
    assert refusal(tmp_path / "latin.toml").endswith("latin.toml:2:6: is not UTF-8 text (byte 0xb0)")


def test_utf16(tmp_path: Path) -> None:
    (tmp_path / "wide.toml").write_text('title = "a"\n', encoding="utf-16")
    assert "1:1: is not UTF-8 text" in refusal(tmp_path / "wide.toml")


# --- hostile files ---

NASTY = st.sampled_from(
    [
        "nan", "inf", "-1", "0", "1e999", "true", '""', '"x"', '"9**9**9 m"', '"1e400 Pa"', '"5 degC"', "[]", "{}",
        '"balanced"', '["1 mm", 2]', "1979-05-27", "'200 MPa", '"\\u0000"', '"\\u202e m"', "0x10", '"-0 m"', "[[", "]",
        '"1 m/(Pa s"', "[{a = 1}]", '"""', "#", "=", ".", '"rotation"', '"load"', '"1 rad"', '"1e-300 m"',
    ]
)  # fmt: skip


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """Draw the template with a few lines damaged."""
    lines = template_text("paper-drained").split("\n")
    for _ in range(draw(st.integers(1, 6))):
        at = draw(st.integers(0, len(lines) - 1))
        how = draw(st.sampled_from(["value", "value", "value", "key", "drop", "twice", "swap", "text"]))
        key, equals, _ = lines[at].partition("=")
        if how == "value" and equals:
            lines[at] = f"{key}= {draw(NASTY)}"
        elif how == "key" and equals:
            lines[at] = draw(st.sampled_from(["x", "a.b", '"K 0"', "path", "soil.K0", "kind"])) + lines[at][len(key) :]
        elif how == "drop":
            del lines[at]
        elif how == "twice":
            lines.insert(at, lines[at])
        elif how == "swap":
            other = draw(st.integers(0, len(lines) - 1))
            lines[at], lines[other] = lines[other], lines[at]
        elif how == "text":
            where = draw(st.integers(0, len(lines[at])))
            lines[at] = lines[at][:where] + draw(st.text(max_size=3)) + lines[at][where:]
    return "\n".join(lines)


@settings(deadline=None, max_examples=300)
@given(mutated())
def test_damaged_scenes_end_in_a_scene_or_in_messages(text: str) -> None:
    try:
        assert isinstance(tiny.parsed(text, "c.toml"), Scene)
    except UserInputError as error:
        assert error.problems
        for problem in error.problems:
            assert problem.message
            assert str(problem).isprintable()
            assert problem.line is None or 1 <= problem.line <= text.count("\n") + 1
