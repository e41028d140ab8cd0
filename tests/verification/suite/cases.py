"""A case: its description, its runs, and what they are compared with."""

import dataclasses
import math
import os
import tomllib

from meshes import write_mesh
from quantities import KINDS

SETTINGS = {
    "linear": {"mesh.element": "linear", "mesh.volume": "element"},
    "nodal": {"mesh.element": "linear", "mesh.volume": "nodal"},
    "quadratic": {"mesh.element": "quadratic", "mesh.volume": "element"},
}


@dataclasses.dataclass
class Value:
    """One quantity of one run."""

    variant: str
    element: str
    cells: list
    tetrahedra: int
    unknowns: int
    quantity: str
    unit: str
    value: float
    reference: float | None
    deviation: float | None  # relative; the difference where the quantity is `absolute`
    absolute: bool
    within: float | None     # asserted: the largest deviation
    beyond: float | None     # asserted: the least magnitude of the deviation
    at_least: float | None   # asserted: the least value
    is_reference: bool       # whether the reference was computed with this very mesh
    folder: str

    @property
    def is_asserted(self):
        return any(bound is not None for bound in (self.within, self.beyond, self.at_least))

    @property
    def holds(self):
        if self.within is not None and not abs(self.deviation) <= self.within:
            return False
        if self.at_least is not None and not self.value >= self.at_least:
            return False
        return self.beyond is None or abs(self.deviation) >= self.beyond


@dataclasses.dataclass
class Order:
    """The order of convergence in space, from the two finest meshes of an element."""

    variant: str
    element: str
    quantity: str
    value: float
    at_least: float
    is_asserted = True

    @property
    def holds(self):
        return self.value >= self.at_least


def number_of_cells(text, cells):
    """The value of a setting: a formula of the number n of cells along the first direction."""
    return eval(text, {"__builtins__": {}}, {"n": cells})


def by_cells(table, run):
    """The settings of a case or variant that depend on the mesh, with their values for a run."""
    n = cells_of(run)[0]
    return {key: [number_of_cells(part, n) for part in text] if isinstance(text, list)
            else number_of_cells(text, n) for key, text in table.get("by_cells", {}).items()}


def cells_of(run):
    """A cube has one number of cells."""
    return run["cells"] if isinstance(run["cells"], list) else [run["cells"]]


class Case:
    def __init__(self, folder):
        self.folder = folder
        self.name = os.path.basename(folder)
        with open(os.path.join(folder, "case.toml"), "rb") as file:
            self.table = tomllib.load(file)
        self.scene = os.path.normpath(os.path.join(folder, self.table.get("scene", "scene.toml")))

    def write_shipped_mesh(self, folder):
        """The mesh with which the scene runs by itself; returns its path, or None if it generates one."""
        if "shipped" not in self.table:
            return None
        shipped = self.table["shipped"]
        path = os.path.join(folder, shipped["file"])
        write_mesh(path, self.table["mesh"], shipped["cells"], shipped["element"])
        return path

    def variants(self, run):
        everything = self.table.get("variant", [{"name": "", "set": {}}])
        return [v for v in everything if v["name"] in run.get("variants", [v["name"]])]

    def quantities(self, run, variant):
        for quantity in self.table["quantity"]:
            if quantity["name"] not in run.get("quantities", [quantity["name"]]):
                continue
            if variant["name"] in quantity.get("variants", [variant["name"]]):
                yield quantity

    def runs(self, short):
        """Those of the full form, or those that are marked for the short form."""
        return [run for run in self.table["run"] if run.get("short") or not short]

    def execute(self, program, work, short, report=lambda value: None):
        """Makes all runs and returns their values and the orders of convergence."""
        values = []
        for run in self.runs(short):
            for variant in self.variants(run):
                for value in self.execute_one(program, work, run, variant):
                    values.append(value)
                    report(value)
        return values, list(self.orders(values))

    def execute_one(self, program, work, run, variant):
        settings = dict(SETTINGS[run["element"]])
        settings.update(by_cells(self.table, run))
        settings.update(variant["set"])
        settings.update(by_cells(variant, run))
        settings.update(run.get("set", {}))
        label = run["element"] + "-" + "x".join(map(str, cells_of(run)))
        os.makedirs(work, exist_ok=True)
        if "mesh" in self.table:
            mesh = os.path.join(os.path.abspath(work), label + ".msh")
            write_mesh(mesh, self.table["mesh"], run["cells"], run["element"])
            settings["mesh.file"] = mesh
        else:
            settings["mesh.generate.cells"] = run["cells"]
        folder = os.path.join(work, "-".join(filter(None, [variant["name"].replace(" ", "_"), label])))
        results = program.call(self.table["command"], self.scene, settings,
                               self.table.get("arguments", []) + variant.get("arguments", []), folder)
        for quantity in self.quantities(run, variant):
            yield self.compare(results, run, variant, quantity)

    def compare(self, results, run, variant, quantity):
        def of_this(table, key):
            """The entry of a key, which may be one for each quantity or variant."""
            entry = table.get(key)
            if isinstance(entry, dict):
                return entry.get(quantity["name"], entry.get(variant["name"]))
            return entry

        value = float(KINDS[quantity["kind"]](results, quantity) * quantity.get("scale", 1.0))
        reference = of_this(quantity, "reference")
        absolute = quantity.get("absolute", False)
        deviation = None
        if reference is not None:
            deviation = value - reference if absolute else value / reference - 1.0
        within = of_this(run, "within")
        if within is None:
            within = of_this(quantity, "within")
        sizes = results.summary
        return Value(variant["name"], run["element"], cells_of(run), sizes["mesh"]["tetrahedra"],
                     sizes["degrees_of_freedom"]["free"], quantity["name"], quantity.get("unit", ""),
                     value, reference, deviation, absolute, within, of_this(run, "beyond"),
                     quantity.get("at_least"),
                     run.get("is_reference", False), results.folder)

    def orders(self, values):
        for wanted in self.table.get("order", []):
            for variant in self.table.get("variant", [{"name": ""}]):
                if variant["name"] not in wanted.get("variants", [variant["name"]]):
                    continue
                series = sorted((v for v in values
                                 if (v.element, v.quantity, v.variant)
                                 == (wanted["element"], wanted["quantity"], variant["name"])),
                                key=lambda v: v.cells)
                if len(series) < 2:
                    continue  # the short form has one mesh only
                coarse, fine = series[-2:]
                slope = (math.log(abs(coarse.deviation / fine.deviation))
                         / math.log(fine.cells[0] / coarse.cells[0]))
                yield Order(variant["name"], wanted["element"], wanted["quantity"], slope,
                            wanted["at_least"])
