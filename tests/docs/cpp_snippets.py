"""Makes C++ sources of the `cpp` blocks in README.md and docs/, which are built and run by tests.

Usage: python3 cpp_snippets.py SOURCE_TREE FOLDER

A block with main() becomes a program of its own, FOLDER/PAGE.cc. All others become functions of FOLDER/fragments.cc,
whose main() calls them one after the other in a temporary folder. Prints the names of the sources, separated by
semicolons.

A comment in the line before a block says what else holds:

- <!-- before it: CODE --> is put before the block in its function.
- <!-- file scope: CODE --> puts the block and CODE after it outside of functions. CODE defines void run().
- <!-- only compiled: REASON --> leaves the block out of main().
"""

import os
import re
import sys

from pages import blocks_of, pages_of

START = """// Made by tests/docs/cpp_snippets.py from the blocks of the documentation.
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <memory>
#include <vector>

#include "tetraction/core/interruption.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/io/checkpoint_file.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/session.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"
"""

EXAMPLES = """
// Names that the fragments use.
Scene example_scene() {
  Scene scene;
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.3;
  scene.time = {Integrator::kMidpoint, 0.01, false, 0.6};
  FixSettings clamp;
  clamp.select = SelectPlane{0, 0.0, {}};
  scene.fix.push_back(clamp);
  ForceSettings pull;
  pull.select = SelectPlane{0, 4.0, {}};
  pull.vector = {0.0, 100.0, 0.0};
  scene.force.push_back(pull);
  return scene;
}
TetMesh example_mesh() {
  return generate_box({4, 1, 1}, {8, 2, 2});
}
// A run that ends early and leaves a checkpoint in the folder `out`.
void first_part_of_a_run(const Scene& scene, const TetMesh& mesh, Index every) {
  struct Stop : Observer {
    bool on_step(const Session& session) override { return session.step_number() < 25; }
  } stop;
  Session session(scene, mesh);
  RunRecorder recorder("out", scene.output.every);
  recorder.keep_checkpoints(every);
  session.run({&recorder, &stop});
}
"""

MAIN = """
int main(int, char** argv) {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("tetraction-fragments-" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  std::filesystem::current_path(folder);
  int failures = 0;
  const auto call = [&](const char* name, void (*function)()) {
    std::printf("%s: %s\\n", argv[0], name);
    std::fflush(stdout);
    try {
      function();
    } catch (const std::exception& error) {
      std::printf("%s has thrown: %s\\n", name, error.what());
      ++failures;
    }
  };
CALLS  std::filesystem::current_path("/");
  std::filesystem::remove_all(folder);
  return failures == 0 ? 0 : 1;
}
"""


def write(path, text):
    """Leaves a file that would not change alone, so that it is not compiled anew."""
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            if file.read() == text:
                return
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def without_includes(text):
    lines = text.split("\n")
    includes = [line for line in lines if re.match(r"#include\b", line)]
    return includes, "\n".join("" if line in includes else line for line in lines)


def main(tree, folder):
    os.makedirs(folder, exist_ok=True)
    names, includes, parts, calls = [], [], [], []
    for page in pages_of(tree):
        for block in blocks_of(tree, page)[0]:
            if block.language != "cpp":
                continue
            if re.search(r"^int main\(", block.text, re.MULTILINE):
                name = re.sub(r"\W+", "_", page[: -len(".md")])
                assert name not in names, f"{block}: the page has two programs"
                write(os.path.join(folder, name + ".cc"), f'#line {block.line + 1} "{page}"\n{block.text}')
                names.append(name)
                continue
            own, text = without_includes(block.text)
            includes += own
            space = f"line_{block.line}_of_" + re.sub(r"\W+", "_", page[: -len(".md")])
            text = f'#line {block.line + 1} "{page}"\n{text}'
            before, outside = block.marks.get("before it", ""), block.marks.get("file scope")
            if outside is None:
                text = f"void run() {{\n{before}\n{text}\n}}"
            else:
                text = f"{before}\n{text}\n{outside}"
            parts.append(f"namespace {space} {{\n{text}\n}}  // namespace {space}\n")
            if "only compiled" not in block.marks:
                calls.append(f'  call("{block}", {space}::run);\n')
    head = START + "".join(line + "\n" for line in dict.fromkeys(includes)) + "#include <unistd.h>\n"
    write(os.path.join(folder, "fragments.cc"),
          head + "using namespace tetraction;\n" + EXAMPLES + "\n".join(parts) + MAIN.replace("CALLS", "".join(calls)))  # fmt: skip
    print(";".join([*names, "fragments"]), end="")


if __name__ == "__main__":
    main(*sys.argv[1:])
