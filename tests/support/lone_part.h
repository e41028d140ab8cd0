// A part of a mesh without other processes.
#pragma once

#include <algorithm>
#include <functional>

#include "tetraction/mesh/mesh_part.h"

namespace tetraction::testing_support {

/// The only part of a mesh, which counts how often it is asked for something. Vertices may be said to be shared, or to be
/// copies of those of others.
class LonePart : public MeshPart {
 public:
  explicit LonePart(Index owned) { owned_vertices = owned; }
  /// For a whole mesh of so many vertices and tetrahedra.
  LonePart(Index vertex_count, Index tetrahedron_count) : LonePart(vertex_count) {
    for (Index v = 0; v < vertex_count; ++v) vertex_numbers.push_back(v);
    whole.vertices = vertex_count;
    whole.tetrahedra = tetrahedron_count;
  }

  int rank() const override { return 0; }
  int count() const override { return 1; }
  void begin_adding(const double* values, Index /*width*/) const override {
    ++exchanges;
    if (on_begin) on_begin(values);
  }
  void end_adding(double* /*values*/, Index /*width*/) const override {}
  void sum(double* /*values*/, Index /*count*/) const override { ++reductions; }
  void largest(double* /*values*/, Index /*count*/) const override { ++reductions; }
  void gather(const double* own, const std::vector<Index>& counts, double* all) const override {
    ++reductions;
    std::copy_n(own, counts[0], all);
  }
  void broadcast(std::string& /*text*/, int /*from*/) const override { ++reductions; }
  Vector collect(const Vector& values, Index /*width*/) const override { return values; }
  Vector scatter(const Vector& values, Index /*width*/) const override { return values; }

  mutable int reductions = 0;
  mutable int exchanges = 0;
  std::function<void(const double* values)> on_begin;
};

}  // namespace tetraction::testing_support
