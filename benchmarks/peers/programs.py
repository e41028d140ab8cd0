"""The programs that compute the beam of beam.py: how each is found, built and started."""

import json
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TREE = HERE.parent.parent


class Missing(Exception):
    """A program cannot be run here; the text says what to do about it."""


class Failed(Exception):
    """A program or a build failed; the text has its last messages."""


def call(command, **options):
    """Standard output of a command. Throws Failed with the end of what it printed if it fails."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        lines = (done.stdout + done.stderr).splitlines()
        raise Failed(f"{' '.join(map(str, command))} failed:\n" + "\n".join(lines[-15:]))
    return done.stdout


class Program:
    """One of the programs. The first of the solvers is the fastest on M and L."""

    name = ""
    solvers = ()

    def prepare(self, folder):
        """Returns the command that computes a beam, without the file of it. Throws Missing."""
        raise NotImplementedError


class Tetraction(Program):
    name = "tetraction"
    solvers = ("auto",)

    def __init__(self, path=None):
        self.path = path

    def prepare(self, folder):
        if self.path:
            return [Path(self.path).resolve()]
        call(["cmake", "--preset", "release"], cwd=TREE)
        call(["cmake", "--build", "--preset", "release", "--target", "tetraction_beam"], cwd=TREE)
        return [TREE / "build/release/bin/tetraction_beam"]


class DealII(Program):
    name = "deal.II"
    solvers = ("ssor", "jacobi", "amg")

    def prepare(self, folder):
        build = folder / "dealii"
        try:
            call(["cmake", "-S", HERE / "dealii", "-B", build])
        except Failed as failed:
            if "deal.II is not installed." in str(failed):
                raise Missing(
                    "deal.II is not installed (9.4 or later): apt-get install --no-install-recommends libdeal.ii-dev"
                ) from failed
            raise
        call(["cmake", "--build", build])
        return [build / "dealii_beam"]


class Dolfinx(Program):
    name = "dolfinx"
    solvers = ("icc", "gamg", "jacobi")

    def prepare(self, folder):
        # Debian's own Python has Debian's modules.
        for python in (sys.executable, "/usr/bin/python3"):
            check = "import dolfinx.fem.petsc, sys; sys.exit(not dolfinx.__version__.startswith('0.5.'))"
            found = subprocess.run([python, "-c", check], capture_output=True, check=False)
            if found.returncode == 0:
                return [python, HERE / "dolfinx_beam.py"]
        raise Missing(
            "dolfinx is not installed (0.5, that of Debian 12): "
            "apt-get install --no-install-recommends python3-dolfinx-real"
        )


PEERS = (DealII(), Dolfinx())


def environment(folder):
    """One thread everywhere, and no process of Open MPI beside it. dolfinx keeps what it compiles in the folder."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMPI_MCA_ess_singleton_isolated")
    others = {"XDG_CACHE_HOME": str(folder / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    return {**os.environ, **dict.fromkeys(names, "1"), **others}


def measure(command, file, solver, folder):
    """What the program says of the beam in the file: the dictionary that beam.h and dolfinx_beam.py print."""
    arguments = [] if solver == "auto" else [solver]
    lines = call([*command, file, *arguments], env=environment(folder)).splitlines()
    return json.loads(lines[-1])
