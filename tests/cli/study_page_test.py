"""study.html: what it says, that it needs nothing else, and that its tables sort in a browser."""

import glob
import html
import html.parser
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, BEAM_MESH, DATA, ProgramTest, main, words_of
from support.study import PLOT_PROGRAM

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
VOID = {"meta", "img", "br", "link", "input", "hr"}


class Page(html.parser.HTMLParser):
    """The page's text, tables and references. A tag that is not closed is an error."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.references, self.tables, self.images = [], [], {}, []
        self.text, self.prose, self.scripts, self.table, self.drawings = "", "", "", None, 0
        self.feed(text)
        self.close()
        if self.open:
            raise AssertionError(f"not closed: {self.open}")

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        for name in ("src", "href", "xlink:href", "action", "data", "poster", "srcset"):
            if name in attributes:
                self.references.append(attributes[name])
        for name in attributes:
            if name.startswith("on"):
                raise AssertionError(f"a handler: {name}")
        self.drawings += tag == "svg"
        if tag == "img":
            self.images.append(attributes)
        if tag == "table":
            self.table = self.tables.setdefault(attributes["id"], [])
        if tag == "tr":
            self.table.append([])
        if tag in ("td", "th"):
            self.table[-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            raise AssertionError(f"</{tag}> closes nothing")

    def handle_data(self, data):
        if "script" in self.open:
            self.scripts += data
        elif "style" not in self.open:
            self.text += data
            if not {"table", "svg", "title"} & set(self.open):
                self.prose += data + " "
            if "td" in self.open or "th" in self.open:
                self.table[-1][-1] += data


class PageTest(ProgramTest):
    GRID = ("--integrators", "verlet,midpoint", "--steps", "0.0025,0.005,0.05", "--out", "s")

    def study(self, *arguments, scene=BEAM, **keywords):
        return self.run_program("study", self.write("beam.toml", scene), *self.GRID, *words_of(arguments),
                                **keywords)  # fmt: skip

    def page(self):
        return Page(self.read("s", "study.html"))


class Content(PageTest):
    def test_of_a_study_with_plots(self):
        result = self.study("--set environment.strength=9.8 --threads 1")
        self.assertIn("s/study.html", result.stdout)
        page = self.page()
        self.assert_parts(page.text, ("Step-size study: beam", "Tetraction"))
        self.assertIn("--set environment.strength=9.8 --threads 1", page.text)
        self.assertRegex(page.text, r"\d+ logical core")
        self.assertRegex(page.text, r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")
        self.assertIn("the cheapest run is", page.text)
        self.assertIn("Verlet became unstable above its stability limit, with h = 0.05 s", page.text)
        # Nothing is loaded from elsewhere. The plots stand in the page itself, in their order.
        self.assertGreater(page.drawings, 5)
        self.assertEqual(page.images, [])
        for reference in page.references:
            self.assertTrue(reference.startswith(("#", "data:image/png;base64,")), reference[:80])
        self.assertNotIn("://", page.scripts)
        places = [page.text.index(part) for part in
                  ("Which rule and step", "Error over step", "Work and precision", "Energy error over time",
                   "Findings", "All runs", "Time by phase", "How it was made")]  # fmt: skip
        self.assertEqual(places, sorted(places))
        self.assertLess(len(page.prose.split()), 900)
        head, *body = page.tables["answer"]
        self.assertEqual(head[:3], ["error below", "rule", "step [s]"])
        self.assertEqual(len([cells for cells in body if cells[1] == "verlet"]), len(body) / 2)
        # The words are those of study.json, and the numbers those of study.csv.
        study = self.read_json("s", "study.json")
        self.assertGreater(len(study["conclusions"]), 2)
        for conclusion in study["conclusions"]:
            self.assertIn(conclusion["topic"], page.text)
            for sentence in conclusion["sentences"]:
                self.assertIn(sentence, page.text)
        rows = self.table("s", "study.csv")
        head, *body = page.tables["runs"]
        self.assertEqual(len(body), len(rows))
        for row, cells in zip(rows, body):
            shown = dict(zip(head, cells))
            self.assertEqual(shown["integrator"], row["integrator"])
            self.assertEqual(float(shown["step [s]"]), float(row["step"]))
            self.assertEqual(shown["status"], row["status"])
            for key in ("version", "date", "processor", "cores", "threads", "command"):
                self.assertNotEqual(row[key], "")
            self.assertEqual(row["command"], study["command"])
            self.assertEqual(row["threads"], "1")
        self.assertEqual(len(page.tables["phases"]), 1 + len(rows))
        summary = self.path("s", "midpoint-0.005", "summary.json")
        seconds = self.read_json(summary)["wall_seconds"]["stepping"]
        head, *body = page.tables["phases"]
        cells = next(c for c in body if c[0] == "midpoint" and float(c[1]) == 0.005)
        column = next(i for i, name in enumerate(head) if name.startswith("time steps"))
        self.assertAlmostEqual(float(cells[column]) / seconds, 1, delta=0.01)

    def test_curves_and_points_of_plots_name_their_runs(self):
        self.study("--quiet")
        text = self.read("s", "study.html")
        runs = {row["directory"]: row for row in self.read_json("s", "study.json")["runs"]}
        drawn = text[text.index("<figure") : text.index("<h2>Findings</h2>")]
        self.assertLessEqual(set(re.findall(r'data-run="([^"]*)"', drawn)), set(runs))
        self.assertEqual(set(re.findall(r'data-rule="([^"]*)"', drawn)), {"verlet", "midpoint"})
        # A title for each point, which browsers show without scripts as well.
        for name in ("midpoint-0.005", "verlet-0.0025"):
            title = re.search(rf'<use [^>]*data-run="{name}"><title>([^<]*)</title></use>', drawn)[1]
            rule, error = re.fullmatch(r"(\w+), h = [\d.]+\u00a0ms: (\S+)", html.unescape(title)).groups()
            self.assertEqual(rule.lower(), runs[name]["integrator"])
            self.assertAlmostEqual(float(error) / runs[name]["position_error"], 1, delta=0.01)
        # The scale of a curve over time gives back its values.
        curve = re.search(r'id="energy_over_time-[^"]*" data-rule="verlet" data-run="verlet-0.0025" '
                          r'data-scale="([^"]*)" data-units="([^"]*)">(.*?)</g>', drawn, re.DOTALL)  # fmt: skip
        a, b, is_log_x, c, d, is_log_y = map(float, curve[1].split())
        self.assertEqual((is_log_x, is_log_y), (0, 1))
        points = [(a + b * float(x), 10 ** (c + d * float(y)))
                  for x, y in re.findall(r"[ML] (\S+) (\S+)", curve[3])]  # fmt: skip
        second = {"s": 1.0, "ms": 1e-3}[curve[2].split("|")[0]]
        scale = self.read_json("s", "verlet-0.0025", "summary.json")["energy"]["scale"]
        history = self.table(self.path("s", "verlet-0.0025"), "history.csv")
        errors = [abs(float(row["energy_error"])) / scale for row in history]
        self.assertAlmostEqual(points[-1][0] * second / float(history[-1]["time"]), 1, delta=1e-3)
        self.assertAlmostEqual(max(v for _, v in points) / max(errors), 1, delta=0.01)

    def test_a_directory_in_place_of_a_plot_is_named(self):
        os.makedirs(self.path("s", "energy_over_time.png.part"))
        result = self.study("--quiet", code=4)
        self.assertIn("energy_over_time.png.part: cannot be deleted", result.stderr)
        os.rmdir(self.path("s", "energy_over_time.png.part"))
        self.assertIn("no run was made", self.study().stderr)
        self.assertIn("Energy error over time", self.page().text)
        self.assertFalse(self.exists("s", ".failed-plots"))

    def test_without_plots(self):
        self.study("--no-plots")
        page = self.page()
        self.assertIn("The plots were left out with --no-plots.", page.text)
        self.assertEqual(page.images, [])
        self.assertEqual(page.drawings, 0)
        self.assertEqual(len(page.tables["runs"]), 7)

    def test_without_matplotlib(self):
        """A python3 that has no matplotlib, where the program looks for one: the study is complete."""
        if os.path.exists("/usr/bin/python3"):
            self.study("--no-plots --quiet")
            # -S: without the folder where packages are installed.
            drawn = subprocess.run(["/usr/bin/python3", "-IBS", PLOT_PROGRAM, self.path("s")],
                                   capture_output=True, text=True)  # fmt: skip
            self.assertEqual(drawn.returncode, 3)
            self.assertIn("matplotlib", drawn.stderr)
            self.assertEqual(glob.glob(self.path("s", "*.png*")), [])
        else:
            self.assertIn("python3-matplotlib", self.study(env={"PATH": "/nowhere"}).stderr)
            self.assertIn("python3-matplotlib are not installed", self.page().text)

    def test_names_are_text(self):
        """What a scene names cannot become a part of the page."""
        name = "a<b>&c<script>alert(1)<img src=x onerror=alert(2)>{{script}}"
        scene = self.write(name + ".toml", BEAM)
        self.run_program("study", scene, *self.GRID, "--no-plots", "--vary",
                         "material.density=900,1000")  # fmt: skip
        page = self.page()
        self.assertIn("Step-size study: " + name, page.text)
        self.assertIn("--vary material.density=900,1000", page.text)
        self.assertEqual(page.tables["runs"][0][0], "variant")
        self.assertIn("onerror=alert(2)", page.text)
        self.assertNotIn("alert(", page.scripts)
        for tag in ("<script>alert", "<img src=x"):
            self.assertNotIn(tag, self.read("s", "study.html"))

    def test_names_of_meshes_and_titles_are_text(self):
        """In the page, in drawings, and in tables of LaTeX and Markdown."""
        names = ("$\\input{passwd}$<script>alert(1)_%&~^{$.msh", "\"><img src=x onerror=alert(2)>\\write18{t}$_#|.msh")
        for name in names:
            shutil.copy(os.path.join(DATA, "orbiting_cube.msh"), self.path(name))
        scene = BEAM.split("[[fix]]")[0].replace(BEAM_MESH, f"file = {json.dumps(names[0])}").replace('"gravity"', '"none"')
        scene += "[initial]\nangular_velocity = [0.0, 1.0, 0.0]\n"
        self.study("--quiet", "--width=85", "--title=--><script>alert(3)</script> $\\frac{ \\$", "--vary",
                   "mesh.file=" + ",".join(map(json.dumps, names)), scene=scene)  # fmt: skip
        page = self.page()
        self.assertEqual(page.images, [])  # drawings with such names stand in the page as others do
        self.assertGreater(page.drawings, 5)
        self.assertNotIn("alert(", page.scripts)
        self.assertIn(json.dumps(names[1]), page.text)
        drawings = glob.glob(self.path("s", "*.svg"))
        for path in drawings:
            xml.dom.minidom.parse(path)
        latex, markdown = (self.run_program("study open s --table", kind).stdout for kind in ("latex", "markdown"))
        self.assertNotRegex(latex, r"\\(input|write)|(?<!\\)[%#_~]")
        rows = [line for line in latex.splitlines() if line.endswith(r"\\")]
        self.assertEqual(len({len(re.findall(r"(?<!\\)&", row)) for row in rows}), 1)
        self.assertNotRegex(markdown, r"(?<!\\)[<$_`]")
        self.assertEqual(len({len(re.findall(r"(?<!\\)\|", row)) for row in markdown.splitlines()}), 1)

    def test_plots_of_a_clamped_and_of_a_free_body(self):
        """Momenta over time are drawn only where the scene conserves them."""
        self.study("--quiet")
        for ending in ("png", "svg", "pdf"):
            self.assertTrue(self.exists("s", f"momentum_drift_over_step.{ending}"))
            self.assertFalse(self.exists("s", f"linear_momentum_over_time.{ending}"))
        free = BEAM.split("[[fix]]")[0].replace('"gravity"', '"none"')
        free += "[initial]\nstretch = [1.05, 1.0, 1.0]\nangular_velocity = [0.0, 1.0, 0.0]\n"
        self.study("--quiet", scene=free)
        for letter in ("linear", "angular"):
            for ending in ("png", "svg", "pdf"):
                path = self.path("s", f"{letter}_momentum_over_time.{ending}")
                self.assertGreater(os.path.getsize(path), 3000)
        self.assertIn("Angular momentum over time", self.page().text)
        self.assertIn("unstable:", self.read("s", "error_over_step.svg"))


@unittest.skipUnless(CHROMIUM, "chromium is not installed")
class Browser(PageTest):
    def dump(self, path):
        """The page after its scripts, and what the browser says of errors.

        The output goes to files: helper processes of the browser may keep a pipe open after its end.
        """
        dom, log = self.path("dom.html"), self.path("browser.log")
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home:
            with open(dom, "w") as out, open(log, "w") as err:
                process = subprocess.Popen(
                    [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu",
                     "--disable-dev-shm-usage", f"--user-data-dir={home}", "--enable-logging=stderr",
                     "--v=0", "--proxy-server=127.0.0.1:1", "--dump-dom", "file://" + path],
                    stdout=out, stderr=err, stdin=subprocess.DEVNULL, start_new_session=True,
                )  # fmt: skip
                try:
                    code = process.wait(timeout=400)
                finally:
                    try:
                        os.killpg(process.pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
                    process.wait()
        with open(log, errors="replace") as file:
            text = file.read()
        self.assertEqual(code, 0, text)
        return self.read(dom), [line for line in text.splitlines() if "CONSOLE" in line]

    def test_sorts_and_loads_nothing(self):
        self.study("--quiet")
        text = self.read("s", "study.html")
        # A second script, which clicks and writes down what it sees.
        probe = """<script>
        const seen = {};
        window.addEventListener("error", event => { seen.error = String(event.message); });
        window.addEventListener("load", () => {
          const table = document.getElementById("runs");
          const heads = [...table.querySelectorAll("th")].map(th => th.textContent);
          const column = name => [...table.tBodies[0].rows].map(
            row => row.cells[heads.findIndex(head => head.startsWith(name))].dataset.value);
          const click = name => table.querySelectorAll("th button")[
            heads.findIndex(head => head.startsWith(name))].click();
          seen.before = column("step [s]");
          click("step [s]"); seen.up = column("step [s]");
          click("step [s]"); seen.down = column("step [s]");
          seen.sort = [...table.querySelectorAll("th")].map(th => th.getAttribute("aria-sort"));
          click("integrator"); seen.text = column("integrator");
          click("pos.error"); seen.empty = column("pos.error");
          click("pos.error"); seen.emptyDown = column("pos.error");
          seen.drawings = [...document.querySelectorAll("figure svg")].map(svg => svg.getBoundingClientRect().width);
          const shown = () => [...document.querySelectorAll("#runs tbody tr, .card svg g[data-rule]")].filter(
            part => getComputedStyle(part).display !== "none").map(part => part.dataset.rule);
          seen.all = shown();
          const box = [...document.querySelectorAll("#switches label")].find(l => l.textContent.includes("verlet"));
          box.firstElementChild.click(); seen.without = shown();
          box.firstElementChild.click(); seen.again = shown();
          const hidden = () => [...document.querySelectorAll("figure svg [data-run]")].filter(
            part => getComputedStyle(part).display === "none").map(part => part.dataset.run);
          const plotted = () => [...document.querySelectorAll("figure svg g[data-rule]")].filter(
            part => getComputedStyle(part).display !== "none").map(part => part.dataset.rule);
          seen.plotted = plotted();
          box.firstElementChild.click(); seen.plottedWithout = plotted(); box.firstElementChild.click();
          const row = table.querySelector("tr[data-run='midpoint-0.005']");
          row.click(); seen.hidden = hidden(); row.click(); seen.hiddenAgain = hidden();
          const over = (element, x, y) => {
            element.closest("svg").dispatchEvent(new PointerEvent("pointermove", {clientX: x, clientY: y}));
            return document.getElementById("value").textContent;
          };
          const mark = document.querySelector("figure use[data-run='midpoint-0.005']");
          const place = mark.getBoundingClientRect();
          seen.mark = over(mark, place.x + place.width / 2, place.y + place.height / 2);
          seen.title = mark.textContent;
          const curve = document.querySelector("figure g[data-scale][data-run='midpoint-0.005']");
          const [, x, y] = curve.querySelector("path").getAttribute("d").match(/L (\\S+) (\\S+)/);
          const point = new DOMPoint(+x, +y).matrixTransform(curve.closest("svg").getScreenCTM());
          seen.curve = over(curve, point.x, point.y);
          const search = document.querySelector("input[type=search]");
          search.value = "midpoint 0.05"; search.dispatchEvent(new Event("input"));
          seen.filtered = [...table.tBodies[0].rows].filter(row => !row.hidden).map(row => row.textContent);
          const first = document.querySelector(".card use[data-run^='verlet']").getBoundingClientRect();
          seen.value = over(document.querySelector(".card use[data-run^='verlet']"),
            first.x + first.width / 2, first.y + first.height / 2);
          seen.loaded = performance.getEntriesByType("resource").map(entry => entry.name.slice(0, 40));
          const out = document.createElement("pre");
          out.id = "seen";
          out.textContent = JSON.stringify(seen);
          document.body.append(out);
        });
        </script>"""
        # The page itself runs no second script.
        dom, said = self.dump(self.write("refused.html", text.replace("</body>", probe + "</body>")))
        self.assertNotIn('<pre id="seen">', dom)
        self.assertIn("Content Security Policy", " ".join(said))
        text = re.sub("script-src '[^']*'", "script-src 'unsafe-inline'", text)
        path = self.write("probed.html", text.replace("</body>", probe + "</body>"))
        dom, said = self.dump(path)
        self.assertEqual(said, [])
        self.assertIn('<pre id="seen">', dom)
        seen = json.loads(html.unescape(dom.split('<pre id="seen">')[1].split("</pre>")[0]))
        self.assertNotIn("error", seen)
        numbers = [float(v) for v in seen["before"]]
        self.assertEqual([float(v) for v in seen["up"]], sorted(numbers))
        self.assertEqual([float(v) for v in seen["down"]], sorted(numbers, reverse=True))
        self.assertEqual([s for s in seen["sort"] if s], ["descending"])
        self.assertEqual(seen["text"], sorted(seen["text"]))
        for key, reverse in (("empty", False), ("emptyDown", True)):
            known = [float(v) for v in seen[key] if v != ""]
            self.assertEqual(known, sorted(known, reverse=reverse))
            self.assertEqual(seen[key][len(known):], [""] * (len(seen[key]) - len(known)))
            self.assertLess(len(known), len(seen[key]))  # runs without an error come last
        self.assertGreater(len(seen["drawings"]), 4)
        self.assertGreater(min(seen["drawings"]), 300)
        self.assertIn("verlet", seen["all"])
        self.assertEqual(seen["without"], [rule for rule in seen["all"] if rule != "verlet"])
        self.assertEqual(seen["again"], seen["all"])
        self.assertEqual(set(seen["plotted"]), {"verlet", "midpoint"})
        self.assertEqual(seen["plottedWithout"], [rule for rule in seen["plotted"] if rule != "verlet"])
        self.assertEqual(set(seen["hidden"]), {"midpoint-0.005"})
        self.assertGreater(len(seen["hidden"]), 4)
        self.assertEqual(seen["hiddenAgain"], [])
        self.assertEqual(seen["mark"], seen["title"])
        self.assertRegex(seen["curve"], r"^midpoint, h = 5\u00a0ms: [\d.e-]+ at [\d.e-]+ m?s$")
        self.assertEqual(len(seen["filtered"]), 1)
        self.assertRegex(seen["value"], r"^Verlet, h = [\d.]+\u00a0ms: [\d.e-]+$")
        self.assertEqual([name for name in seen["loaded"] if not name.startswith("data:")], [])


if __name__ == "__main__":
    main()
