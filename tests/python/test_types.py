"""The types of the package, for editors and type checkers."""

import os
import subprocess
import sys

import pytest

import tetraction

pytest.importorskip("mypy", reason="mypy is not installed")

PACKAGE = os.path.dirname(tetraction.__file__)
SETTINGS = """\
[mypy]
strict = True
warn_return_any = False
ignore_missing_imports = True
[mypy-tetraction._study_plots.*]
ignore_errors = True
"""


def check(folder, *arguments):
    path = folder / "mypy.ini"
    path.write_text(SETTINGS)
    environment = {**os.environ, "MYPYPATH": os.path.dirname(PACKAGE)}
    return subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", path, "--cache-dir", folder / "cache", *arguments],
        cwd=folder, env=environment, capture_output=True, encoding="utf-8")  # fmt: skip


def test_the_package_has_types_throughout(tmp_path):
    result = check(tmp_path, "-p", "tetraction")
    assert result.returncode == 0, result.stdout + result.stderr


def test_a_program_is_checked_with_them(tmp_path):
    (tmp_path / "program.py").write_text("""\
import numpy as np
import tetraction as tt

scene = tt.Scene(time=tt.Time(integrator="midpoint", step="auto", end=1.0))
scene.time.step = 1e-3
scene.fix.append(tt.Fix(select={"all": True}, velocity=[0, 0, 1]))
session = tt.Session(scene, points=np.zeros((4, 3)), tetrahedra=[[0, 1, 2, 3]])
count: int = session.step(10)
speed = np.linalg.norm(session.velocities, axis=1)
session.apply(tt.SetTime(step=1e-4))
""")
    result = check(tmp_path, "program.py")
    assert result.returncode == 0, result.stdout + result.stderr
    (tmp_path / "wrong.py").write_text("""\
import tetraction as tt

tt.Time(stepp=1.0)
tt.Time(end="soon")
tt.Session(tt.Scene()).step("many")
tt.Scene().time.steps
""")
    result = check(tmp_path, "wrong.py")
    lines = {line.split(":")[1] for line in result.stdout.splitlines() if ": error:" in line}
    assert lines == {"3", "4", "5", "6"}, result.stdout


def test_every_key_of_the_settings_has_a_type():
    with open(os.path.join(PACKAGE, "_settings.pyi"), encoding="utf-8") as file:
        text = file.read()
    for name in ("Material", "Time", "Solver", "Fix", "Event", "Output"):
        body = text.split(f"class {name}(Settings):\n")[1].split("class ")[0]
        for key in getattr(tetraction, name)._keys:
            assert f"    {key}: " in body or key in ("lambda", "from"), f"{name}.{key}"
