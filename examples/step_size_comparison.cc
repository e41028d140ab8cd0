//                       Tetraction example: comparing integrators and steps
//
// Sample runs:  step_size_comparison          to 0.2 s
//               step_size_comparison 1.0
//
// Description:  The same clamped beam by all four integrators, at steps below and above the stability
//               limit of the explicit ones. The example shows Scene as plain data and run_study,
//               which is what `tetraction study` calls.
#include <cstdio>
#include <cstdlib>

#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/study.h"

using namespace tetraction;

int main(int argc, char** argv) {
  // 1. The scene, as plain data.
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {4.0, 1.0, 1.0}, {8, 2, 2}};
  scene.material.youngs_modulus = 1.0e6;
  scene.material.poissons_ratio = 0.4;
  scene.time.end = argc > 1 ? std::atof(argv[1]) : 0.2;
  scene.environment.kind = EnvironmentKind::kGravity;
  FixSettings clamp;
  clamp.select = SelectPlane{0, 0.0, {}};
  scene.fix.push_back(clamp);

  // 2. What to compare: steps that divide the end time, and a fine reference.
  StudySettings settings;
  settings.steps = {scene.time.end / 200, scene.time.end / 100, scene.time.end / 10,
                    scene.time.end / 2};
  settings.reference_integrator = Integrator::kVerlet;
  settings.reference_step = scene.time.end / 1600;

  // 3. Run everything.
  const StudyResult result =
      run_study(scene, generate_mesh(*scene.mesh.generate), settings, {},
                [](std::size_t index, std::size_t count, const PlannedRun& run) {
                  std::printf("run %zu of %zu: %s, h = %g s\n", index + 1, count,
                              to_string(run.integrator).c_str(), run.step);
                });

  // 4. The table. A run that blew up is a result.
  std::printf("\n%s", study_table(result).c_str());
  for (const StudyRow& row : result.rows) {
    if (row.status != RunStatus::kFinished) std::printf("%s\n", row.message.c_str());
  }
  return 0;
}
