#include "face_matches.h"

#include <algorithm>

namespace tetraction::petsc {
namespace {

constexpr std::int32_t kNone = -1;

// A face of a tetrahedron.
struct Face {
  std::array<std::int32_t, 3> key;  // its vertices, ascending
  std::int32_t tetrahedron;
};

struct Neighbors {
  std::int32_t tetrahedron;
  std::int32_t neighbor;
};

// The faces of the chunk whose least vertex is v with v mod `passes` = `pass`, for the processes with these vertices.
std::vector<std::vector<Face>> faces_of_pass(const MeshChunk& chunk, int processes, Index passes,
                                             Index pass) {
  const EqualRanges vertices = chunk.vertex_ranges(processes);
  std::vector<std::vector<Face>> faces(at(processes));
  auto tetrahedron = static_cast<std::int32_t>(chunk.first_tetrahedron);
  for (const auto t : chunk.mesh.tetrahedra) {
    for (std::size_t omitted = 0; omitted < 4; ++omitted) {
      std::array<Index, 3> key{t[(omitted + 1) % 4], t[(omitted + 2) % 4], t[(omitted + 3) % 4]};
      std::sort(key.begin(), key.end());
      if (key[0] % passes != pass) continue;
      faces[at(vertices.process_of(key[0]))].push_back(
          {{static_cast<std::int32_t>(key[0]), static_cast<std::int32_t>(key[1]),
            static_cast<std::int32_t>(key[2])},
           tetrahedron});
    }
    ++tetrahedron;
  }
  return faces;
}

}  // namespace

bool FaceMatches::is_on_boundary(const std::array<Index, 3>& ascending) const {
  return std::binary_search(boundary.begin(), boundary.end(), ascending);
}

FaceMatches match_faces(const MeshChunk& chunk, const AllToAll& processes) {
  // All faces together would need several times the memory of the chunk.
  constexpr Index kPasses = 8;
  const int count = processes.count();
  const EqualRanges tetrahedra = chunk.tetrahedron_ranges(count);
  FaceMatches matches;
  matches.neighbors.assign(chunk.mesh.tetrahedra.size(), {kNone, kNone, kNone, kNone});
  for (Index pass = 0; pass < kPasses; ++pass) {
    std::vector<Face> faces = processes.exchange_joined(faces_of_pass(chunk, count, kPasses, pass));
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
      return a.key != b.key ? a.key < b.key : a.tetrahedron < b.tetrahedron;
    });
    std::vector<std::vector<Neighbors>> pairs(at(count));
    std::vector<std::vector<FaceMatches::OuterFace>> outer(at(count));
    const auto tell = [&](const Face& face, const Face& other) {
      pairs[at(tetrahedra.process_of(face.tetrahedron))].push_back(
          {face.tetrahedron, other.tetrahedron});
    };
    for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
      while (end < faces.size() && faces[end].key == faces[begin].key) ++end;
      for (std::size_t i = begin; i + 1 < end; ++i) {
        tell(faces[i], faces[i + 1]);
        tell(faces[i + 1], faces[i]);
      }
      if (end - begin > 1) continue;
      const Face& face = faces[begin];
      matches.boundary.push_back({face.key[0], face.key[1], face.key[2]});
      outer[at(tetrahedra.process_of(face.tetrahedron))].push_back(
          {face.tetrahedron, matches.boundary.back()});
    }
    faces = {};
    const auto own = processes.exchange_joined(outer);
    matches.of_tetrahedra.insert(matches.of_tetrahedra.end(), own.begin(), own.end());
    for (const Neighbors& pair : processes.exchange_joined(pairs)) {
      auto& row = matches.neighbors[at(pair.tetrahedron - chunk.first_tetrahedron)];
      const auto free = std::find(row.begin(), row.end(), kNone);
      if (free != row.end() && std::find(row.begin(), free, pair.neighbor) == free) {
        *free = pair.neighbor;
      }
    }
  }
  std::sort(matches.boundary.begin(), matches.boundary.end());
  for (auto& row : matches.neighbors) {
    std::sort(row.begin(), std::find(row.begin(), row.end(), kNone));
  }
  return matches;
}

}  // namespace tetraction::petsc
