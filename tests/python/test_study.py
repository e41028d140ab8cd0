"""Studies of steps and integrators."""

import json
import os
import shutil
import signal
import subprocess
import sys
import types

import numpy as np
import pytest

import tetraction as tt

STEPS = [1e-3, 5e-4, 2.5e-4]


@pytest.fixture
def block(beam):
    """The beam stretched, without gravity, and with a probe, for a time of some steps."""
    beam.environment = {}
    beam.initial.velocity = [0.0, 0.0, 0.0]
    beam.initial.stretch = [1.02, 1.0, 1.0]
    beam.time.end = 0.02
    beam.probe = [tt.Probe(name="tip", select={"plane": {"axis": "x", "at": 1.0}}, quantity="position")]
    return beam


class Runs:
    """Counts the runs that a study makes."""

    def __init__(self):
        self.told = []

    def __call__(self, *told):
        self.told.append(told)


def test_a_study_in_a_directory_makes_no_run_twice(block, tmp_path):
    runs = Runs()
    study = tt.study(block, ["verlet", "midpoint"], STEPS, out=tmp_path / "study", progress=runs)
    array = study.array
    assert len(array) == 6 and set(array["integrator"]) == {"verlet", "midpoint"}
    assert array["position_error"].dtype == float and (array["status"] == "ok").all()
    verlet = array[array["integrator"] == "verlet"]
    assert verlet["observed_order"][np.isfinite(verlet["observed_order"])] == pytest.approx(2, abs=0.2)
    assert runs.told[0][:2] == (0, 6) and len(runs.told) == 6 and runs.told[-1][0] == 5
    assert study.stable_step > 0 and study.conclusions
    assert {"study.csv", "study.json", "study.html"} <= set(os.listdir(tmp_path / "study"))
    again = Runs()
    same = tt.study(block, ["verlet", "midpoint"], [*STEPS, 2e-3], out=tmp_path / "study", progress=again)
    assert {told[3] for told in again.told} == {2e-3}
    assert (same.array["position_error"][same.array["step"] < 2e-3] == array["position_error"]).all()
    fresh = Runs()
    tt.study(block, ["verlet"], STEPS, reference_integrator="verlet", out=tmp_path / "study", fresh=True,
             progress=fresh)  # fmt: skip
    assert len(fresh.told) == 3 and not os.path.exists(tmp_path / "study" / "midpoint-0.001")
    block._name = "other.toml"
    with pytest.raises(tt.InputError, match="the study of another scene, scene.*with out"):
        tt.study(block, ["verlet"], STEPS, out=tmp_path / "study")


def test_functions_of_a_program_may_have_changed(block, tmp_path):
    block.force_field = [tt.ForceField(lambda m, q: 0 * m, lambda m, q: 0 * q,
                                       lambda m, q: np.zeros((len(m), 3, 3)))]  # fmt: skip
    for _ in range(2):
        runs = Runs()
        tt.study(block, ["verlet"], STEPS, reference_integrator="verlet", out=tmp_path, progress=runs)
        assert len(runs.told) == 3


@pytest.mark.parametrize(
    "steps, expected",
    [
        ([1e-3, "5e-4"], {("midpoint", 1e-3), ("midpoint", 5e-4), ("verlet", 1e-3), ("verlet", 5e-4)}),
        ({"midpoint": "2x", "verlet": [1e-3, "0.5x"]}, {("midpoint", 2.0), ("verlet", 1e-3), ("verlet", 0.5)}),
        ({"verlet": "auto"}, {("verlet", 0.5)}),
    ],
)
def test_steps(block, steps, expected):
    limit = tt.Session(block).stable_step
    rules = ["midpoint", "verlet"] if isinstance(steps, list) else []
    plan = tt.study(block, rules, steps, plan=True)
    asked = plan[plan["role"] == "run"]
    found = list(zip(asked["integrator"], asked["step"]))
    assert len(found) == len(expected)
    for rule, step in expected:
        step = step if step < 0.1 else step * limit
        step = 0.02 / np.ceil(0.02 / step - 1e-6)  # made to divide the end
        assert any(r == rule and h == pytest.approx(step, rel=1e-12) for r, h in found), (rule, step, found)
    assert (plan["steps"] == np.ceil(0.02 / plan["step"] - 1e-6)).all()
    assert (plan["seconds"] > 0).all() and not plan["kept"].any()


def test_the_study_chooses_steps_and_writes_nothing_for_a_plan(block, tmp_path):
    plan = tt.study(block, ["verlet", "midpoint"], budget=2, out=tmp_path / "plan", plan=True)
    assert set(plan["integrator"]) == {"verlet", "midpoint"} and "trial" in plan["role"]
    assert not os.path.exists(tmp_path / "plan")
    study = tt.study(block, ["verlet"], target="1%", budget="5s")
    (found,) = study.searched
    assert found["rule"] == "verlet" and found["target"]["is_met"] and found["target"]["target"] == 0.01
    row = study.array[np.isclose(study.array["step"], found["target"]["step"], rtol=1e-12)]
    assert row["position_error"] <= 0.01 and "1 %" in study.answer


def test_variants_jobs_and_other_solvers(block):
    block.initial.stretch = [1.05, 1.0, 1.0]
    alone = tt.study(block, ["midpoint", "verlet"], STEPS, vary={"material.density": [900.0, 1000.0]})
    variants = alone.array["variant"]
    assert set(variants) == {"900.0", "1000.0"} and len(variants) == 12
    both = tt.study(block, ["midpoint", "verlet"], STEPS, jobs=3, vary={"material.density": "900.0,1000.0"})
    for column in ("position_error", "observed_order", "max_relative_energy_drift"):
        np.testing.assert_array_equal(both.array[column], alone.array[column])
    assert "density" in json.dumps(both.data["variants"]) and "900.0" in both.answer
    ceres = tt.study(block, ["midpoint"], STEPS, also_solver=["ceres@1e-3"], reference="richardson")
    assert set(ceres.array["solver"]) == {"newton", "ceres"}
    assert ceres.data["reference"]["extrapolation"]["valid"]


def test_rules_repeats_and_a_mesh_check(block, tmp_path):
    rule = "midpoint:solver.tolerance=1e-6"
    arguments = {"integrators": ["midpoint"], "steps": STEPS, "rules": [rule], "mesh_check": True}
    plan = tt.study(block, plan=True, **arguments)
    assert list(plan["settings"]).count("solver.tolerance=1e-6") == len(STEPS)
    assert plan["directory"][-1].startswith("mesh-check-")
    for out in (None, tmp_path / "study"):
        study = tt.study(block, repeats=1, out=out, **arguments)
        own = study.array[study.array["settings"] == "solver.tolerance=1e-6"]
        assert len(own) == len(STEPS) and (own["status"] == "ok").all()
        assert set(study.array["repeats"]) <= {0, 1} and 1 in study.array["repeats"]
        check = study.data["mesh_check"]
        assert check["status"] == "ok" and 0 < check["difference"] < 1
    assert not tt.study(block, repeats=0, **arguments).array["repeats"].any()
    runs = Runs()
    tt.study(block, repeats=1, out=tmp_path / "study", progress=runs, **arguments)
    assert not runs.told


def test_parts_are_merged_and_opened_by_the_program(block, tmp_path):
    def program(*arguments):
        return subprocess.run([os.environ["TETRACTION_PROGRAM"], "study", *arguments], capture_output=True, text=True)

    whole = tt.study(block, ["verlet", "midpoint"], STEPS, out=tmp_path / "whole")
    parts = [tmp_path / f"part{k}" for k in (1, 2)]
    for k, part in enumerate(parts, 1):
        study = tt.study(block, ["verlet", "midpoint"], STEPS, part=f"{k}/2", out=part)
        assert len(study.array) == 3
    merged = program("merge", *parts, "--out", tmp_path / "merged", "--no-plots")
    assert merged.returncode == 0, merged.stderr
    array = tt.read_study(tmp_path / "merged").array
    for column in ("directory", "integrator", "step", "position_error", "observed_order"):
        if column in (array.dtype.names or ()):
            np.testing.assert_array_equal(array[column], whole.array[column])
    opened = program("open", tmp_path / "whole")
    assert opened.returncode == 0 and "midpoint" in opened.stdout
    # Nothing tells whether the functions of two studies are the same.
    block.force_field = [tt.ForceField(lambda m, q: 0 * m, lambda m, q: 0 * q,
                                       lambda m, q: np.zeros((len(m), 3, 3)))]  # fmt: skip
    for part in ("own1", "own2"):
        tt.study(block, ["verlet"], STEPS, reference_integrator="verlet", out=tmp_path / part)
    refused = program("merge", tmp_path / "own1", tmp_path / "own2", "--out", tmp_path / "none")
    assert refused.returncode == 3 and "cannot be merged" in refused.stderr


def test_an_error_of_a_probe_and_an_error_function(block, tmp_path):
    """The functions compute what the library computes by itself."""

    def of_positions(run, reference):
        assert run.times[-1] == pytest.approx(0.02) and run.positions.shape == (len(run.times), *run.rest.shape)
        assert run.probes["tip"].values.shape == (len(run.probes["tip"].times), 3)
        scale = np.linalg.norm(reference.positions - reference.rest, axis=(1, 2))
        at_end = max(np.linalg.norm(reference.end - reference.rest), 0.1 * np.sqrt(np.mean(scale**2)))
        return np.linalg.norm(run.end - reference.end) / at_end

    for out in (None, tmp_path / "study"):
        own = tt.study(block, ["verlet", "midpoint"], [*STEPS, 0.02], error=of_positions, out=out)
        assert own.array["custom_error"] == pytest.approx(own.array["position_error"], rel=1e-9, nan_ok=True)
        assert np.isnan(own.array["custom_error"]).sum() == (own.array["status"] != "ok").sum() == 1
    for error in ({"error": "probe.tip"}, {"error_probe": "tip"}):
        study = tt.study(block, ["verlet", "midpoint"], STEPS, **error)
        assert np.nanmax(study.array["probe_error"]) > 0 and study.data["error"] == "probe.tip"
    with pytest.raises(ZeroDivisionError):
        tt.study(block, ["midpoint"], STEPS, error=lambda run, reference: 1 / 0)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"integrators": ["euler"]}, "euler"),
        ({"integrators": ["verlet", "verlet"]}, "integrators: verlet is there twice"),
        ({"steps": ["4y"]}, 'steps: "4y" is no step'),
        ({"steps": {"euler": 1e-3}}, "euler"),
        ({"target": 2.0}, "target"),
        ({"budget": "soon"}, "budget"),
        ({"error": "tip"}, "error"),
        ({"error": "probe.none"}, "none"),
        ({"error": "probe.tip", "error_probe": "tip"}, "exclude each other"),
        ({"vary": {"material.densty": [1, 2]}}, "vary material.densty=1.*did you mean"),
        ({"vary": {"time.end": [1, 2]}}, "vary time.end"),
        ({"also_solver": ["ceres"]}, "SOLVER@STEP"),
        ({"rules": ["midpoint"]}, "rule"),
        ({"rules": ["midpoint:time.end=2"]}, "time.end"),
        ({"rules": 2 * ["midpoint:time.retry=3"]}, "rule: midpoint:time.retry=3 is there twice"),
        ({"repeats": -1}, "repeats"),
        ({"part": "3/2"}, "part"),
        ({"part": "9/9"}, "has only"),
        ({"part": "1/2", "steps": None}, "part: all parts"),
        ({"part": "1/2", "mesh_check": True}, "mesh_check: a part"),
        ({"target": "1%"}, "target searches for the steps"),
        ({"jobs": 0}, "jobs"),
        ({"reference": "guess"}, "guess"),
    ],
)
def test_wrong_arguments(block, arguments, message):
    with pytest.raises(tt.InputError, match=message):
        tt.study(block, **{"integrators": ["midpoint"], "steps": STEPS, **arguments})


def test_a_study_is_read_from_its_directory(block, tmp_path):
    made = tt.study(block, ["verlet", "midpoint"], STEPS, out=tmp_path / "python", vary={"material.density": [9, 10]})
    read = tt.read_study(tmp_path / "python")
    for column in made.array.dtype.names:
        np.testing.assert_array_equal(read.array[column], made.array[column])
    assert (read.answer, read.conclusions, read.directory) == (made.answer, made.conclusions, str(tmp_path / "python"))
    scene = os.path.join(os.environ["TETRACTION_SCENES"], "spinning_block.toml")
    subprocess.run([os.environ["TETRACTION_PROGRAM"], "study", scene, "--set", "time.end=0.02", "--out",
                    tmp_path / "command", "--steps", "1e-3,5e-4", "--no-plots", "--quiet"], check=True)  # fmt: skip
    of_command = tt.read_study(tmp_path / "command")
    assert len(of_command.array) == 10 and "explicit" in of_command.answer


def test_what_is_no_study_is_not_read(block, tmp_path):
    tt.study(block, ["midpoint"], STEPS, out=tmp_path / "good")
    whole = (tmp_path / "good" / "study.json").read_text()
    rows = json.loads(whole)["runs"]
    for text, message in (
        (None, "does not hold the results of a study"),
        (whole[:-100], "not the study.json of a study"),
        (whole.replace('"position_error"', '"position"', 1), '"position_error" is missing'),
        (json.dumps({**json.loads(whole), "runs": rows[:1] + rows[:1]}), "that of another run"),
        ("[1]", "not the study.json of a study"),
        ('{"runs": []}', '"scene" is missing'),
        ('{"runs": [], "message": "The study has not ended."}', "has not ended"),
        ("\0\xff", "not the study.json of a study"),
    ):
        shutil.rmtree(tmp_path / "bad", ignore_errors=True)
        os.mkdir(tmp_path / "bad")
        if text is not None:
            (tmp_path / "bad" / "study.json").write_text(text, encoding="latin-1" if "\xff" in text else "utf-8")
        with pytest.raises(tt.InputError, match=message):
            tt.read_study(tmp_path / "bad")
    # Nothing is read from study.csv.
    os.remove(tmp_path / "good" / "study.csv")
    assert len(tt.read_study(tmp_path / "good").array) == len(rows)


def test_every_plot_has_a_method_that_returns_its_axes(block, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    study = tt.study(block, ["verlet", "midpoint"], STEPS, out=tmp_path / "study", error="probe.tip")
    assert len(study.plot().get_lines()) == 3
    study.write_plots()
    drawn = {name[:-4] for name in os.listdir(tmp_path / "study") if name.endswith(".pdf")}
    assert {"error_over_step", "energy_over_time", "probe_tip"} <= drawn
    for name in sorted(drawn - {"probe_tip"}):
        axes = getattr(study, f"plot_{name}")()
        assert all(hasattr(one, "get_lines") for one in np.ravel(axes)), name
        assert f"plot_{name}" in dir(study)
    assert study.plot_probe(name="tip") is not None
    figure, axes = pyplot.subplots()
    assert study.plot_error_over_step(axes) is axes
    pyplot.close("all")
    assert not hasattr(study, "plot_nothing") and not hasattr(study, "nothing")
    in_memory = tt.study(block, ["midpoint"], STEPS)
    assert in_memory.directory is None and in_memory.plot_error_over_step().get_lines()
    pyplot.close("all")
    with pytest.raises(tt.InputError, match="plot_energy_over_time.*give `out`"):
        in_memory.plot_energy_over_time()
    with pytest.raises(tt.InputError, match="directory"):
        in_memory.write_plots()


def test_a_study_as_data_frame_and_in_a_notebook(block, monkeypatch):
    shown = []

    class Handle:
        def update(self, page):
            shown.append(page)

    def display(page, display_id):
        shown.append(page)
        return Handle()

    ipython, of_display = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    of_display.HTML, of_display.display = str, display
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", of_display)
    ipython.get_ipython = lambda: object()  # a terminal
    study = tt.study(block, ["midpoint"], STEPS)
    assert not shown
    ipython.get_ipython = lambda: types.SimpleNamespace(kernel=1)
    tt.study(block, ["midpoint"], STEPS)
    assert [page.count("<tr>") for page in shown] == [0, 2, 3, 4, 4]
    page = study._repr_html_()
    assert page.startswith("<table>") and ">midpoint</td>" in page and "reference" in page
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="to_pandas needs pandas"):
        study.to_pandas()
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=dict))
    frame = study.to_pandas()
    assert list(frame) == list(study.array.dtype.names) and (frame["step"] == study.array["step"]).all()


INTERRUPTED = """
import os, signal, sys
import tetraction as tt
scene = tt.Scene(mesh={"generate": {"kind": "beam", "size": [1.0, 0.2, 0.2], "cells": [4, 2, 2]}},
                 material=tt.Material(youngs_modulus=1e5, poissons_ratio=0.3, density=1000),
                 initial={"stretch": [1.02, 1, 1]}, time=tt.Time(end=1e4))
def begun(i, count, rule, step):
    if step < 1:
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, 0.5)
try:
    tt.study(scene, ["verlet"], [1e4, 1e-4], reference_integrator="verlet", reference_step=1e4, out="study",
             jobs=int(sys.argv[1]), progress=begun)
except KeyboardInterrupt:
    print("interrupted")
print(sorted(os.listdir("study")))
study = tt.study(scene, ["verlet"], [1e4], reference_integrator="verlet", reference_step=1e4, out="study",
                 progress=lambda *told: print(told))
print(len(study.array))
"""


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_interrupt_ends_a_run_and_keeps_the_others(tmp_path, jobs):
    """The run with small steps would take hours."""
    result = subprocess.run([sys.executable, "-c", INTERRUPTED, str(jobs)], timeout=120, capture_output=True,
                            text=True, cwd=tmp_path)  # fmt: skip
    lines = result.stdout.splitlines()
    assert result.returncode == 0 and lines[0] == "interrupted", result.stderr
    assert "'study.json'" in lines[1] and "'verlet-10000'" in lines[1]
    assert lines[2:] == ["1"], result.stdout  # the run that was complete is not made again
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


ONE_RUN = """
import sys
import tetraction as tt
scene = tt.Scene(mesh={"generate": {"kind": "tetrahedron"}}, time=tt.Time(end=1e-4),
                 material=tt.Material(youngs_modulus=1e5, poissons_ratio=0.3, density=1000))
tt.study(scene, ["verlet"], [1e-4], reference_step=1e-4, reference_integrator="verlet", out=sys.argv[1],
         progress=lambda *told: print("made"))
"""


def test_another_build_of_the_package_makes_the_runs_anew(tmp_path):
    shutil.copytree(os.path.dirname(tt.__file__), tmp_path / "packages" / "tetraction")
    (library,) = (tmp_path / "packages" / "tetraction").glob("_core*.so")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "packages")}

    def made():
        return subprocess.run([sys.executable, "-c", ONE_RUN, tmp_path / "study"], env=environment, check=True,
                              capture_output=True, text=True).stdout  # fmt: skip

    assert made() == "made\n"
    assert made() == ""
    with open(library, "ab") as file:
        file.write(b"\0")
    assert made() == "made\n"
