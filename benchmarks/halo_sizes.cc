// What the parts of a mesh exchange: the figures of docs/scaling.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "petsc/mesh_distribution.h"
#include "tetraction/mesh/generate.h"

namespace tetraction::petsc {
namespace {

// Of the parts of one partition.
struct Sizes {
  Index tetrahedra = 0;
  Index vertices = 0;
  Index shared = 0;     // vertices that other parts have, too
  Index neighbors = 0;  // parts
  Index sent = 0;       // vertices in all messages of an exchange

  void take_larger(const Sizes& other) {
    tetrahedra = std::max(tetrahedra, other.tetrahedra);
    vertices = std::max(vertices, other.vertices);
    shared = std::max(shared, other.shared);
    neighbors = std::max(neighbors, other.neighbors);
    sent = std::max(sent, other.sent);
  }
};

Sizes sizes_of(const PartData& data) {
  Sizes sizes;
  sizes.tetrahedra = data.mesh.tetrahedron_count();
  sizes.vertices = data.mesh.vertex_count();
  sizes.neighbors = static_cast<Index>(data.neighbors.size());
  std::vector<char> is_shared(static_cast<std::size_t>(sizes.vertices), 0);
  for (const Neighbor& neighbor : data.neighbors) {
    sizes.sent += static_cast<Index>(neighbor.shared.size());
    for (const Index v : neighbor.shared) is_shared[static_cast<std::size_t>(v)] = 1;
  }
  sizes.shared = std::count(is_shared.begin(), is_shared.end(), 1);
  return sizes;
}

void print_sizes(int cells, const std::vector<int>& counts) {
  const TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {cells, cells, cells});
  for (const int parts : counts) {
    const std::vector<int> part_of = partition_mesh(mesh, parts);
    const MeshDivider divider(mesh, part_of, parts);
    Sizes largest;
    for (int part = 0; part < parts; ++part) largest.take_larger(sizes_of(divider.part(part)));
    const double mean = static_cast<double>(mesh.tetrahedron_count()) / parts;
    fmt::print("{:>10} {:>6} {:>10} {:>9.3f} {:>10} {:>8} {:>9} {:>12.1f}\n",
               mesh.tetrahedron_count(), parts, largest.tetrahedra,
               static_cast<double>(largest.tetrahedra) / mean, largest.vertices, largest.shared,
               largest.neighbors, 24e-3 * static_cast<double>(largest.sent));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace tetraction::petsc

int main(int argc, char** argv) {
  CLI::App app("The largest part of partitions of a cube, and what it exchanges.");
  std::vector<double> sizes{1e6};
  std::vector<int> parts{2, 4, 8, 16, 32, 64, 128, 256, 512, 1024};
  app.add_option("--tetrahedra", sizes, "about how many tetrahedra the cubes have")->delimiter(',');
  app.add_option("--parts", parts, "how many parts")->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  const tetraction::petsc::Processes processes;
  fmt::print(
      "Largest values of all parts; kB sent: three numbers for each vertex of each message\n"
      "tetrahedra  parts  tets/part imbalance   vertices   shared neighbors      kB sent\n");
  for (const double size : sizes) {
    tetraction::petsc::print_sizes(static_cast<int>(std::lround(std::cbrt(size / 6.0))), parts);
  }
  return 0;
}
