"""What the program says of obstacles: reports, refusals before the run, and messages of steps that fail."""

import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import ProgramTest, main

SCENE = """
[mesh]
generate = {{ kind = "cube", cells = 2, size = 0.2 }}
[material]
youngs_modulus = 5.0e4
poissons_ratio = 0.3
[time]
integrator = "{rule}"
step = {step}
end = {end}
[environment]
kind = "gravity"
[[obstacle]]
name = "floor"
kind = "plane"
point = [0.0, {height}, 0.0]
normal = [0.0, 1.0, 0.0]
{more}
"""


class Contact(ProgramTest):
    def scene(self, more="", rule="energy-momentum", step=1e-3, end=0.02, height=-0.05):
        self.write("scene.toml", SCENE.format(more=more, rule=rule, step=step, end=end, height=height))

    def refusal(self, *arguments, code=2):
        return self.run_program(*arguments, code=code).stderr

    def test_check_has_the_obstacles(self):
        self.scene("friction = 0.3\nvelocity = [0.0, 0.1, 0.0]\n")
        floor = self.check()["obstacles"]["floor"]
        self.assertEqual(floor["triangles"], 48)
        self.assertEqual(floor["stiffness"], 5e4)
        self.assertEqual(floor["friction"], 0.3)
        self.assertTrue(floor["moves"])
        self.assertIsNone(floor["gap"])
        self.scene(height=-0.004)
        floor = self.check()["obstacles"]["floor"]
        self.assertAlmostEqual(floor["gap"], 0.004, delta=1e-12)
        self.assertGreater(floor["thickness"], 0.004)
        text = self.run_program("check scene.toml").stdout
        self.assertIn("begins in its layer, 0.004 m from it", text)

    def check(self):
        import json

        return json.loads(self.run_program("check scene.toml --json").stdout)

    def test_a_stiffness_far_from_the_modulus_is_told(self):
        for stiffness, words in (("1e15", "a hard wall"), ("1.0", "to a small part"), ("5e5", None)):
            with self.subTest(stiffness):
                self.scene(f"stiffness = {stiffness}\n")
                told = self.run_program("check scene.toml").stderr
                ran = self.run_program("run scene.toml --out out --quiet").stderr
                for text in (told, ran):
                    if words:
                        self.assertIn(words, text)
                    else:
                        self.assertNotIn("stiffness", text)

    def test_static_has_the_forces_of_obstacles(self):
        self.scene(
            '[[fix]]\nselect = { vertices = [0] }\ncomponents = "xz"\n'
            '[[fix]]\nselect = { vertices = [2] }\ncomponents = "z"\n', height=-0.004)  # fmt: skip
        self.run_program("static scene.toml --out out --quiet")
        summary = self.read_json("out", "summary.json")
        force = summary["obstacles"]["floor"]["force"]
        weight = 9.81 * 1000 * 0.2**3
        self.assertAlmostEqual(force[1], weight, delta=1e-6 * weight)
        # It presses below the middle of the body.
        moment = summary["obstacles"]["floor"]["moment"]
        self.assertAlmostEqual(moment[2], 0.1 * weight, delta=2e-2 * weight * 0.1)

    def test_names_are_checked_before_the_run(self):
        twin = 'obstacle = { name = "floor", kind = "plane", point = [0, -1, 0], normal = [0, 1, 0] }\n'
        self.scene(f"[[event]]\nat = 0.01\n{twin}")
        for command in ("check scene.toml", "run scene.toml --out out"):
            self.assertIn('the name "floor" belongs to another obstacle', self.refusal(command))
        self.scene(f"[[event]]\nat = 0.005\nremove_obstacle = 0\n[[event]]\nat = 0.01\n{twin}")
        self.run_program("check scene.toml")
        self.scene("[[event]]\nat = 0.005\nremove_obstacle = 0\n[[event]]\nat = 0.01\nremove_obstacle = 0\n")
        self.assertIn("was removed already", self.refusal("check scene.toml"))

    def test_a_probe_may_wait_for_an_obstacle(self):
        added = ('[[event]]\nat = 0.005\nobstacle = { name = "lid", kind = "plane", '
                 "point = [0, 0.204, 0], normal = [0, -1, 0] }\n")
        probe = '[[probe]]\nname = "f"\nobstacle = "lid"\nquantity = "contact_force"\n'
        self.scene(added + probe)
        self.run_program("run scene.toml --out out --quiet")
        rows = self.history("out", "probes.csv")
        self.assertEqual({row["f_y"] for row in rows if row["time"] < 0.0051}, {0.0})
        self.assertLess(min(row["f_y"] for row in rows), 0.0)
        self.scene(added + probe.replace("lid", "lit"))
        self.assertIn('did you mean "lid"?', self.refusal("run scene.toml --out out"))

    def test_a_vertex_that_is_led_onto_an_obstacle(self):
        # It ends exactly there after one step.
        self.scene('[[fix]]\nselect = { plane = { axis = "y", at = 0.0 } }\nvelocity = [0, -1, 0]\n',
                   rule="backward-euler", height=-0.001)  # fmt: skip
        message = self.refusal("run scene.toml --out out", code=1)
        self.assertIn('cannot give way to the obstacle "floor"', message)
        self.assertNotIn("not finite", message)

    def test_a_body_that_is_crushed(self):
        # The plate is faster than the pressure waves of the body.
        self.scene("velocity = [0.0, 60.0, 0.0]\n", step=1e-4, height=-0.005)
        message = self.refusal(
            "run scene.toml --out out --set material.youngs_modulus=1e6 --set mesh.generate.cells=3 "
            "--set mesh.generate.size=0.1", code=1)  # fmt: skip
        self.assertIn("contact crushes the body", message)
        self.assertNotIn("out of all proportion", message)
        self.assertLessEqual(message.count("the smallest gap"), 1)

    def test_a_drum_that_turns_is_not_blamed(self):
        drum = ('[[obstacle]]\nname = "drum"\nkind = "cylinder"\npoint = [0.1, 0.1, 0.1]\naxis = [0, 0, 1]\nradius = 0.16\n'
                "inside = true\nangular_velocity = [0, 0, 400]\n")
        # The blow makes the step fail.
        self.scene(drum + "[initial]\nvelocity = [0.0, -300.0, 0.0]\n")
        self.assertNotIn('"drum" moves by', self.refusal("run scene.toml --out out", code=1))


if __name__ == "__main__":
    main()
