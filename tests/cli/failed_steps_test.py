"""What a failed step leaves, and events that cannot be made as they are written."""

import os
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, BeamTest, main, own_lines, read_grid
from support.scenes import plane


class FailedSteps(BeamTest):
    def test_the_elements_concerned_are_written(self):
        load = 'force.0={select={nearest=[4,1,1]},vector=[-1e30,0,0]}'
        for rule in ("verlet", "midpoint"):
            out = self.path(rule)
            result = self.run_program("run", "beam.toml", "--out", out, "--set", load, "--set",
                                      f"time.integrator={rule}", "--set", "time.step=1e-3",
                                      code=1)  # fmt: skip
            message = [l for l in own_lines(result.stderr) if "step 1" in l][-1]
            self.assertIn("units", message)
            self.assertNotIn("maller", message)
            grid, arrays, _ = read_grid(os.path.join(out, "failed_elements.vtu"))
            self.assertGreater(grid.GetNumberOfCells(), 0)
            self.assertLess(grid.GetNumberOfCells(), 8 * 2 * 2 * 6)
            for name in ("element_id", "vertex_id", "region", "jacobian", "energy_density",
                         "displacement", "velocity", "external_force", "reaction_force",
                         "elastic_force"):  # fmt: skip
                self.assertIn(name, arrays)
            # The message names the first of them.
            self.assertIn(f"element {arrays['element_id'][0]} ", message)
            # The load of the step acts on one of their vertices.
            self.assertAlmostEqual(abs(arrays["external_force"]).max(), 1e30, delta=1e16)
            if rule == "verlet":
                self.assertLess(arrays["attempted_jacobian"][0], 0)
                self.assertEqual(arrays["attempted_jacobian"][0], min(arrays["attempted_jacobian"]))
                self.assertIn("attempted_displacement", arrays)
        # A run that ends well takes the file of the run before away.
        self.run_program(f"run beam.toml --out {out}")
        self.assertFalse(os.path.exists(os.path.join(out, "failed_elements.vtu")))

    def test_an_equilibrium_that_is_not_found_leaves_them_too(self):
        self.run_program("static", "beam.toml", "--out", "s", "--set",
                         'force.0={select={nearest=[4,1,1]},vector=[-1e30,0,0]}', code=1)  # fmt: skip
        grid, _, _ = read_grid(self.path("s", "failed_elements.vtu"))
        self.assertGreater(grid.GetNumberOfCells(), 0)


class Events(BeamTest):
    def scene(self, events):
        return self.write("beam.toml", BEAM + events)

    def test_the_event_that_is_wrong_is_blamed(self):
        scene = self.scene(
            '[[event]]\nat = 0.02\nfix = { select = { nearest = [4, 1, 1] } }\n'
            '[[event]]\nat = 0.04\nset = { "fix.1.mode" = "penalty" }\n'
        )
        message = self.refused(2, f"run {scene} --out o")
        self.assertIn("event at 0.04 s", message)
        self.assertNotIn("event at 0.02 s", message)
        self.assertIn("penalty is missing", message)

    def test_targets_that_contradict_each_other_are_found_before_the_run(self):
        fix = 'fix = {{ select = {{ vertices = [80] }}, target = [{}, 1, 1] }}\n'
        first = "[[event]]\nat = 0.05\n" + fix.format(4.0)
        second = "[[event]]\nat = 0.05\n" + fix.format(4.1)
        for command in ("run", "check"):
            out = ("--out", "o") if command == "run" else ()
            self.refused(2, command, self.scene(first + second), *out,
                         says=("event.1.fix", "event.0.fix", "vertex 80"))
        self.assertFalse(os.path.exists(self.path("o", "history.csv")))
        # The same target, another component, and a vertex that was released are no contradictions.
        self.run_program("run", self.scene(first + first), "--out", "o")
        release = "[[event]]\nat = 0.05\nunfix = { select = { vertices = [80] } }\n"
        second = second.replace("4.1", "4.01")
        self.run_program("run", self.scene(first + release + second), "--out", "o")

    def test_numbers_out_of_range_are_named(self):
        scene = self.scene('[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "x", at = 4.0 } }\n'
                           "angular_velocity = [1e300, 0, 0]\namplitude = \"a\"\n"
                           '[[amplitude]]\nname = "a"\nsine = { frequency = 3.0 }\n')  # fmt: skip
        for rule in ("verlet", "midpoint", "energy-momentum"):
            result = self.run_program(f"run {scene} --out o --quiet --set time.integrator={rule} "
                                      "--set time.step=1e-3", code=1)  # fmt: skip
            messages = result.stderr + self.read_json("o", "summary.json")["message"]
            with self.subTest(rule):
                self.assertNotRegex(messages, r"\bnan\b")
                for part in ("J is not a finite number", "positions that are not finite numbers",
                             "Make the velocities, angular velocities, offsets"):  # fmt: skip
                    self.assertEqual(messages.count(part), 2, part)
                self.assertNotIn("time.step", messages)

    def test_steps_whose_square_is_out_of_range_are_refused(self):
        scene = self.scene("")
        for key, settings in (
            ("time.end", ["time.end=1e-300"]),
            ("time.step", ["time.step=1e-160", "time.end=1e-158"]),
            ("time.step", ["time.step=1e-155", "time.end=1e-153", "time.integrator=verlet"]),
            ("time.step", ["time.step=1e160", "time.end=1e162"]),
        ):
            with self.subTest(settings):
                overrides = [word for text in settings for word in ("--set", text)]
                self.refused(2, "run", scene, "--out", "o", *overrides,
                             says=("cannot be computed", f"Make {key} "))
        self.assertFalse(os.path.exists(self.path("o", "history.csv")))
        self.run_program(f"run {scene} --out o --set time.step=1e-150 --set time.end=1e-148")

    def test_too_few_iterations_are_named_alone(self):
        message = self.refused(1, "run", self.scene(""), "--out", "o", "--quiet", "--set",
                               "solver.max_iterations=1")  # fmt: skip
        self.assertIn("after 1 iteration:", message)
        self.assertTrue(message.endswith(
            "solver.max_iterations = 1 did not suffice: raise it. The default is 100."), message)  # fmt: skip

    def test_a_key_that_is_there_twice_is_named(self):
        for line, key in (
            ('set = { "material.youngs_modulus" = 8e4, "material.youngs_modulus" = 9e4 }',
             '"material.youngs_modulus"'),
            ("at = 0.06", "at"),
            ("set = { 'é'.a = 1, 'é'.\"a\" = 2 }", "'é'.\"a\""),
        ):  # fmt: skip
            message = self.refused(2, "check", self.scene("[[event]]\nat = 0.05\n" + line + "\n"))
            with self.subTest(line):
                self.assertIn(f"not valid TOML: {key} is there twice in the same table", message)

    def test_velocities_that_contradict_each_other_are_found_before_the_run(self):
        fix = 'fix = {{ select = {{ vertices = [80] }}, {} }}\n'
        first = "[[event]]\nat = 0.05\nfix = { select = { vertices = [80] } }\n"
        for second in ("velocity = [0.1, 0, 0]", 'velocity = [0, 0.1, 0], components = "xy"'):
            second = "[[event]]\nat = 0.05\n" + fix.format(second)
            self.refused(2, "run", self.scene(first + second), "--out", "o",
                         says=("event.1.fix", "event.0.fix", "vertex 80", "different velocities"))
        self.assertFalse(os.path.exists(self.path("o", "history.csv")))
        # Another component, and a vertex that was released before.
        first = '[[event]]\nat = 0.05\nfix = { select = { vertices = [80] }, components = "yz" }\n'
        moving = "[[event]]\nat = 0.05\n" + fix.format('velocity = [0.1, 0, 0], components = "x"')
        self.run_program("run", self.scene(first + moving), "--out", "o")
        release = "[[event]]\nat = 0.05\nunfix = { select = { vertices = [80] } }\n"
        self.run_program("run", self.scene(first + release + second), "--out", "o")

    def test_constraints_of_events_on_a_rigid_handle_are_refused_before_the_run(self):
        end = 'select = { plane = { axis = "x", at = 4.0 } }'
        handle = f'[[constraint]]\nkind = "rigid"\n{end}\n'
        others = (f"fix = {{ {end} }}", f"fix = {{ {end}, penalty = 1e5 }}",
                  f'constraint = {{ kind = "plane", normal = [1, 0, 0], {end} }}',
                  f'constraint = {{ kind = "rigid", angular_velocity = [1, 0, 0], {end} }}',
                  f'constraint = {{ kind = "rigid", {end} }}')  # fmt: skip
        for command in ("check", "run"):
            for other in others:
                with self.subTest(command, other=other):
                    scene = self.scene(handle + "[[event]]\nat = 0.05\n" + other + "\n")
                    self.refused(2, command, scene,
                                 says=("event.0." + other.split(" ")[0], "constraint.0"))
        # A [[fix]] that an event of the scene brings back, moves there or makes exact.
        fixed = f"[[fix]]\n{end}\n"
        release = f"[[event]]\nat = 0.05\nunfix = {{ {end} }}\n"
        again = '[[event]]\nat = 0.06\nset = { "fix.1.offset" = [0, 0, 0] }\n'
        rigid = f'constraint = {{ kind = "rigid", {end} }}\n'
        moved = '[[event]]\nat = 0.06\nset = { "fix.0.select.plane.at" = 4.0 }\n'
        springs = f'[[fix]]\n{end}\nmode = "penalty"\npenalty = 1e4\n'
        exact = '[[event]]\nat = 0.06\nset = { "fix.1.mode" = "exact" }\n'
        for text in (fixed + release + again + "[[event]]\nat = 0.07\n" + rigid, handle + moved,
                     handle + springs + exact):  # fmt: skip
            with self.subTest(text):
                self.assertIn("rigid handle", self.refused(2, "check", self.scene(text)))
        # Springs are no contradiction, and an event after the end never happens.
        late = f"[[event]]\nat = 50.0\nfix = {{ {end} }}\n"
        self.run_program("run", self.scene(handle + late), "--out", "o", "--quiet")
        soft = f'fix = {{ {end}, mode = "penalty", penalty = 1e4 }}\n'
        self.run_program("run", self.scene(handle + "[[event]]\nat = 0.05\n" + soft), "--out", "o", "--quiet")
        # The handle comes second, or another one was taken away before.
        plane = f'constraint = {{ kind = "plane", normal = [1, 0, 0], {end} }}\n'
        rigid = f'constraint = {{ kind = "rigid", {end} }}\n'
        self.refused(2, "check", self.scene(
            f"[[event]]\nat = 0.05\n{plane}[[event]]\nat = 0.06\n{rigid}"))  # fmt: skip
        for first in (f"fix = {{ {end} }}\n[[event]]\nat = 0.06\nunfix = {{ {end} }}\n",
                      f"{plane}[[event]]\nat = 0.06\nremove_constraint = 0\n"):  # fmt: skip
            text = f"[[event]]\nat = 0.05\n{first}{rigid}"
            self.run_program("run", self.scene(text), "--out", "o", "--quiet")

    def test_events_at_one_time_are_made_in_the_order_of_the_file(self):
        """And those within one step in the order of their times."""
        event = '[[event]]\nat = {}\nset = {{ "time.step" = {} }}\n'
        for times, last in (((0.05, 0.05), 0.0025), ((0.045, 0.042), 0.005),
                            ((0.042, 0.045), 0.0025)):  # fmt: skip
            text = "".join(event.format(*both) for both in zip(times, (0.005, 0.0025)))
            self.run_program("run", self.scene(text), "--out", "o", "--quiet")
            with self.subTest(times):
                steps = [row["time_step"] for row in self.history("o", "history.csv")]
                self.assertEqual(steps[1:6], [0.01] * 5)
                self.assertEqual(set(steps[6:-1]), {last})

    def test_an_end_that_has_passed_is_told_of(self):
        scene = self.scene('[[event]]\nat = 0.05\nset = { "time.end" = 0.02 }\n')
        result = self.run_program(f"run {scene} --out o")
        self.assertIn("when this time has passed", result.stderr)
        self.assertEqual(self.read_json("o", "summary.json")["steps"], 5)


if __name__ == "__main__":
    main()
