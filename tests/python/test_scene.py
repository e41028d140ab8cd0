"""Scenes: keys, defaults, messages, and that they are those of scene files."""

import math
import os
import tomllib

import numpy as np
import pytest

import tetraction as tt

SCENES = os.environ["TETRACTION_SCENES"]


def test_defaults_are_those_of_the_scene_file():
    assert tt.Time().integrator == "midpoint"
    assert tt.Solver().tolerance == 1e-8
    assert tt.Fix().components == "xyz"
    assert tt.Material().youngs_modulus is None
    assert tt.Damping().viscosity == 0.0


def test_an_unknown_key_is_refused_with_the_nearest_one():
    with pytest.raises(tt.InputError, match="youngs_modulus"):
        tt.Material(young_modulus=1e6)
    material = tt.Material()
    with pytest.raises(tt.InputError, match="density"):
        material.densty = 1
    with pytest.raises(tt.InputError, match="no section 'materials'"):
        tt.Scene(materials={})


def test_values_are_checked_when_the_scene_is_used(beam):
    beam.time.step = -1.0
    with pytest.raises(tt.InputError, match="time.step = -1.* above 0"):
        tt.Session(beam)
    beam.time.step = 1e-3
    beam.fix[0].select = {"plane": {"axis": "x", "at": 77.0}}
    with pytest.raises(tt.InputError, match="^fix.0: the selection selects no vertex"):
        tt.Session(beam)


def test_docstrings_name_keys_units_and_defaults():
    text = tt.Material.__doc__
    assert "youngs_modulus : number" in text and "Pa" in text
    assert "step" in tt.Time.__doc__ and "`" not in tt.Time.__doc__.split("\n")[4]


@pytest.mark.parametrize("name", sorted(n for n in os.listdir(SCENES) if n.endswith(".toml")))
def test_every_example_reads_and_means_the_same(name):
    path = os.path.join(SCENES, name)
    scene = tt.read_scene(path)
    again = tomllib.loads(scene.to_toml())
    expected = tomllib.loads(tt._core.Scene.read(path).text(SCENES))
    assert again == expected


def test_overrides(beam, tmp_path):
    path = tmp_path / "beam.toml"
    path.write_text(beam.to_toml())
    scene = tt.read_scene(path, {"time.step": 5e-4, "material.model": "stvk"})
    assert scene.time.step == 5e-4 and scene.material.model == "stvk"
    scene = tt.read_scene(path, ["fix.0.components=xy"])
    assert scene.fix[0].components == "xy"
    with pytest.raises(tt.InputError, match="--set time.stp"):
        tt.read_scene(path, ["time.stp=1"])


def test_messages_about_files_name_the_line(tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text("[time]\nstep = 'x'\n")
    with pytest.raises(tt.InputError, match="wrong.toml:"):
        tt.read_scene(path)
    with pytest.raises(tt.FileError, match="none.toml"):
        tt.read_scene(tmp_path / "none.toml")


def test_any_value_reaches_the_reader(beam):
    beam.force.append(tt.Force(select={"all": True}, vector=np.array([0.0, 1e-300, 3]), until=math.inf))
    beam.selection["tip"] = {"plane": {"axis": "x", "at": 1.0}}
    beam.probe.append(tt.Probe(name="tip", select="tip", quantity="displacement"))
    beam.initial.momentum = [tt.Momentum(select="tip", value=(0, 0, 1))]
    beam.output.directory = 'a "quoted" \u00fc\t\u007f name'
    tables = tomllib.loads(beam.to_toml())
    assert tables["force"][0]["vector"] == [0.0, 1e-300, 3.0]
    assert tables["output"]["directory"] == beam.output.directory
    assert tables["initial"]["momentum"][0]["value"] == [0.0, 0.0, 1.0]
    with pytest.raises(TypeError, match="object"):
        tt.Scene(mesh={"file": object()})._compiled()


def test_copies_are_independent(beam):
    other = beam.copy()
    other.fix[0].components = "z"
    other.time.end = 9.0
    assert beam.fix[0].components == "xyz" and beam.time.end == 0.2


def test_misspelt_sections_are_refused():
    scene = tt.Scene()
    for name in ("enviroment", "forces", "timestep"):
        with pytest.raises(tt.InputError, match="no section"):
            setattr(scene, name, {})
    for name, value in (("time", 3), ("fix", None), ("force", ["x"])):
        with pytest.raises(tt.InputError):
            setattr(scene, name, value)


def test_defaults_cannot_be_changed_in_place():
    with pytest.raises(TypeError):
        tt.Scene().environment.direction[0] = 1.0


def test_overrides_add_entries(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text('[mesh]\ngenerate = { kind = "tetrahedron" }\n[material]\nyoungs_modulus = 1e5\n'
                    "poissons_ratio = 0.3\n[time]\nend = 1.0\n")
    scene = tt.read_scene(path, ["force.0={ select={ all=true }, vector=[0,0,1] }", "probe.0.name=a",
                                 "probe.0.quantity=position", "probe.0.select={ all=true }"])  # fmt: skip
    assert scene.force[0].vector == [0, 0, 1] and scene.probe[0].name == "a"


def test_text_of_a_generated_mesh_keeps_its_elements():
    for keys in ({"element": "quadratic"}, {"volume": "nodal"}):
        scene = tt.Scene(mesh={"generate": {"kind": "cube", "size": 1.0, "cells": 1}, **keys},
                         material={"youngs_modulus": 1e5, "poissons_ratio": 0.3},
                         time={"end": 1.0})  # fmt: skip
        mesh = tomllib.loads(scene.to_toml())["mesh"]
        assert {key: mesh.get(key) for key in keys} == keys
