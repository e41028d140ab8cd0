"""How runs in several processes end."""

import os
import re
import signal
import subprocess
import sys
import time

sys.path.insert(0, f"{sys.path[0]}/..")
from support.parallel import (BODY, LOADS, OUTPUT, PROCESSES, ENVIRONMENT, ParallelTest, points_of,
    symmetric_column, time_of)
from support.program import PROGRAM, main, sets
from support.scenes import plane, tables


class Endings(ParallelTest):
    def scene(self, extra="", steps=40):
        return self.write("scene.toml", BODY + LOADS + time_of("verlet", 2e-4, steps) + OUTPUT + extra)

    def start_long_run(self, processes, history_bytes):
        """A run that is under way: its history.csv has so many bytes."""
        history = self.path("out", "history.csv")
        run = self.begin_run(self.scene(steps=1000000), processes, lambda: os.path.exists(history)
                             and os.path.getsize(history) >= history_bytes)
        return run, self.path("out")

    def processes_of(self, run, count):
        children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(run.pid)], capture_output=True,
                                  text=True).stdout.split()
        self.assertEqual(len(children), count)
        return [int(child) for child in children]

    def test_the_message_of_a_failed_step_is_that_of_one_process(self):
        gentle = tables(mesh=dict(generate={"kind": "beam", "size": [4, 1, 1], "cells": [8, 3, 3]}),
                      material=dict(model="neo-hookean", youngs_modulus=1.0e5, poissons_ratio=0.3),
                      fix=[dict(select=plane("x", 0.0))],
                      force=[dict(select={"nearest": [4, 1, 1]}, vector=[-1.0, -3.0, 0.0])])
        body = gentle.replace("[-1.0, -3.0, 0.0]", "[-1.0e6, -3.0e6, 0.0]")
        stiff = tables(material_region=[dict(select={"box": {"min": [2, -1, -1], "max": [5, 2, 2]}},
                         youngs_modulus=1.0e15, poissons_ratio=0.3)])
        scenes = {
            "loads": body + time_of("midpoint", 0.01, 10) + '[solver]\nlinear = "factor"\n',
            "limit": gentle + time_of("verlet", 0.1, 100),
            "contrast": gentle + stiff + time_of("midpoint", 0.01, 10) +
                        '[solver]\nlinear = "factor"\nmax_iterations = 1\n'}

        def message(done):
            lines = [line for line in done.stderr.splitlines() if line.startswith("tetraction: step")]
            self.assertEqual(len(lines), 1, done.stderr)
            # The residual may differ in its last digits.
            return re.sub(r"force residual [^ ]* N", "force residual", lines[0])

        for name, text in scenes.items():
            scene = self.write(f"{name}.toml", text)
            _, done = self.run_scene(scene, code=1)
            expected = message(done)
            for processes in (2, 3):
                with self.subTest(name=name, processes=processes):
                    _, done = self.run_scene(scene, processes, code=1)
                    self.assertEqual(message(done), expected)

    def assert_failed_to_write(self, run, out, words):
        messages = run.communicate(timeout=100)[1]
        self.assertEqual(run.returncode, 4, messages)
        lines = [line for line in messages.splitlines() if line.startswith("tetraction: ")]
        self.assertEqual(len(lines), 1, messages)
        self.assertIn(words, lines[0])
        names, rows = self.numbers(out, "history.csv")
        self.assertEqual(len(rows[-1]), len(names))

    def test_a_frame_that_cannot_be_written(self):
        """A file has the name of the folder. history.csv and summary.json are there."""
        run, out = self.start_long_run(3, 2000)
        os.rename(os.path.join(out, "frames"), self.path("away"))
        try:
            self.write("out/frames", "")
        except IsADirectoryError:  # the run has made it again in between
            os.rename(os.path.join(out, "frames"), self.path("away2"))
            self.write("out/frames", "")
        self.assert_failed_to_write(run, out, "frames")
        summary = self.summary(out)
        self.assertEqual((summary["status"], summary["exit_status"]), ("failed", 4))
        self.assertIn("frames", summary["message"])

    def test_a_full_disk(self):
        """A small file system in memory, where the machine allows one."""
        with self.small_disk("out", 300):
            run, out = self.start_long_run(3, 2000)
            self.assert_failed_to_write(run, out, "No space left")

    def test_the_warning_of_large_steps_names_penalty_springs(self):
        scene = self.write("springs.toml", BODY + """
[[fix]]
select = { nearest = [0.4, 0.1, 0.1] }
mode = "penalty"
penalty = 1.0e9
""" + time_of("verlet", 1e-4, 1) + OUTPUT)
        for processes in (None, 3):
            with self.subTest(processes=processes):
                _, done = self.run_scene(scene, processes, code=1)
                self.assertIn("the springs of fix.mode", done.stderr)

    def test_warnings_of_material_arrays_in_any_part(self):
        scene = self.write("arrays.toml", tables(mesh=dict(file="column.msh"),
                                                 material=dict(youngs_modulus=1.0e5,
                                                   poissons_ratio={"array": "nu"},
                                                   volumetric="quadratic"))
                                          + time_of("verlet", 1e-4, 1) + OUTPUT)
        for ratio, text in ((0.49, "a Poisson's ratio of 0.49"), (-0.3, "has a negative lambda")):
            expected = None
            # At both ends of the body, and at one of them.
            for elements in ((3, 470), (3,), (470,)):
                values = "".join(f"{e} {ratio if e in elements else 0.3}\n" for e in range(1, 481))
                self.write("column.msh", symmetric_column(20) + '$ElementData\n1\n"nu"\n1\n0.0\n3\n0\n1\n480\n' +
                           values + "$EndElementData\n")
                if expected is None:
                    expected = self.summary(self.run_scene(scene)[0])["warnings"]
                    self.assertIn(text, " ".join(expected))
                for processes in (2, 4):
                    with self.subTest(ratio=ratio, elements=elements, processes=processes):
                        out, done = self.run_scene(scene, processes)
                        self.assertEqual(self.summary(out)["warnings"], expected)
                        self.assertIn(text, done.stderr)

    def test_forces_after_a_failed_step_are_those_of_the_last_good_one(self):
        scene = self.write("blow.toml", BODY + """
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { plane = { axis = "x", at = 0.4 } }
total = [-3.0e4, 0.0, 0.0]
amplitude = "ramp"
[[amplitude]]
name = "ramp"
points = [[0.0, 0.0], [0.05, 1.0]]
""" + time_of("explicit", 1e-4, 500) + OUTPUT.replace('"displacement"', '"displacement", "reaction_force"'))
        for processes in (None, 2, 3):
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes, code=1)
                last = "final.vtu" if processes is None else "final.pvtu"
                forces, _ = points_of(self.path(out, last), "reaction_force")
                total = sum(float(copies[0][0]) for copies in forces.values())
                expected = self.last_value(out, "reaction_x")
                self.assertGreater(abs(expected), 100.0)
                self.assertAlmostEqual(total / expected, 1.0, delta=1e-9)

    def test_bad_input_has_one_message(self):
        scene = self.write("scene.toml", BODY.replace("youngs_modulus", "youngs_module"))
        self.assert_refused(2, scene, 3, "youngs_modul")
        self.assert_refused(3, self.path("nothing.toml"), 2, "nothing.toml")
        scene = self.scene('[[fix]]\nselect = { plane = { axis = "x", at = 7.0 } }\n')
        self.assert_refused(2, scene, 4, "selects no vertex")
        scene = self.scene("[[force]]\nselect = { vertices = [100000] }\nvector = [1, 0, 0]\n")
        self.assert_refused(2, scene, 2, "vertex 100000 is not in the mesh")

        done = self.mpirun(3, "run scene.toml --no-such-option", code=2)
        self.assertEqual(done.stderr.count("--no-such-option"), 1, done.stderr)
        self.scene()
        for command in ("static", "modes", "study", "check", "new", "view"):
            done = self.mpirun(2, command, "new" if command == "new" else "scene.toml", code=2)
            self.assert_one_message(done, f"tetraction {command} works in one process only")
        self.assertFalse(os.path.exists(self.path("new")))
        # The nearest tetrahedron is that of the whole mesh.
        scene = self.scene('[[probe]]\nname = "out"\npoint = [0.9, 0.05, 0.05]\nquantity = "velocity"\n')
        _, done = self.run_scene(scene, code=2)
        distance = done.stderr[done.stderr.index("outside the body"):]
        self.assert_refused(2, scene, 3, distance.splitlines()[0])

    def test_nothing_of_the_working_directory_is_read_or_loaded(self):
        # Options with which PETSc writes files.
        for name in (".petscrc", "petscrc"):
            self.write(name, f"-log_view :{self.path('from' + name)}\n")
        environment = {**ENVIRONMENT, "PETSC_OPTIONS": f"-log_view :{self.path('from_variable')}",
                       "PETSC_OPTIONS_YAML": f"log_view: ':{self.path('from_yaml')}'"}
        # Files that the loader would take for libraries of the program.
        engine = os.path.join(os.path.dirname(PROGRAM), "tetraction-petsc")
        needed = subprocess.run(["ldd", engine], capture_output=True, text=True, check=True).stdout
        for name in re.findall(r"^\s*(lib\S+) =>", needed, re.MULTILINE):
            self.write(name, "no library")
        scene = self.scene()
        before = set(os.listdir(self.folder))
        for processes in (None, 2):
            with self.subTest(processes=processes):
                done = self.mpirun(processes, "run", scene, "--out", "out", "--set",
                                   'solver.engine="petsc"', env=environment)
                self.assertEqual(set(os.listdir(self.folder)) - before, {"out"})
                self.assertEqual(done.stderr.count("settings that are ignored"), 1, done.stderr)
                self.assertIn("(PETSC_OPTIONS, PETSC_OPTIONS_YAML, .petscrc, petscrc", done.stderr)

    def test_bad_input_in_one_process_ends_all(self):
        # Two targets for vertices that only some processes have.
        scene = self.scene(tables(fix=[dict(select={"vertices": [17]}, target=[1.0, 0.0, 0.0]),
                                  dict(select={"vertices": [17]}, target=[2.0, 0.0, 0.0])]))
        start = time.monotonic()
        self.assert_refused(2, scene, 4, "vertex 17 is fixed twice")
        self.assertLess(time.monotonic() - start, 60)

    def test_failed_elements_of_all_parts(self):
        # The whole end face is torn away, so that elements of several parts fail.
        scene = self.write("torn.toml", BODY + tables(fix=[dict(select=plane("x", 0.0))],
                                                      force=[dict(select={"all": True},
                                                        total=[-3.0e7, 1.0e6, 0.0])])
                                               + time_of("explicit", 1e-4, 50) + OUTPUT)
        expected = None
        for processes in (None, *PROCESSES):
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes, code=1)
                points, elements = points_of(self.path(out, "failed_elements.vtu"), "displacement")
                expected = expected or (points, elements)
                self.assertGreater(len(elements), 5)
                self.assertEqual(elements, expected[1])
                self.assertEqual(points.keys(), expected[0].keys())
                for vertex, values in points.items():
                    for a, b in zip(values[0], expected[0][vertex][0]):
                        self.assertAlmostEqual(a, b, delta=1e-12)
                _, attempted = points_of(self.path(out, "failed_elements.vtu"), "attempted_displacement")
                self.assertEqual(attempted, elements)

    def test_inverted_element_ends_all(self):
        scene = self.scene()
        _, done = self.run_scene(scene, 3, "--set", "time.step=0.02", "--set", "time.end=1.0", code=1)
        own = [line for line in done.stderr.splitlines()
               if line.startswith("tetraction: ") and "warning" not in line]
        self.assertEqual(len(own), 1, done.stderr)
        self.assertIn("stability limit", own[0])

    def test_event_that_cannot_be_made_ends_all(self):
        scene = self.scene("""
[[event]]
at = 2e-3
[event.fix]
select = { nearest = [0.4, 0.0, 0.0] }
target = [-0.4, 0.0, 0.0]
""")
        for processes in (1, 3):
            with self.subTest(processes=processes):
                out, done = self.run_scene(scene, processes, code=1)
                self.assertIn("the event at 0.002 s could not be made", done.stderr)
                self.assertEqual(done.stderr.count("could not be made"), 1, done.stderr)
                self.assertEqual(self.summary(out)["exit_status"], 1)
                self.assertTrue(self.exists(out, "final.pvtu"))

    def test_output_that_cannot_be_written(self):
        blocked = self.write("blocked", "a file")
        self.assert_refused(4, self.scene(), 3, "blocked", out=blocked)

    def test_a_closed_pipe(self):
        command = ["run", self.scene(), "--out", self.path("pipe"), "--json"]
        for engine in ("local", "petsc"):
            with self.subTest(engine=engine):
                read, write = os.pipe()
                os.close(read)
                done = self.mpirun(None, *command, *sets(f'solver.engine="{engine}"'), code=4,
                                   capture_output=False, stdout=write, stderr=subprocess.PIPE)
                os.close(write)
                self.assert_one_message(done, "cannot be written to standard output")

    def test_signal_ends_the_run_properly(self):
        run, out = self.start_long_run(2, 20000)
        run.send_signal(signal.SIGTERM)
        run.communicate(timeout=60)
        self.assertNotEqual(run.returncode, 0)
        names, rows = self.numbers(out, "history.csv")
        self.assertTrue(all(len(row) == len(names) for row in rows))

    def test_signal_to_one_process_has_its_exit_code(self):
        run, out = self.start_long_run(2, 20000)
        os.kill(self.processes_of(run, 2)[1], signal.SIGQUIT)
        run.communicate(timeout=60)
        self.assertEqual(self.summary(out)["exit_status"], 128 + signal.SIGQUIT)

    def test_killed_process_ends_all(self):
        run, _ = self.start_long_run(3, 0)
        os.kill(self.processes_of(run, 3)[1], signal.SIGKILL)
        run.communicate(timeout=60)
        self.assertNotEqual(run.returncode, 0)

    def test_what_is_not_there_yet(self):
        for extra, name in (
            (tables(constraint=[dict(kind="rigid", select=plane("x", 0.4))]), "[[constraint]]"),
            (tables(pressure=[dict(select={"faces": {"normal": [0, 0, 1]}}, value=10.0)]), "[[pressure]]"),
            ("[pull]\nvertices = [0]\nstiffness = 5.0\n", "[pull]"),
            (tables(event=[dict(at=1e-3, set={"pull.vertices": [0], "pull.stiffness": 5.0})]), "[pull]"),
        ):
            with self.subTest(name=name):
                done = self.assert_refused(2, self.scene(extra), 2, name)
                self.assertIn('solver.engine = "local"', done.stderr)
        for setting, name in (('mesh.volume="nodal"', "mesh.volume"),
                              ('mesh.element="quadratic"', "mesh.element"),
                              ('time.integrator="energy-momentum"', "energy-momentum"),
                              ('solver.kind="ceres"', "ceres")):
            with self.subTest(name=name):
                self.assert_refused(2, self.scene(), 2, name, "--set", setting)
        petsc = ("scene.toml", *sets('solver.engine="petsc"'))
        done = self.mpirun(None, "check", *petsc, *sets('mesh.volume="nodal"'), code=2)
        self.assertIn("mesh.volume", done.stderr)
        for command in ("static", "study"):
            steps = ["--steps", "1e-4,2e-4"] if command == "study" else []
            done = self.mpirun(None, command, *petsc, *steps, code=2)
            self.assertIn("is for tetraction run", done.stderr)
            self.assertNotIn("[1/", done.stderr + done.stdout)


if __name__ == "__main__":
    main(3)
