// The program of a user of tetraction::io: a scene from a file, and results in a folder.
#include <cstdio>

#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/session.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  using namespace tetraction;
  const Scene scene = read_scene(argv[1]);
  Session session(scene, read_scene_mesh(scene));
  for (int step = 0; step < 5; ++step) session.step();
  std::printf("%d vertices\n", static_cast<int>(session.system().vertex_count()));
}
