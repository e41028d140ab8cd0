"""Equilibria, modes and meshes."""

import os
import subprocess
import sys

import numpy as np
import pytest

import tetraction as tt


def test_static(beam, tmp_path):
    session = tt.static(beam, tmp_path / "out")
    assert session.load_path["factor"] == 1.0
    weight = 9.81 * session.masses.sum()
    assert session.reactions.sum(axis=0) == pytest.approx([0, weight, 0], rel=1e-6, abs=1e-6 * weight)
    assert os.path.exists(tmp_path / "out" / "final.vtu")
    beam.fix = []
    with pytest.raises(tt.InputError, match="move along"):
        tt.static(beam)


def test_static_without_an_equilibrium(beam):
    beam.material.youngs_modulus = 10.0
    beam.environment.strength = 1e4
    with pytest.raises(tt.NumericalError):
        tt.static(beam)


def test_modes(beam):
    beam.mesh.element = "quadratic"
    modes = tt.modes(beam, 6)
    assert modes.kinds == ["elastic"] * 6 and (np.diff(modes.frequencies) >= 0).all()
    # Bending of a beam: 0.1615 t/L² √(E/ρ), less shear.
    assert modes.frequencies[0] == pytest.approx(0.1615 * 0.2 * np.sqrt(1e5 / 1e3), rel=0.1)
    assert modes.shapes.shape == (6, len(modes.positions), 3)
    beam.fix = []
    assert tt.modes(beam, 8).kinds == ["rigid"] * 6 + ["elastic"] * 2
    with pytest.raises(tt.InputError):
        tt.modes(beam, 0)


INTERRUPTED = """
import signal, os, threading, time
import tetraction as tt
scene = tt.Scene(mesh={"generate": {"kind": "beam", "size": [1.0, 0.2, 0.2], "cells": [60, 12, 12]}},
                 material=tt.Material(youngs_modulus=1e5, poissons_ratio=0.3, density=1000))
tt.modes(scene, 1)
def interrupt():
    time.sleep(1)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    tt.modes(scene, 9000)
except KeyboardInterrupt:
    tt.modes(scene, 1)  # can be used again
    print("interrupted")
"""


def test_an_interrupt_ends_the_search_of_modes():
    """The search for so many modes would take hours, in which no function of Python is called."""
    result = subprocess.run([sys.executable, "-c", INTERRUPTED], timeout=300, capture_output=True,
                            text=True)  # fmt: skip
    assert (result.returncode, result.stdout) == (0, "interrupted\n"), result.stderr


def test_meshes(tmp_path, beam):
    tt.run(beam, tmp_path / "out")
    mesh = tt.read_mesh(tmp_path / "out" / "final.vtu", scale=2.0)
    assert mesh.points.shape == (45, 3) and mesh.tetrahedra.shape == (96, 4)
    assert "displacement" in mesh.point_arrays and not mesh.is_quadratic
    with pytest.raises(tt.FileError, match="none.vtu"):
        tt.read_mesh(tmp_path / "none.vtu")


def test_equal_tetrahedra_are_refused(beam, cube):
    points, tetrahedra = cube
    again = np.vstack([tetrahedra, tetrahedra[2, [1, 2, 0, 3]]])
    with pytest.raises(tt.InputError, match="Tetrahedra 2 and 6 have the same vertices"):
        tt.Session(beam, points, again)
    with pytest.raises(tt.InputError, match="the same vertices"):
        tt.Mesh(points, again.astype(np.int32))
