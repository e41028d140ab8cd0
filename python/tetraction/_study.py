"""Step-size studies."""

import csv
import html
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _scene
from ._mesh import Mesh, mesh_of
from ._toml import value_text

_Path = str | os.PathLike[str]
_Step = float | str
_Steps = Sequence[_Step] | NDArray[Any] | Mapping[str, _Step | Sequence[_Step] | NDArray[Any]]

# The columns of study.csv that are texts; the others are numbers.
_TEXTS = ("integrator", "status", "variant", "role", "solver", "settings", "date", "processor", "version",
          "command", "reference", "timing")  # fmt: skip


class ProbeSeries(NamedTuple):
    """The values of a probe at the times (m,) of a run: an array of the shape (m, w)."""

    times: NDArray[np.float64]
    values: NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """The motion of a run of a study, for an error function of your own.

    Attributes
    ----------
    integrator : str
    step : float
        s.
    times : array (k,)
        s: the same for all runs of a study, up to its end. Between its steps a run is interpolated by cubics.
    positions : array (k, n, 3)
        m.
    rest : array (n, 3)
        Positions at rest, m.
    probes : dict of ProbeSeries
        By the names of the probes, at the steps of the run.
    """

    integrator: str
    step: float
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    rest: NDArray[np.float64]
    probes: dict[str, ProbeSeries]

    @property
    def end(self) -> NDArray[np.float64]:
        """The positions at the end, (n, 3)."""
        return self.positions[-1]


_ErrorFunction = Callable[[Motion, Motion], float]


class Study:
    """The result of a step-size study.

    ``print(study)`` shows its answer, as a notebook does. For each plot of ``tetraction study`` there is a method:
    ``plot_error_over_step``, ``plot_work_precision``, … (docs/outputs.md), and ``plot_probe(name="tip")``. They draw
    into the given axes or a new figure, and return the axes. Plots over time need the directory of a study.

    Attributes
    ----------
    array : structured array
        One row for each run: integrator, step, status, position_error and all other columns of study.csv
        (docs/outputs.md), and custom_error if the study had an error function.
    answer : str
        What the command prints: for each rule the cheapest run that meets an error, and what follows from it.
    conclusions : list of str
        What follows from the numbers.
    searched : list of dict
        What the search for steps found for each rule: `target` and `stability` (docs/outputs.md).
    stable_step : float
        The stability limit of explicit steps, s.
    data : dict
        The content of study.json.
    directory : str or None
        Where its files are.
    """

    def __init__(self, texts: dict[str, str], directory: str | None, custom_errors: Sequence[float] = ()) -> None:
        self.data: dict[str, Any] = json.loads(texts["json"])
        self.answer = texts["answer"]
        self.directory = directory
        self._table = texts["html"]
        data = self.data
        self.conclusions: list[str] = [s for entry in data["conclusions"] for s in entry["sentences"]]
        self.searched: list[dict[str, Any]] = data.get("searched", [])
        self.stable_step: float | None = data["stable_step"]
        columns = _columns(texts["csv"])
        if len(custom_errors):
            columns["custom_error"] = np.array(custom_errors)
        self.array = _structured(columns)

    @property
    def table(self) -> NDArray[Any]:
        """The same as `array`."""
        return self.array

    def to_pandas(self) -> Any:
        """The rows of `array` as a DataFrame of pandas. Raises ImportError if pandas is not installed."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("Study.to_pandas needs pandas, which cannot be imported. Install it, or use "
                              "Study.array, which has the same columns.") from error  # fmt: skip
        return pandas.DataFrame({name: self.array[name] for name in self.array.dtype.names or ()})

    def __str__(self) -> str:
        return self.answer

    def __repr__(self) -> str:
        return f"<Study of {len(self.array)} runs>"

    def _repr_html_(self) -> str:
        sentences = (entry["sentences"][0] for entry in self.data["conclusions"] if entry["sentences"])
        return self._table + "".join(f"<p>{html.escape(sentence)}</p>" for sentence in sentences)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        function = _plots().get(name) if name.startswith("plot_") else None
        if function is None:
            raise AttributeError(f"A Study has no attribute {name!r}.")
        drawing = function

        def draw(axes: Any = None, **choice: Any) -> Any:
            plots = _plot_module()
            try:
                drawn = drawing(plots.study_of(self.data, self.directory or os.devnull), axes, **choice)
            except plots.Unusable as error:
                raise _core.InputError(f"{name}: {error}") from None
            if drawn is None:
                raise _core.InputError(
                    f"{name}: this study has nothing to draw there. Plots over time and of shapes need its runs in a "
                    "directory: give `out`.")
            return drawn[0] if len(drawn) == 1 else drawn

        draw.__name__, draw.__doc__ = name, drawing.__doc__
        return draw

    def __dir__(self) -> Iterable[str]:
        try:
            return [*super().__dir__(), *_plots()]
        except ImportError:  # without matplotlib there are none
            return super().__dir__()

    def plot(self, column: str = "position_error", axes: Any = None) -> Any:
        """Draws a column over the step, a line for each integrator, and returns the axes of matplotlib."""
        import matplotlib.pyplot as plt

        if axes is None:
            _, axes = plt.subplots()
        for integrator in dict.fromkeys(self.array["integrator"]):
            rows = self.array[self.array["integrator"] == integrator]
            rows = np.sort(rows[(rows["status"] == "ok") & (rows[column] > 0)], order="step")
            axes.loglog(rows["step"], rows[column], "o-", label=integrator)
        if self.stable_step:
            axes.axvline(self.stable_step, color="gray", linestyle=":", label="stability limit")
        axes.set_xlabel("step [s]")
        axes.set_ylabel(column.replace("_", " "))
        axes.legend()
        return axes

    def write_plots(self) -> None:
        """Draws the plots of ``tetraction study`` into its directory, as PNG, SVG and PDF files."""
        if self.directory is None:
            raise _core.InputError("The study has no directory: give `out`, since plots need its runs.")
        script = os.path.join(os.path.dirname(__file__), "_study_plots")
        subprocess.run([sys.executable, script, self.directory], check=True)


def study(scene: _scene.Scene | _Path, integrators: Sequence[str] = (), steps: _Steps | None = None, *,
          budget: float | str = "1min", target: float | str | None = None,
          error: str | _ErrorFunction = "positions", vary: Mapping[str, Sequence[Any] | str] | None = None,
          rules: Sequence[str] = (), also_solver: Sequence[str] = (), reference: str = "run",
          reference_step: float | None = None, reference_integrator: str | None = None, out: _Path | None = None,
          fresh: bool = False, frames: bool = False, jobs: int = 1, repeats: int = 2, mesh_check: bool = False,
          part: str = "", plan: bool = False, points: ArrayLike | None = None, tetrahedra: ArrayLike | None = None,
          mesh: Mesh | None = None, copy: bool = True, error_probe: str = "",
          progress: Callable[[int, int, str, float], object] | None = None) -> Any:  # fmt: skip
    """Runs a scene with several integrators and steps, and compares each run with a reference.

    The arguments are those of ``tetraction study`` (docs/outputs.md). In a notebook a table shows the runs while they
    are made. Ctrl-C ends a run after its present step and raises KeyboardInterrupt. With `out` the same call then goes
    on: runs that are complete stay, and none is made twice.

    Parameters
    ----------
    scene : Scene or path-like
    integrators : sequence of str
        Without any: all, or those that `steps` names.
    steps : sequence or dict, optional
        Steps of all integrators, or a dict with those of each: numbers of seconds, "4x" (times h_crit), "0.02T"
        (times the excited period) or "auto". Without any the study chooses them.
    budget : float or str
        Time for what the study chooses itself, as "2min" or in seconds.
    target : float or str, optional
        Finds the largest step of each integrator whose error is at most this, as 0.01 or "1%".
    error : str or function
        "positions", "probe.NAME", "peak.probe.NAME" or "frequency.probe.NAME": the error that orders, steps and the
        answer are about. A function of two Motions, of a run and of its reference, is called after all runs. Its
        values are the column custom_error of the result, NaN where a run did not reach the end; all else is about
        positions, and the files do not have them. With reference="richardson" it gets the finest of the three runs.
    vary : dict, optional
        Values for keys of the scene, as {"material.density": [900, 1000]}: makes the study with all combinations.
    rules : sequence of str
        "INTEGRATOR:KEY=VALUE,…": each is one more rule with settings of its own of [solver] or [time], as
        "midpoint:solver.tolerance=1e-6". It has the steps of its integrator.
    also_solver : sequence of str
        "SOLVER@STEP": each adds a run with another solver.
    reference : str
        "run", or "richardson": the extrapolation of three runs, with an estimate of its error.
    reference_step : float, optional
        Seconds; by default the finest step, or chosen with the steps.
    reference_integrator : str, optional
        By default midpoint, or chosen with the steps.
    out : path-like, optional
        A directory for the files of the runs, study.csv, study.json and study.html. Runs there are taken over if they
        computed the same with this build of the package, unless functions of the scene are written in Python.
    fresh : bool
        Deletes what an earlier study has left in `out`.
    frames : bool
        Whether all runs write frames.
    jobs : int
        Number of runs that are made at the same time.
    repeats : int
        How often short runs are made again, to see how much their times vary, within a tenth of `budget`.
    mesh_check : bool
        Makes one run on a mesh with half the edges, too, which tells the error of the mesh: Study.data["mesh_check"].
    part : str
        "K/N": makes only every N-th run, as job K of N. ``tetraction study merge`` joins the directories of the parts,
        and those of other studies of the same scene. It cannot join studies with functions in Python.
    plan : bool
        Makes no runs but those that the choice of steps needs, writes nothing, and returns the plan: a structured array
        with a row for each run, its number of steps, and the seconds that it is estimated to take.
    points, tetrahedra, mesh, copy
        As in Session.
    error_probe : str
        The same as error="probe.NAME".
    progress : function, optional
        Called before each run with its number, the number of runs, the integrator and the step.

    Returns
    -------
    Study, or a structured array with `plan`
    """
    own = (scene if isinstance(scene, _scene.Scene) else _scene.read_scene(scene)).copy()
    core_mesh, _arrays = mesh_of(points, tetrahedra, mesh, copy)
    out = None if out is None else os.fspath(out)
    if error_probe:
        if error != "positions":
            raise _core.InputError("study: error and error_probe exclude each other: give error alone.")
        error = f"probe.{error_probe}"
    if not (isinstance(jobs, int) and 1 <= jobs <= 1024):
        raise _core.InputError(f"study: jobs must be a number from 1 to 1024, not {jobs!r}.")
    if not (isinstance(repeats, int) and 0 <= repeats <= 100):
        raise _core.InputError(f"study: repeats must be a number from 0 to 100, not {repeats!r}.")
    live = None if plan else _LiveTable.in_notebook()
    arguments = {
        "integrators": list(integrators), "steps": _step_texts(steps),
        "budget": budget if isinstance(budget, str) else f"{float(budget)!r}s",
        "target": "" if target is None else target if isinstance(target, str) else repr(float(target)),
        "error": "positions" if callable(error) else error,
        "custom_error": _custom_error(error) if callable(error) else None,
        "vary": [_vary_text(key, values) for key, values in (vary or {}).items()],
        "rules": list(rules), "also_solver": list(also_solver), "repeats": repeats, "mesh_check": bool(mesh_check),
        "part": part,
        "reference": reference, "reference_step": reference_step,
        "reference_integrator": reference_integrator or "", "out": out or "",
        "name": os.path.splitext(own._name)[0], "fresh": bool(fresh), "frames": bool(frames),
        "jobs": jobs, "plan": bool(plan), "progress": progress, "made": live.add if live else None,
        # Nothing tells whether functions are the same as in an earlier call.
        "keeps_runs": not (own.force_field or isinstance(own.material, _scene.CustomMaterial)
                           or any(region.material is not None for region in own.material_region)),
    }  # fmt: skip

    def read(overrides: list[str]) -> Any:
        return own._compiled(has_mesh=core_mesh is not None, overrides=overrides)

    with _names_of_arguments(), own._messages():
        made = _core.study(read, core_mesh, arguments)
    if plan:
        return _structured({name: np.array([line[name] for line in made]) for name in made[0]})
    result = Study(made[0], out, made[1])
    if live:
        live.finish(result.data)
    return result


def read_study(directory: _Path) -> Study:
    """Reads the result of ``tetraction study`` or :func:`study` from its directory.

    Raises InputError if there is no study, if it has not ended, or if its study.json is damaged.
    """
    directory = os.fspath(directory)
    return Study(_core.read_study(directory), directory)


class _LiveTable:
    """The runs of a study in a notebook, while they are made."""

    def __init__(self, display: Callable[..., Any], html_type: Callable[[str], Any]) -> None:
        self._html_type = html_type
        self._rows: list[dict[str, Any]] = []
        self._handle = display(html_type("<p>The study begins.</p>"), display_id=True)

    @staticmethod
    def in_notebook() -> "_LiveTable | None":
        if "IPython" not in sys.modules:
            return None
        from IPython import get_ipython
        from IPython.display import HTML, display

        return _LiveTable(display, HTML) if hasattr(get_ipython(), "kernel") else None

    def add(self, row: str) -> None:
        self._rows.append(json.loads(row))
        self._show(self._rows, "position_error")

    def finish(self, data: dict[str, Any]) -> None:
        self._show(data["runs"], "position_error" if data["error"] == "position" else "probe_error")

    def _show(self, runs: list[dict[str, Any]], error: str) -> None:
        head = ["rule", "step [s]", "role", "status", "steps", "wall [s]", "energy", "error"]
        rows = [[f"{run['integrator']} {run['variant']}".strip(), _number(run["step"]), run["role"], run["status"],
                 str(run["steps"]), _number(run["wall_seconds"]), _number(run["max_relative_energy_drift"]),
                 _number(run[error])] for run in runs]  # fmt: skip
        self._handle.update(self._html_type(_html_table(head, rows)))


@contextmanager
def _names_of_arguments() -> Iterator[None]:
    """Messages of the command name its options: --reference-step is the argument reference_step."""
    try:
        yield
    except _core.InputError as error:
        text = re.sub(r"--([a-z][a-z-]*)", lambda option: option[1].replace("-", "_"), str(error))
        raise _core.InputError(text) from None


def _step_list(steps: Any) -> str:
    items = [steps] if isinstance(steps, str) or np.ndim(steps) == 0 else steps
    return ",".join(step if isinstance(step, str) else repr(float(step)) for step in items)


def _step_texts(steps: _Steps | None) -> list[str]:
    if isinstance(steps, Mapping):
        return [f"{rule}={_step_list(own)}" for rule, own in steps.items()]
    return [] if steps is None or len(steps) == 0 else [_step_list(steps)]


def _vary_text(key: str, values: Sequence[Any] | str) -> str:
    if isinstance(values, str):
        return f"{key}={values}"
    return f"{key}=" + ",".join(
        value if isinstance(value, str) and re.fullmatch(r"[A-Za-z][\w-]*", value) else value_text(value)
        for value in values)  # fmt: skip


def _custom_error(function: _ErrorFunction) -> Callable[[dict[str, Any], dict[str, Any]], float]:
    def motion(values: dict[str, Any]) -> Motion:
        probes = {name: ProbeSeries(*series) for name, series in values.pop("probes").items()}
        return Motion(**values, probes=probes)

    return lambda run, reference: float(function(motion(run), motion(reference)))


def _columns(text: str) -> dict[str, NDArray[Any]]:
    """The columns of study.csv. Those of numbers are float64; empty is NaN."""
    head, *rows = csv.reader(io.StringIO(text, newline=""))
    columns: dict[str, NDArray[Any]] = {}
    for i, name in enumerate(head):
        values = [row[i] for row in rows]
        columns[name] = np.array(values, dtype=str) if name in _TEXTS else np.array(
            [float(value) if value else np.nan for value in values])  # fmt: skip
    return columns


def _structured(columns: dict[str, NDArray[Any]]) -> NDArray[Any]:
    count = len(next(iter(columns.values())))
    table = np.empty(count, dtype=[(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table


def _plot_module() -> Any:
    """The module of the plots. Raises ImportError without matplotlib."""
    from ._study_plots import plots

    return plots


def _plots() -> dict[str, Callable[..., Any]]:
    """The functions of all plots by the names of their methods."""
    return {name: plot for name, plot in vars(_plot_module()).items() if name.startswith("plot_")}


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _html_table(head: list[str], rows: list[list[str]]) -> str:
    def line(cells: list[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    return f"<table><thead>{line(head, 'th')}</thead><tbody>{''.join(line(r, 'td') for r in rows)}</tbody></table>"
