"""Sessions: steps, views, edits, and that they are the runs of the program."""

import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import tetraction as tt


def test_a_run_is_the_one_of_the_program(beam, tmp_path):
    (tmp_path / "beam.toml").write_text(beam.to_toml())
    subprocess.run([os.environ["TETRACTION_PROGRAM"], "run", tmp_path / "beam.toml", "--out",
                    tmp_path / "out", "--quiet"], check=True)  # fmt: skip
    session = tt.run(beam)
    assert session.status == "ok"
    with open(tmp_path / "out" / "history.csv") as file:
        rows = list(csv.DictReader(file))
    history = session.history
    assert list(history) == list(rows[0])
    for name, values in history.items():
        assert values.tolist() == [float(row[name]) for row in rows], name


def test_probes(beam, tmp_path):
    beam.probe = [tt.Probe(name="tip", quantity="displacement", select={"plane": {"axis": "x", "at": 1.0}}),
                  tt.Probe(name="J", quantity="jacobian", select={"all": True}, every=4)]  # fmt: skip
    session = tt.run(beam, tmp_path)
    with open(tmp_path / "probes.csv") as file:
        rows = list(csv.DictReader(file))
    assert list(session.probes) == list(rows[0]) and len(session.probes["step"]) == 101
    for name, values in session.probes.items():
        expected = [float(row[name]) if row[name] else np.nan for row in rows]
        assert np.array_equal(values[: len(expected)], expected, equal_nan=True), name
    assert np.isfinite(session.probes["J"]).sum() == 26


def test_going_back_takes_rows_away(beam):
    session = tt.Session(beam)
    session.step(5)
    checkpoint = session.checkpoint()
    session.step(5)
    positions = session.positions.copy()
    session.restore(checkpoint)
    assert session.history["step"].tolist() == list(range(6))
    session.step(5)
    assert session.history["step"].tolist() == list(range(11))
    assert np.array_equal(session.positions, positions)


def test_files_of_a_run(beam, tmp_path):
    session = tt.run(beam, tmp_path / "out")
    names = os.listdir(tmp_path / "out")
    assert {"history.csv", "final.vtu", "summary.json", "frames.pvd"} <= set(names)
    with open(tmp_path / "out" / "history.csv") as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["total_energy"]) == session.energies["total"]


def test_views_follow_the_run_and_keep_their_addresses(beam):
    beam.time.step, beam.time.end, beam.time.integrator = 1e-4, 10.0, "explicit"
    session = tt.Session(beam, history=False)
    views = [session.positions, session.velocities, session.momenta]
    before = [view.ctypes.data for view in views]
    start = session.positions.copy()
    assert session.step(500) == 500
    session.apply(tt.SetDamping(viscosity=10.0))
    session.apply(tt.SetFix(select={"plane": {"axis": "x", "at": 1.0}}))
    session.apply(tt.SetSolver(tolerance=1e-9))
    session.step(500)
    after = [session.positions, session.velocities, session.momenta]
    assert [view.ctypes.data for view in after] == before
    for old, new in zip(views, after):
        assert np.shares_memory(old, new)
        assert np.array_equal(old, new)  # the old views show the present state
        assert old.shape == (45, 3) and not old.flags.writeable
        with pytest.raises(ValueError):
            old[0, 0] = 1.0
    assert abs(views[0] - start).max() > 1e-4
    # Views keep the session alive.
    positions = session.positions
    del session, views, after
    assert np.isfinite(positions).all()


def test_arrays_of_each_type_give_the_same(cube):
    points, tetrahedra = cube
    scene = tt.Scene(material={"youngs_modulus": 1e5, "poissons_ratio": 0.3, "density": 1000.0},
                     time={"integrator": "verlet", "step": 1e-3, "end": 1.0},
                     initial={"angular_velocity": [0.0, 1.0, 2.0]})  # fmt: skip
    ends = []
    for kind in (np.int32, np.int64, np.uint16):
        session = tt.Session(scene, points, tetrahedra.astype(kind))
        assert session._core is not None
        session.step(100)
        ends.append(session.positions.copy())
    assert np.array_equal(ends[0], ends[1]) and np.array_equal(ends[0], ends[2])
    assert abs(ends[0] - points).max() > 1e-2
    # With copy=False the mesh sees what happens to the array.
    own = points.copy()
    mesh = tt.Mesh(own[:], tetrahedra, copy=False)  # what the array is a view of can be written to
    own[0, 0] = -0.25
    assert mesh.points[0, 0] == -0.25
    # Arrays of another layout are converted.
    session = tt.Session(scene, np.asfortranarray(points), [list(t) for t in tetrahedra])
    session.step(100)
    assert np.array_equal(session.positions, ends[0])


@pytest.mark.parametrize("points, tetrahedra, message", [
    (np.zeros((4, 2)), [[0, 1, 2, 3]], r"\(n, 3\)"),
    (np.zeros((4, 3)), [[0, 1, 2]], r"\(m, 4\)"),
    (np.eye(4, 3), [[0, 1, 2, 9]], "9"),
    (np.eye(4, 3), [[0.5, 1, 2, 3]], "whole numbers"),
    (np.full((4, 3), np.nan), [[0, 1, 2, 3]], "NaN|finite"),
    (np.eye(4, 3, dtype=complex), [[0, 1, 2, 3]], "real"),
])  # fmt: skip
def test_wrong_arrays_are_refused(points, tetrahedra, message):
    scene = tt.Scene(material={"youngs_modulus": 1e5, "poissons_ratio": 0.3})
    with pytest.raises(tt.InputError, match=message):
        tt.Session(scene, points, tetrahedra)


def test_quadratic_elements_of_arrays(cube):
    points, tetrahedra = cube
    scene = tt.Scene(mesh={"element": "quadratic"},
                     material={"youngs_modulus": 1e5, "poissons_ratio": 0.3})  # fmt: skip
    session = tt.Session(scene, points, tetrahedra)
    assert session.tetrahedra.shape == (6, 10) and len(session.rest_positions) == 27
    assert session.masses.sum() == pytest.approx(1000.0)


def test_energy_and_balance(beam):
    session = tt.Session(beam)
    session.step(50)
    energies = session.energies
    assert energies["total"] == pytest.approx(sum(v for k, v in energies.items() if k != "total"))
    assert session.balance["max_relative_energy_drift"] < 1e-2
    assert session.time == pytest.approx(0.1) and session.step_number == 50
    assert session.history["time"][-1] == session.time
    fields = session.element_fields()
    assert fields["cauchy_stress"].shape == (96, 6) and (fields["jacobian"] > 0).all()
    more = session.fields("pressure", "displacement", "jacobian_nodal", "pressure")
    assert list(more) == ["pressure", "displacement", "jacobian_nodal"]
    assert np.array_equal(more["displacement"], session.displacements)
    assert more["jacobian_nodal"].shape == (len(session.positions),)
    assert np.allclose(more["pressure"], -fields["cauchy_stress"][:, :3].mean(axis=1))
    with pytest.raises(tt.InputError, match="there are displacement, position"):
        session.fields("colour")
    assert session.reactions.sum(axis=0)[1] > 0
    assert session.stable_step > 0 and session.current_stable_step() > 0


def test_other_threads_run_during_steps(beam):
    """Another thread ends the steps, which would go on for ever if it had to wait for them."""
    beam.time.end = 1e9
    session = tt.Session(beam, history=False)

    def watch():
        while session.step_number < 20:
            time.sleep(0)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=watch)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        session.step(10**9)
    thread.join()
    assert session.step_number >= 20


def test_ctrl_c_stops_between_two_steps(beam):
    beam.time.end = 1e9
    session = tt.Session(beam, history=False)
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        session.step(10**9)
    made = session.step_number
    assert made > 0 and session.status == "running"
    assert session.step(3) == 3 and session.step_number == made + 3


def test_observers(beam):
    session = tt.Session(beam)
    times = []
    assert session.run(observers=[lambda s: times.append(s.time)]) == "ok"
    assert len(times) == 100 and times[-1] == pytest.approx(0.2)
    session = tt.Session(beam)
    assert session.run(observers=[lambda s: s.step_number < 7]) == "running"
    assert session.step_number == 7

    def broken(session):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        tt.Session(beam).run(observers=[broken])


def test_every_edit(beam):
    beam.time.end = 100.0
    beam.obstacle = [tt.Obstacle(kind="plane", name="deep", point=[0, -9, 0], normal=[0, 1, 0])]
    session = tt.Session(beam)
    tip = {"plane": {"axis": "x", "at": 1.0}}
    session.step(2)
    edits = [
        tt.SetMaterial(youngs_modulus=2e5),
        tt.SetTime(step=1e-3),
        tt.SetSolver(tolerance=1e-9),
        tt.SetDamping(viscosity=1.0),
        tt.SetEnvironment(strength=1.62),
        tt.SetPull(vertices=[40, 44], target=[1.0, 0.1, 0.0], stiffness=5.0, damping=0.1),
        tt.SetForce(select=tip, vector=[0, 0, 1e-3]),
        tt.SetForce(0, vector=[0, 0, 2e-3]),
        tt.SetPressure(select=tip, value=3.0),
        tt.SetTraction(select=tip, vector=[1.0, 0, 0]),
        tt.SetBodyForce(select={"all": True}, vector=[1.0, 0, 0]),
        tt.SetMoment(select=tip, vector=[1e-4, 0, 0]),
        tt.SetConstraint(kind="distance", vertices=[40, 44]),
        tt.RemoveConstraint(0),
        tt.SetObstacle(kind="plane", name="floor", point=[0, -5, 0], normal=[0, 1, 0]),
        tt.SetObstacle(0, velocity=[0, 0.1, 0]),
        tt.RemoveObstacle(1),
        tt.SetFix(select=tip),
        tt.Unfix(fix=1),
        tt.SetMomentum({"vertices": [44]}, [0.1, 0, 0]),
        tt.Shift([43], displacement=[[1e-4, 0, 0]]),
        tt.Set({"damping.viscosity": 2.0, "time.step": 2e-3}),
    ]
    for edit in edits:
        session.apply(edit)
        assert session.step() == 1, (edit, session.message)
    assert session.time_step == 2e-3
    assert abs(session.balance["energy_error"]) < 1e-3 * session.balance["energy_scale"]
    with pytest.raises(tt.InputError, match="density"):
        session.apply(tt.SetMaterial(density=5.0))
    with pytest.raises(tt.InputError, match="constraint"):
        session.apply(tt.RemoveConstraint(7))
    with pytest.raises(tt.InputError, match="obstacle"):
        session.apply(tt.RemoveObstacle(2))
    with pytest.raises(tt.InputError, match="penetrates"):
        session.apply(tt.SetObstacle(0, point=[0, 9, 0]))
    # The class says so.
    assert "raises InputError" in tt.SetObstacle.__doc__
    assert "penetrate" in tt.SetObstacle.__doc__
    assert session.step() == 1


def test_edits_and_events_of_the_scene_have_their_own_places(beam):
    beam.event = [tt.Event(at=0.01, set={"damping.viscosity": 5.0})]
    beam.time.end = 0.05
    session = tt.Session(beam)
    session.step(2)
    session.apply(tt.SetDamping(mass_damping=3.0))
    session.step(100)
    assert session.status == "ok"
    twice = tt.Session(beam)
    twice.step(2)
    twice.set({"damping.mass_damping": 3.0})
    twice.step(100)
    assert np.array_equal(session.positions, twice.positions)


def test_checkpoints_go_on_with_the_same_bits(beam):
    session = tt.Session(beam)
    session.step(10)
    session.apply(tt.SetForce(select={"all": True}, vector=[0, 0, 1e-3]))
    saved = session.checkpoint()
    session.step(10)
    other = tt.Session(beam)
    other.restore(saved)
    other.step(10)
    assert np.array_equal(session.positions, other.positions)
    other.apply(tt.SetForce(0, vector=[0, 0, 2e-3]))


def test_a_step_that_fails_is_told_and_leaves_the_state(beam):
    beam.time.integrator, beam.time.step, beam.time.end = "explicit", 1.0, 1000.0
    session = tt.Session(beam)
    session.step(1000)
    assert session.status == "unstable"
    assert session.failure["remedy"] and session.failure["elements"]
    assert np.isfinite(session.positions).all()


def test_shapes_for_other_packages(beam):
    session = tt.run(beam)
    vtk = pytest.importorskip("vtkmodules.util.numpy_support")
    grid = session.to_vtk()
    assert grid.GetNumberOfCells() == 96
    points = vtk.vtk_to_numpy(grid.GetPoints().GetData())
    assert np.array_equal(points, session.positions)
    assert np.array_equal(vtk.vtk_to_numpy(grid.GetPointData().GetArray("displacement")),
                          session.displacements)  # fmt: skip
    meshio = pytest.importorskip("meshio")
    mesh = session.to_meshio()
    assert isinstance(mesh, meshio.Mesh) and np.array_equal(mesh.points, session.positions)
    assert set(mesh.point_data) == {"displacement", "velocity", "momentum"}


def test_packages_are_imported_when_they_are_needed():
    code = "import sys, tetraction; print([m for m in ('meshio', 'pyvista', 'vtkmodules', 'matplotlib') if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_one_thing_at_a_time(beam):
    beam.time.end = 1e9
    session = tt.Session(beam)
    refused, made = [], []

    def meddle():
        while session.step_number < 5:
            time.sleep(0)
        for action in (lambda: session.step(1), lambda: session.apply(tt.SetDamping(viscosity=1.0)),
                       session.checkpoint, session.element_fields, lambda: session.history):  # fmt: skip
            try:
                action()
                made.append(action)
            except tt.InputError as error:
                refused.append(str(error))
        for _ in range(100):
            assert session.positions.shape == (45, 3)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=meddle)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        session.step(10**9)
    thread.join()
    assert len(refused) == 5 and not made
    assert "another thread" in refused[0]
    assert session.step(3) == 3


def test_an_observer_may_edit_but_not_step(beam):
    session = tt.Session(beam)

    def observer(s):
        if s.step_number == 3:
            s.apply(tt.SetDamping(viscosity=5.0))
            assert len(s.history["step"]) == 4
        if s.step_number == 5:
            s.step()

    with pytest.raises(tt.InputError, match="within a run"):
        session.run(observers=observer)
    assert session.step_number == 5 and session.step(2) == 2  # the session goes on


def test_an_observer_ends_the_run_and_the_session_goes_on(beam, tmp_path):
    session = tt.Session(beam)
    assert session.run(observers=[lambda s: s.positions[:, 0].max() > 10]) == "running"
    assert session.step_number == 1  # False of NumPy
    assert session.run() == "ok"

    def interrupt(s):
        if s.step_number == 7:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tt.Session(beam).run(observers=interrupt, out=tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "interrupted" and summary["steps"] == 7
    assert (tmp_path / "final.vtu").exists()


def test_arrays_in_use_cannot_be_changed(beam, cube):
    points, tetrahedra = cube
    beam.mesh = {}
    beam.fix = []
    session = tt.Session(beam, points, tetrahedra, copy=False)
    with pytest.raises(ValueError, match="read-only"):
        tetrahedra += 10**9
    with pytest.raises(ValueError, match="read-only"):
        points *= 2
    assert session.vertex_ids.tolist() == list(range(8))


@pytest.mark.parametrize("make", [
    lambda scene, *arrays: tt.Session(scene, *arrays),
    lambda scene, *arrays: tt.Session(scene, tt.Mesh(*arrays)),
])  # fmt: skip
def test_what_happens_to_arrays_later_does_not_reach_a_session(beam, cube, make):
    """Also what happens to arrays of which those that are given are views: NumPy leaves them writable."""
    points, tetrahedra = cube
    scene = tt.Scene(material=beam.material, time=beam.time, initial={"angular_velocity": [0, 1, 2]})
    expected = make(scene, points, tetrahedra)
    expected.step(20)
    all_points = np.concatenate([points, np.ones((5, 3))])
    all_tetrahedra = np.concatenate([tetrahedra, tetrahedra])
    session = make(scene, all_points[:8], all_tetrahedra[:6])
    session.step(10)
    all_points *= 3
    all_tetrahedra += 10**6
    session.step(10)
    assert abs(expected.displacements).max() > 1e-2
    assert np.array_equal(session.positions, expected.positions)
    assert np.array_equal(session.rest_positions, points)
    assert points.flags.writeable and tetrahedra.flags.writeable


def test_what_happens_to_values_later_does_not_reach_settings_and_edits(beam):
    value, group = np.zeros(3), [0.0, 0.0, 0.0]
    for axis in range(3):
        value[:], group[:] = 0.0, [0.0, 0.0, 0.0]
        value[axis] = group[axis] = 1.0
        beam.force.append(tt.Force(select={"nearest": group}, vector=value))
    assert [list(force.vector) for force in beam.force] == np.eye(3).tolist()
    assert [force.select["nearest"] for force in beam.force] == np.eye(3).tolist()
    beam.force = []

    def run(**later):
        session = tt.Session(beam)
        load = np.array([0.0, 0.0, 1.0])
        edit = tt.SetForce(select={"nearest": [1.0, 0.0, 0.0]}, vector=load)
        load *= later.get("before", 1.0)
        session.apply(edit)
        edit.entry["force"]["vector"] *= later.get("after", 1.0)
        session.step(5)
        session.apply(tt.SetForce(0, until=0.1))  # the other keys stay
        session.apply(tt.SetDamping(viscosity=1.0))
        session.step(5)
        return session.positions.copy()

    expected = run()
    assert np.array_equal(run(before=7.0), expected)
    assert np.array_equal(run(after=7.0), expected)


def test_loads_can_change_after_every_step(beam):
    """Such edits become part of the scene, so that their cost does not grow."""
    beam.time.step, beam.time.end = 1e-3, 10.0
    session, other = tt.Session(beam), tt.Session(beam)
    select = {"plane": {"axis": "x", "at": 1.0}}
    for s in (session, other):
        s.apply(tt.SetForce(select=select, vector=[0, 0, 0]))
    for k in range(60):
        session.apply(tt.SetForce(0, vector=[0, 0, 0.01 * k]))
        other.apply({"set": {"force.0.vector": [0, 0, 0.01 * k], "damping.drag": 0.0}})  # stays an event
        session.step()
        other.step()
    assert not session._own_events and len(other._own_events) == 60
    assert np.array_equal(session.positions, other.positions)
    checkpoint = session.checkpoint()
    session.apply(tt.SetForce(select=select, vector=[1, 0, 0]))
    session.apply(tt.SetForce(1, vector=[2, 0, 0]))
    session.restore(checkpoint)
    with pytest.raises(tt.InputError, match="force"):
        session.apply(tt.SetForce(1, vector=[2, 0, 0]))


def test_results_are_not_mixed(beam, tmp_path):
    tt.run(beam, tmp_path / "run")
    beam.mesh = {"file": str(tmp_path / "run" / "final.vtu")}
    with pytest.raises(tt.InputError, match="overwritten"):
        tt.run(beam, tmp_path / "run")
    with pytest.raises(tt.InputError, match="results of a run"):
        tt.study(beam, ["midpoint"], [1e-2], out=tmp_path / "run")


@pytest.mark.parametrize("wrong", [
    lambda s: s.step(-1), lambda s: s.step(1.5), lambda s: s.apply(tt.Force(vector=[0, 0, 1])),
    lambda s: s.restore((1, 2)), lambda s: tt.set_thread_count(-1)])  # fmt: skip
def test_wrong_arguments(beam, wrong):
    with pytest.raises(tt.InputError):
        wrong(tt.Session(beam))


def test_the_edit_that_was_made_last_counts(beam):
    """Also where an event of the scene is due at the same time."""
    def final(event, edit):
        beam.event = [tt.Event(at=0.02, set={"environment.strength": event})] if event else []
        session = tt.Session(beam)
        session.step(10)
        assert session.time == pytest.approx(0.02)
        if edit:
            session.apply(tt.SetEnvironment(strength=edit))
        session.step(10)
        return session.positions.copy()

    assert np.array_equal(final(5.0, 2.0), final(None, 2.0))
    assert not np.array_equal(final(5.0, 2.0), final(5.0, None))
    # Also before the first step, and for a law written in Python.
    beam.event = [tt.Event(at=0.0, set={"damping.mass_damping": 5.0})]
    session = tt.Session(beam)
    session.set({"damping.mass_damping": 1.0})
    session.step(20)
    beam.event = []
    beam.damping = tt.Damping(mass_damping=1.0)
    other = tt.Session(beam)
    other.step(20)
    assert np.allclose(session.positions, other.positions, rtol=0, atol=1e-9)


def test_a_session_goes_on_after_a_later_end(beam):
    session = tt.Session(beam)
    session.run()
    assert session.status == "ok" and session.step(1) == 0
    session.apply(tt.SetTime(end=0.1))  # not later: nothing to do
    assert session.status == "ok" and session.step(1) == 0
    session.apply(tt.SetTime(end=0.3))
    assert session.status == "running"
    assert session.step(1000) == 50
    assert session.status == "ok" and session.time == pytest.approx(0.3)
    assert len(session.history["step"]) == 151


DAEMON = """
import threading, time
import numpy as np
import tetraction as tt
scene = tt.Scene(
    mesh={"generate": {"kind": "beam", "size": [1.0, 0.2, 0.2], "cells": [12, 4, 4]}},
    material=tt.Material(model="neo-hookean", youngs_modulus=1e5, poissons_ratio=0.3, density=1000),
    time=tt.Time(integrator="midpoint", step=1e-5, end=100.0),
    environment=tt.Environment(kind="gravity"))
started = threading.Event()
def field():
    zero = lambda m, q: np.zeros(len(m))
    return tt.ForceField(zero, lambda m, q: np.zeros((len(m), 3)), lambda m, q: np.zeros((len(m), 3, 3)))
def work(kind):
    if kind == "field":
        scene.force_field = [field()]
    session = tt.Session(scene)
    started.set()
    if kind == "run":
        session.run(observers=[lambda s: None])
    elif kind == "loop":
        while True:
            session.step()
    else:
        session.step(10**9)
thread = threading.Thread(target=work, args=("KIND",), daemon=True)
thread.start()
started.wait()
time.sleep(0.3)
"""


@pytest.mark.parametrize("kind", ["step", "run", "loop", "field"])
def test_a_daemon_thread_within_a_step_does_not_abort_the_interpreter(kind):
    for _ in range(3):
        result = subprocess.run([sys.executable, "-c", DAEMON.replace("KIND", kind)], timeout=120,
                                capture_output=True, text=True)  # fmt: skip
        assert result.returncode == 0, result.stderr
        assert result.stderr == ""


class Stop(Exception):
    pass


def files_of_a_run(folder):
    assert (folder / "final.vtu").exists()
    return json.loads((folder / "summary.json").read_text())


@pytest.mark.parametrize("every", [0, 3])
@pytest.mark.filterwarnings("ignore:The run has no checkpoint files")
def test_an_edited_run_that_ends_early_has_all_its_files(beam, tmp_path, every):
    beam.output.checkpoint_every = every

    def edited():
        session = tt.Session(beam)
        session.apply(tt.SetDamping(viscosity=5.0))
        return session

    def stop(s):
        if s.step_number == 7:
            raise Stop("enough")

    with pytest.raises(Stop, match="enough"):
        edited().run(observers=stop, out=tmp_path / "exception")
    assert files_of_a_run(tmp_path / "exception")["steps"] == 7
    assert edited().run(observers=lambda s: s.step_number < 9, out=tmp_path / "false") == "interrupted"
    assert files_of_a_run(tmp_path / "false")["steps"] == 9
    assert edited().run(out=tmp_path / "end") == "ok"
    assert files_of_a_run(tmp_path / "end")["status"] == "ok"
    # An edit within the run: no checkpoint is left from which it would go on in another way.
    def late(s):
        if s.step_number == 10:
            s.apply(tt.SetDamping(viscosity=5.0))
        return s.step_number < 20

    assert tt.Session(beam).run(observers=late, out=tmp_path / "late") == "interrupted"
    assert not (tmp_path / "late" / "checkpoints").exists()
    assert files_of_a_run(tmp_path / "late")["steps"] == 20


def test_checkpoint_files_that_cannot_be_made_are_told(beam, tmp_path):
    beam.output.checkpoint_every = 3
    session = tt.Session(beam)
    session.apply(tt.SetDamping(viscosity=5.0))
    with pytest.warns(UserWarning, match="no checkpoint files"):
        assert session.run(out=tmp_path / "edited") == "ok"
    assert tt.Session(beam).run(observers=lambda s: s.step_number < 7, out=tmp_path / "plain") == "interrupted"
    names = sorted(os.listdir(tmp_path / "plain" / "checkpoints"))
    assert names == ["step_000000003.ckpt", "step_000000006.ckpt", "stop_000000007.ckpt"]
    # Equilibria have none, and say so by having none.
    assert tt.static(beam, tmp_path / "static").status == "ok"
    files_of_a_run(tmp_path / "static")


@pytest.mark.skipif(sys.version_info < (3, 11), reason="exceptions have no notes")
def test_an_exception_is_not_replaced_by_one_of_the_files(beam, tmp_path):
    def stop(s):
        if s.step_number == 3:
            (tmp_path / "out" / "final.vtu").mkdir()
            raise Stop("enough")

    with pytest.raises(Stop, match="enough") as caught:
        tt.Session(beam).run(observers=stop, out=tmp_path / "out")
    assert "final.vtu" in caught.value.__notes__[0]
