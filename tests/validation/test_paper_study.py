# SPDX-License-Identifier: MIT
"""The study of the paper on tiny runs: what has ended stays, what was interrupted goes on, a part is said to be one."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from fe_engine.solve import step_size
from fe_engine.solve.newton import Newton
from pysprings.core.storage import read_tree
from pysprings.core.written import is_unfinished
from pysprings.full_model.run_record import RunRecord
from pysprings.results import folder
from pysprings.scene.sections import PAPER_SOIL
from pysprings.studies import stored_runs
from validation.paper import cases, claims, figures, idealisations, page, runs, sensitivity, study, text
from validation.paper.__main__ import paper
from validation.paper.cases import Case, Variant
from validation.paper.findings import UNKNOWN

TINY: dict[str, Any] = {
    "mesh": {"refinement": 0.4},
    "solver": {"first_step_fraction": 0.1, "max_step_fraction": 0.5},
    "output": {"figures": False},
}
END = 3e-3


def tiny(case: Case) -> Case:
    return replace(case, changes={**case.changes, **TINY}, end=END, stops_mm=(2.5,))


@pytest.fixture
def two() -> tuple[Case, ...]:
    return tuple(tiny(case) for case in cases.CASES if case.name in ("drained", "slow"))


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("paper")
    study.study(out, "coarse", lambda *_: None, cases=[tiny(cases.CASES[0]), tiny(cases.CASES[2])])
    return out


def no_run(*_: Any, **__: Any) -> Any:
    raise AssertionError("a run that has ended was run again")


def test_cases_are_the_papers() -> None:
    noted = {(case.rate, case.friction) for case in cases.CASES}
    assert noted == {(rate, mu) for rate in (None, 0.05e-3, 0.5e-3) for mu in (0.5, 0.0)}
    scene = cases.CASES[2].scene("paper")
    assert (scene.drainage.mode, scene.paths[0].rate, scene.paths[0].lateral_displacement) == ("coupled", 0.05e-3, 0.02)
    assert scene.soil.model_dump(exclude_unset=True) == PAPER_SOIL
    assert 2.5e-3 in scene.paths[0].report_at


@pytest.mark.slow
def test_what_has_ended_is_not_run_again(
    done: Path, two: tuple[Case, ...], monkeypatch: pytest.MonkeyPatch
) -> None:  # fmt: skip
    monkeypatch.setattr(folder, "run_to_folder", no_run)
    noted: list[tuple[str, float, str]] = []
    assert runs.run_all(done, "coarse", lambda *args: noted.append(args), two) == []
    assert noted[-1][:2] == ("all runs", 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("changed", ["version", "scene", "files"])
def test_another_version_or_scene_is_run_anew(
    done: Path, two: tuple[Case, ...], changed: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    case = two[0]
    place = done / stored_runs.RUNS / case.name
    assert stored_runs.has_ended(place, case.scene("coarse"))
    if changed == "version":
        monkeypatch.setattr("pysprings.core.version.__version__", "99")
        assert not stored_runs.has_ended(place, case.scene("coarse"))
    elif changed == "scene":
        assert not stored_runs.has_ended(place, replace(case, friction=0.4).scene("coarse"))
    else:
        (tmp_path / "run.json").write_bytes((place / "run.json").read_bytes())
        assert not stored_runs.has_ended(tmp_path, case.scene("coarse"))
        (tmp_path / "run.json").write_text("{", encoding="utf-8")
        assert RunRecord.read(tmp_path) is None


@pytest.mark.slow
def test_an_interrupted_run_goes_on(
    done: Path, two: tuple[Case, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    case, solve, calls = two[0], Newton.solve, []

    def stop(self: Newton, *args: Any, **kwargs: Any) -> Any:
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return solve(self, *args, **kwargs)

    with monkeypatch.context() as patch:
        patch.setattr(Newton, "solve", stop)
        with pytest.raises(KeyboardInterrupt):
            runs.run_all(tmp_path, "coarse", lambda *_: None, [case])
    place = tmp_path / stored_runs.RUNS / case.name
    assert is_unfinished(place)
    assert runs.run_all(tmp_path, "coarse", lambda *_: None, [case]) == []
    record = RunRecord.read(place)
    assert record is not None and record.resumed
    once = read_tree(done / stored_runs.RUNS / case.name / "full_model.nc")["paths/pull/H"].values
    assert read_tree(place / "full_model.nc")["paths/pull/H"].values == pytest.approx(once, rel=1e-12)


def test_checkpoints_of_another_scene_are_no_hindrance(
    two: tuple[Case, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def stop(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Newton, "solve", stop)
        with pytest.raises(KeyboardInterrupt):
            runs.run_all(tmp_path, "coarse", lambda *_: None, [replace(two[0], friction=0.4)])
    assert is_unfinished(tmp_path / stored_runs.RUNS / two[0].name)
    assert runs.run_all(tmp_path, "coarse", lambda *_: None, [two[0]]) == []
    assert stored_runs.has_ended(tmp_path / stored_runs.RUNS / two[0].name, two[0].scene("coarse"))


@pytest.mark.slow
def test_a_run_that_stops_early_keeps_its_part_and_everything_says_so(
    two: tuple[Case, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(step_size, "SMALLEST", 0.02)  # no endless halving
    hasty = {"max_iterations": 4, "tolerance": 1e-9, "first_step_fraction": 0.02, "max_step_fraction": 1.0}
    case = replace(two[0], changes={**TINY, "solver": hasty})
    stopped = study.study(tmp_path, "coarse", lambda *_: None, cases=[case])
    assert len(stopped) == 1
    assert stopped[0].startswith("drained: path 'pull' stopped on its way to")
    assert study.study(tmp_path, "coarse", lambda *_: None, cases=[case]) == stopped  # kept, and said again
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "A run stopped early." in report
    assert "drained: stopped at u = " in report
    assert study.read_claims(tmp_path)["verdict"].eq(UNKNOWN).sum() >= 9


@pytest.mark.slow
def test_a_study_writes_what_it_names(done: Path) -> None:
    for name in ("report.html", "claims.csv", "claims.md", figures.FOLDER, stored_runs.RUNS):
        assert (done / name).exists(), name
    drawn = {file.stem for file in (done / figures.FOLDER).glob("*.png")}
    ran = {"drained", "slow"}
    expected = {drawing.stem for drawing in figures.DRAWINGS if drawing.u < END and set(drawing.needs) <= ran}
    assert drawn == expected
    report = (done / "report.html").read_text(encoding="utf-8")
    for claim in claims.CLAIMS:
        assert claim.words.replace("'", "&#39;") in report
    assert "<script" not in report
    assert report.count("data:image") == len(drawn) + 1  # and the sketch of the axes
    assert "What decides them" not in report


@pytest.mark.slow
def test_the_command(done: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(study, "CASES", [tiny(cases.CASES[0]), tiny(cases.CASES[2])])
    kept: dict[str, Any] = {}
    app = typer.Typer()
    app.command()(paper)

    def keep(out: Path, mesh: str, report: Any, sensitivity_mesh: str | None, force: bool) -> list[str]:
        kept.update(out=out, mesh=mesh, sensitivity=sensitivity_mesh, force=force)
        return ["slow: path 'pull' stopped"]

    monkeypatch.setattr(study, "study", keep)
    noted = CliRunner().invoke(app, ["--mesh", "coarse", "--out", str(done)])
    assert noted.exit_code == 3
    assert "slow: path 'pull' stopped" in noted.output
    assert all(claim.words in noted.output for claim in claims.CLAIMS)
    assert kept == {"out": done, "mesh": "coarse", "sensitivity": None, "force": False}
    noted = CliRunner().invoke(app, ["--out", str(done), "--sensitivity", "--force"])
    assert "claims.csv" in noted.output
    assert kept == {"out": done, "mesh": "medium", "sensitivity": "coarse", "force": True}
    (tmp_path / "file").touch()
    assert CliRunner().invoke(app, ["--out", str(tmp_path / "file")]).exit_code == 2


@pytest.mark.slow
def test_begin_anew(done: Path, two: tuple[Case, ...], tmp_path: Path) -> None:
    for name in ("run.json", "full_model.nc", "springs.nc"):
        place = tmp_path / stored_runs.RUNS / "drained" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes((done / stored_runs.RUNS / "drained" / name).read_bytes())
    (tmp_path / sensitivity.FOLDER).mkdir()
    (tmp_path / sensitivity.FOLDER / "a-0123456789abcdef.json").touch()
    assert stored_runs.has_ended(place.parent, two[0].scene("coarse"))
    runs.forget(tmp_path, two)
    sensitivity.forget(tmp_path)
    assert not stored_runs.has_ended(place.parent, two[0].scene("coarse"))
    assert not list((tmp_path / sensitivity.FOLDER).iterdir())
    assert place.exists()


def test_progress_of_the_whole_and_the_time_left() -> None:
    now, noted = [0.0], []
    whole = stored_runs.Whole({"a": 1.0, "b": 3.0}, lambda *args: noted.append(args), clock=lambda: now[0])
    whole.ended("a", worked=False)  # by an earlier call: takes part in the whole, not in the pace
    now[0] = 30.0
    whole.of("b")(cases.PATH, 0.1, "step 1")
    assert noted[-1] == ("all runs", pytest.approx(0.325), "about 4 min left")
    now[0] = 150.0
    whole.of("b")(cases.PATH, 0.5, "step 5")
    assert noted[-1] == ("all runs", pytest.approx(0.625), "about 2 min left")
    whole.ended("b", worked=True)
    assert noted[-1] == ("all runs", 1.0, "")


# ---------------------------------------------------------------- sensitivities


def test_variants_have_names_of_their_own_and_are_scenes_or_refused() -> None:
    names = [c.name for v in cases.VARIANTS for c in (v.case(), v.smooth_case()) if c is not None]
    assert len(set(names)) == len(names)
    known = {variant.name for variant in cases.VARIANTS}
    for variant in cases.VARIANTS:
        assert variant.beside in known
        assert variant.standing in (cases.OPEN, cases.STATED)
        try:
            scene = variant.case().scene("coarse", fields_only=True)
        except ValueError as error:
            assert variant.name == "K0-0.5", error
            continue
        changed = scene.model_dump()
        for section, values in variant.changes.items():
            for key, value in values.items():
                assert changed[section][key] == value, f"{variant.name}: {section}.{key}"
        assert (scene.drainage.mode == "coupled") == variant.water
        if (smooth := variant.smooth_case()) is not None:
            assert smooth.scene("coarse").interface.friction_coefficient == 0.0


def test_variants_are_run_once_and_refusals_are_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cases, "VARIANT_STEPS_MM", (2.5,))
    short = Variant.case
    monkeypatch.setattr(Variant, "case", lambda self: replace(short(self), end=END))
    small = {**TINY, "soil": {}}
    variants = [
        Variant("as stated", "as-stated", "as it is", small),
        Variant("initial stress", "K0-0.5", "K0 0.5", {**small, "soil": {"K0": 0.5}}),
        Variant("water", "slow", "0.05 mm/s", small, smooth=False, water=True),
    ]
    *_, table = sensitivity.run_variants(tmp_path, "coarse", lambda *_: None, variants)
    first, *_, again = sensitivity.run_variants(tmp_path, "coarse", lambda *_: None, variants, no_run)
    assert len(first) == 1
    assert "Only 1 of 3 readings have run so far." in text.sensitivity_markdown(first)
    assert again.equals(table)
    table = table.set_index("variant")
    assert table.loc["K0-0.5", "status"] == "refused"
    assert "outside the initial yield surface" in table.loc["K0-0.5", "detail"]
    assert 0.2 < table.loc["as-stated", "smooth_2.5mm"] < 1.0
    assert 0.9 < table.loc["slow", "over_drained_2.5mm"] < 1.3
    assert table.loc["as-stated", "front_mean_2.5mm"] > 1.0


FOUR = {"front_mean_2.5mm": 1.5, "back_0.25m_2.5mm": 0.0, "bend_mm": 2.0, "bend_sharpness": 2.0, "smooth_2.5mm": 0.5}


@pytest.mark.parametrize(
    ("key", "value", "lost"),
    [("front_mean_2.5mm", 2.0, "is_front"), ("back_0.25m_2.5mm", 0.1, "is_gap"), ("bend_mm", 5.0, "is_break"),
     ("bend_sharpness", 0.5, "is_break"), ("smooth_2.5mm", 0.8, "is_half")],
)  # fmt: skip
def test_which_of_the_four_figures_a_reading_gives(key: str, value: float, lost: str) -> None:
    assert sensitivity.verdicts(FOUR) == {
        "is_front": True, "is_gap": True, "is_break": True, "is_half": True, "of_four": 4,
    }  # fmt: skip
    found = sensitivity.verdicts({**FOUR, key: value})
    assert found[lost] is False
    assert found["of_four"] == 3
    assert sensitivity.verdicts({**FOUR, key: float("nan")})[lost] is None


def _row(name: str, standing: str, **figures: float) -> dict[str, Any]:
    words = {"group": "soil", "variant": name, "what": name, "standing": standing, "status": "complete", "detail": ""}
    return {**words, **FOUR, **figures, **sensitivity.verdicts({**FOUR, **figures})}


def test_the_conclusion_says_whether_any_reading_gives_all() -> None:
    import pandas as pd

    none = pd.DataFrame([_row("a", "open", bend_mm=7.0), _row("b", "stated", **{"front_mean_2.5mm": 4.0})])
    assert text.conclusion(none).startswith("No reading tried here gives all four")
    assert "a [open] (front stress, gap, halving)" in text.conclusion(none)
    one = pd.DataFrame([_row("a", "open", bend_mm=7.0), _row("c", "stated")])
    assert text.conclusion(one).startswith("All four of the paper's figures come out of: c [stated].")
    assert "None of these leaves" in text.conclusion(one)
    page_text = text.sensitivity_markdown(one)
    assert sensitivity.CRITERIA in page_text
    assert "| a |" in page_text


@pytest.mark.slow
def test_the_report_shows_the_sensitivities(done: Path, two: tuple[Case, ...]) -> None:
    import pandas as pd

    table = pd.DataFrame([_row("a", "open", bend_mm=7.0)]).assign(mesh="coarse")
    ended = runs.load_runs(done, "coarse", two)
    file = page.write(done, "coarse", ended, [], study.read_claims(done), idealisations.compare({}), table)
    shown = file.read_text(encoding="utf-8")
    assert "What decides them" in shown
    assert "No reading tried here" in shown
