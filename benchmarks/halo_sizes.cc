// What the parts of a mesh exchange: the figures of docs/scaling.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <set>

#include "petsc/messages.h"
#include "petsc/partition.h"
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

Sizes largest_sizes(const TetMesh& mesh, const std::vector<int>& part_of, int parts) {
  std::vector<Sizes> sizes(static_cast<std::size_t>(parts));
  std::vector<std::set<int>> neighbors(sizes.size());
  std::vector<std::vector<int>> parts_of(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::size_t e = 0; e < part_of.size(); ++e) {
    ++sizes[static_cast<std::size_t>(part_of[e])].tetrahedra;
    for (const Index v : mesh.tetrahedra[e]) {
      std::vector<int>& own = parts_of[static_cast<std::size_t>(v)];
      if (std::find(own.begin(), own.end(), part_of[e]) == own.end()) own.push_back(part_of[e]);
    }
  }
  for (const std::vector<int>& own : parts_of) {
    for (const int part : own) {
      Sizes& of_part = sizes[static_cast<std::size_t>(part)];
      ++of_part.vertices;
      if (own.size() > 1) ++of_part.shared;
      of_part.sent += static_cast<Index>(own.size()) - 1;
      for (const int other : own) {
        if (other != part) neighbors[static_cast<std::size_t>(part)].insert(other);
      }
    }
  }
  Sizes largest;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    sizes[p].neighbors = static_cast<Index>(neighbors[p].size());
    largest.take_larger(sizes[p]);
  }
  return largest;
}

void print_sizes(int cells, const std::vector<int>& counts, const AllToAll& process) {
  const TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {cells, cells, cells});
  const MeshChunk chunk = chunk_of(mesh, whole_of(mesh), 0, 1);
  const auto neighbors = match_faces(chunk, process).neighbors;
  for (const int parts : counts) {
    const std::vector<int> part_of = partition_mesh(chunk, neighbors, parts, process);
    const Sizes largest = largest_sizes(mesh, part_of, parts);
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
  const tetraction::petsc::MpiAllToAll all(processes);
  fmt::print(
      "Largest values of all parts; kB sent: three numbers for each vertex of each message\n"
      "tetrahedra  parts  tets/part imbalance   vertices   shared neighbors      kB sent\n");
  for (const double size : sizes) {
    tetraction::petsc::print_sizes(static_cast<int>(std::lround(std::cbrt(size / 6.0))), parts,
                                   all);
  }
  return 0;
}
