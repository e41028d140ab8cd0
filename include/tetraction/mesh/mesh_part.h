// The part of a mesh that one process holds, where several processes hold the mesh together.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/core/types.h"
#include "tetraction/mesh/mesh_fingerprints.h"

namespace tetraction {

/// The whole of which the TetMesh of one process is a part, and its communication with the others (TetMesh::part).
///
/// Every tetrahedron belongs to one process. A vertex belongs to one process, too, its owner; the other
/// processes whose tetrahedra use it have copies of it. In the mesh of a process its own vertices come
/// first. A field over the vertices is the same on all copies, and whatever is assembled from tetrahedra
/// is complete after add_shared(). Sums over vertices take owners only.
///
/// The functions of this class other than rank() and count() are collective: every process must call
/// them, in the same order. Their results have the same bits on all processes, so that all of them take
/// the same decisions.
class MeshPart {
 public:
  virtual ~MeshPart() = default;

  /// The number of this process, from 0, and of all of them.
  virtual int rank() const = 0;
  virtual int count() const = 0;

  /// values: `width` numbers for each vertex of the part's mesh, that of vertex v from width v on. The
  /// numbers of the copies of a vertex are added up, in the order of the processes.
  void add_shared(double* values, Index width) const {
    begin_adding(values, width);
    end_adding(values, width);
  }
  /// add_shared() in two halves. The numbers of shared vertices must be complete, as far as they are this
  /// part's own, at the first half and stay as they are until the second; those of other vertices may change. No
  /// other function may be called in between.
  virtual void begin_adding(const double* values, Index width) const = 0;
  virtual void end_adding(double* values, Index width) const = 0;
  /// values[i] ← the sum of values[i] over all processes, in their order.
  virtual void sum(double* values, Index count) const = 0;
  /// values[i] ← the largest values[i] of all processes.
  virtual void largest(double* values, Index count) const = 0;
  /// all ← the numbers of all processes, one after the other in the order of the processes. `counts`:
  /// how many each process has (counts_of_parts()). `own` may be at its place in `all`.
  virtual void gather(const double* own, const std::vector<Index>& counts, double* all) const = 0;
  /// text ← that of the process `from`.
  virtual void broadcast(std::string& text, int from) const = 0;
  /// On process 0 the numbers of all vertices of the whole mesh, in its order, each from its owner; elsewhere
  /// an empty vector. values: as for add_shared().
  virtual Vector collect(const Vector& values, Index width) const = 0;
  /// The numbers of the part's vertices out of those of the whole mesh, which process 0 has; elsewhere
  /// `whole_values` is not read. The inverse of collect().
  virtual Vector scatter(const Vector& whole_values, Index width) const = 0;

  /// `own` of each process.
  std::vector<Index> counts_of_parts(Index own) const {
    std::vector<double> counts(static_cast<std::size_t>(count()), 0.0);
    counts[static_cast<std::size_t>(rank())] = static_cast<double>(own);
    sum(counts.data(), count());
    return {counts.begin(), counts.end()};
  }
  /// Gives the copies of a vertex the numbers of its owner; values as for add_shared().
  void copy_from_owners(double* values, Index width) const {
    for (const Index v : shared_vertices) {
      if (v >= owned_vertices) std::fill_n(values + width * v, width, 0.0);
    }
    add_shared(values, width);
  }

  /// The number of the first vertices of the part's mesh, which belong to this process.
  Index owned_vertices = 0;
  /// The vertices that other parts have, too, ascending.
  std::vector<Index> shared_vertices;
  /// The numbers of the part's vertices in the whole mesh.
  std::vector<Index> vertex_numbers;
  /// The whole mesh.
  struct Whole {
    Index vertices = 0;
    Index tetrahedra = 0;
    double volume = 0.0;  ///< m³
    Vector3 low = Vector3::Zero();
    Vector3 high = Vector3::Zero();                          ///< the corners of its box, m
    std::pair<std::int64_t, std::int64_t> vertex_ids{0, 0};  ///< least and largest
    MeshFingerprints fingerprints;
  };
  Whole whole;
  /// The triangles of the part's tetrahedra on the boundary of the whole mesh (boundary_faces()).
  std::vector<std::array<Index, 3>> boundary_faces;
  /// The vertices of the part that are on this boundary, ascending: also those that only triangles of
  /// other parts have.
  std::vector<Index> boundary_vertices;

 protected:
  MeshPart() = default;
  MeshPart(const MeshPart&) = default;
  MeshPart& operator=(const MeshPart&) = default;
};

using SharedMeshPart = std::shared_ptr<const MeshPart>;

// The same functions for a mesh that may be whole. Then `part` is null, and they change nothing.

inline void add_shared(const MeshPart* part, Vector& values, Index width) {
  if (part != nullptr) part->add_shared(values.data(), width);
}
inline void copy_from_owners(const MeshPart* part, Vector& values, Index width) {
  if (part != nullptr) part->copy_from_owners(values.data(), width);
}
inline void sum_over_parts(const MeshPart* part, double* values, Index count) {
  if (part != nullptr) part->sum(values, count);
}
inline double sum_over_parts(const MeshPart* part, double value) {
  if (part != nullptr) part->sum(&value, 1);
  return value;
}
inline double largest_of_parts(const MeshPart* part, double value) {
  if (part != nullptr) part->largest(&value, 1);
  return value;
}
inline double least_of_parts(const MeshPart* part, double value) {
  return part == nullptr ? value : -largest_of_parts(part, -value);
}
/// Whether it is so on every process.
inline bool everywhere(const MeshPart* part, bool value) {
  return part == nullptr ? value : largest_of_parts(part, value ? 0.0 : 1.0) == 0.0;
}
/// Whether it is so on some process.
inline bool anywhere(const MeshPart* part, bool value) {
  return part == nullptr ? value : largest_of_parts(part, value ? 1.0 : 0.0) != 0.0;
}
/// The first process on which it is so. If there is none, the number of processes.
inline int first_process(const MeshPart& part, bool value) {
  return static_cast<int>(least_of_parts(&part, value ? part.rank() : part.count()));
}
/// text ← the text of the first process that has one. Returns whether there is such a process.
inline bool take_from_first(const MeshPart* part, bool has, std::string& text) {
  if (part == nullptr) return has;
  const int first = first_process(*part, has);
  if (first == part->count()) return false;
  part->broadcast(text, first);
  return true;
}

}  // namespace tetraction
