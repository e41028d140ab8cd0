"""The same bits for any number of threads."""

import sys
import time

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM_CLAMP, ProgramTest, main

# More vertices than one piece of the loops over vertices (2,048), in numbers that no vector divides.
BODY = """
[mesh]
generate = {{ kind = "beam", size = [4, 1, 1], cells = {cells} }}
[material]
{material}
[time]
integrator = "{integrator}"
step = {step}
end = {end}
{time}
[solver]
{solver}
[environment]
kind = "gravity"
[damping]
viscosity = {viscosity}
{constraints}
[initial]
angular_velocity = [0.3, 0.2, 0.5]
"""
NEO = 'model = "neo-hookean"\nyoungs_modulus = 1e6\npoissons_ratio = 0.4'
CLAMP = BEAM_CLAMP
END = 'select = { plane = { axis = "x", at = 4.0 } }'
CONSTRAINTS = {
    "none": "",
    "fix": CLAMP,
    "penalty": CLAMP + 'mode = "penalty"\npenalty = 1e6\n',
    "rigid": CLAMP + f'[[constraint]]\nkind = "rigid"\n{END}\n',
    "driven": CLAMP + f'[[constraint]]\nkind = "rigid"\n{END}\nangular_velocity = [3, 0, 0]\n',
    "distance": '[[constraint]]\nkind = "distance"\nvertices = [0, 100]\n',
    "pressure": CLAMP + f"[[pressure]]\n{END}\nvalue = 1e4\n",
}
MATERIALS = {
    "stvk": 'model = "stvk"\nyoungs_modulus = 1e6\npoissons_ratio = 0.3',
    "mooney": 'model = "mooney-rivlin"\nyoungs_modulus = 1e6\npoissons_ratio = 0.4\nratio = 0.3',
    "yeoh": 'model = "yeoh"\nc10 = 2e5\nc20 = -1e4\nc30 = 1e3\nkappa = 1e6',
}


class Threads(ProgramTest):
    def scene(self, name, integrator, step, steps, cells=(12, 13, 13), material=NEO, time="",
              solver="", viscosity=0, constraints=CLAMP, rest=""):  # fmt: skip
        end = steps * step if isinstance(step, float) else steps
        return self.write(f"{name}.toml", BODY.format(
            cells=list(cells), material=material, integrator=integrator,
            step=step if isinstance(step, float) else f'"{step}"', end=end, time=time,
            solver=solver, viscosity=viscosity, constraints=constraints) + rest)  # fmt: skip

    def bytes_of(self, folder, names):
        found = []
        for name in names:
            found.append(self.read_bytes(folder, name))
        return found

    def same(self, name, scene, command="run", names=("history.csv", "final.vtu"), *more):
        results = []
        for number, threads in enumerate((1, 2, 4)):
            folder = f"{name}-{number}"
            self.run_program(command, scene, "--out", self.path(folder), "--threads", str(threads),
                             *more)  # fmt: skip
            results.append(self.bytes_of(folder, names))
        for number, result in enumerate(results[1:]):
            for file, one, other in zip(names, results[0], result):
                self.assertEqual(one, other, f"{name}: {file}, run {number + 1}")

    def test_explicit_rules(self):
        for rule in ("explicit", "verlet"):
            for kind, text in CONSTRAINTS.items():
                with self.subTest(rule, constraints=kind):
                    scene = self.scene("s", rule, 1e-4, 10, viscosity=5, constraints=text)
                    self.same("e", scene)
            for name, text in MATERIALS.items():
                with self.subTest(rule, material=name):
                    self.same("e", self.scene("s", rule, 1e-4, 10, material=text))
            with self.subTest(rule, step="auto"):
                self.same("e", self.scene("s", rule, "auto", 3e-3))
            with self.subTest(rule, step="adapt"):
                self.same("e", self.scene("s", rule, 1e-4, 10, time='adapt = "error"'))

    def test_implicit_rules(self):
        for rule in ("midpoint", "backward-euler", "energy-momentum"):
            for kind, text in CONSTRAINTS.items():
                if kind == "distance" and rule == "energy-momentum":
                    continue  # its cost is that of midpoint
                with self.subTest(rule, constraints=kind):
                    scene = self.scene("s", rule, 1e-2, 1, viscosity=5, constraints=text)
                    self.same("i", scene)
            with self.subTest(rule, step="adapt"):
                self.same("i", self.scene("s", rule, 1e-2, 1, time='adapt = "error"'))

    def test_solvers(self):
        for rule, solver in (
            ("midpoint", 'linear = "matrix-free"'),
            ("midpoint", 'linear = "cg"'),
            ("midpoint", 'linear = "factor"'),
            ("energy-momentum", 'linear = "factor"'),
            ("midpoint", 'kind = "ceres"'),
        ):
            with self.subTest(rule, solver=solver):
                cells = (20, 6, 6) if "ceres" in solver else (12, 13, 13)
                self.same("l", self.scene("s", rule, 1e-2, 1, solver=solver, cells=cells))

    def test_other_commands(self):
        scene = self.scene("s", "midpoint", 1e-2, 1)
        self.same("static", scene, "static")
        self.same("modes", scene, "modes", ("modes.csv", "mode_01.vtu"), "-n", "3")
        self.same("study", scene, "study", ("midpoint-0.01/final.vtu", "midpoint-0.005/final.vtu"),
                  "--integrators", "midpoint", "--steps", "1e-2,5e-3", "--no-plots")  # fmt: skip


if __name__ == "__main__":
    main()
