// Surfaces for tests of contact.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "dynamics/contact/obstacle_contact.h"
#include "tetraction/core/types.h"

namespace tetraction {

struct Triangles {
  std::vector<Vector3> points;
  std::vector<std::array<Index, 3>> triangles;
};

/// The square [0, size]² in the plane z = 0, of n × n cells with two triangles each.
inline Triangles flat_grid(int n, double size) {
  Triangles grid;
  const double h = size / n;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) grid.points.emplace_back(h * i, h * j, 0.0);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i;
      const Index b = a + 1;
      const Index c = a + n + 1;
      const Index d = c + 1;
      if ((i + j) % 2 == 0) {
        grid.triangles.push_back({a, b, d});
        grid.triangles.push_back({a, d, c});
      } else {
        grid.triangles.push_back({a, b, c});
        grid.triangles.push_back({b, d, c});
      }
    }
  }
  return grid;
}

/// The outward surface of the cube [0, size]³; each face has n × n cells.
inline Triangles cube_surface(int n, double size) {
  Triangles cube;
  std::map<std::array<int, 3>, Index> numbers;
  const Triangles face = flat_grid(n, n);
  const auto number = [&](const std::array<int, 3>& p) {
    const Index next = static_cast<Index>(cube.points.size());
    const auto [found, is_new] = numbers.try_emplace(p, next);
    if (is_new) cube.points.emplace_back(size / n * p[0], size / n * p[1], size / n * p[2]);
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int side : {0, n}) {
      for (const auto& t : face.triangles) {
        std::array<Index, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
          const Vector3& uv = face.points[static_cast<std::size_t>(t[k])];
          std::array<int, 3> p{};
          p[axis] = side;
          p[(axis + 1) % 3] = static_cast<int>(std::lround(uv[0]));
          p[(axis + 2) % 3] = static_cast<int>(std::lround(uv[1]));
          corners[k] = number(p);
        }
        if (side == 0) std::swap(corners[1], corners[2]);
        cube.triangles.push_back(corners);
      }
    }
  }
  return cube;
}

inline ContactSurface contact_surface(const Triangles& body) {
  ContactSurface surface;
  surface.triangles = body.triangles;
  surface.areas.assign(body.points.size(), 0.0);
  surface.rest.resize(3 * static_cast<Index>(body.points.size()));
  std::set<std::array<Index, 2>> edges;
  for (std::size_t i = 0; i < body.points.size(); ++i) {
    surface.vertices.push_back(static_cast<Index>(i));
    vertex_block(surface.rest, static_cast<Index>(i)) = body.points[i];
  }
  for (const auto& t : body.triangles) {
    const Vector3& a = body.points[static_cast<std::size_t>(t[0])];
    const Vector3 u = body.points[static_cast<std::size_t>(t[1])] - a;
    const Vector3 v = body.points[static_cast<std::size_t>(t[2])] - a;
    for (std::size_t k = 0; k < 3; ++k) {
      surface.areas[static_cast<std::size_t>(t[k])] += u.cross(v).norm() / 6.0;
      edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  }
  surface.edges.assign(edges.begin(), edges.end());
  return surface;
}

/// A dense matrix of the blocks of a surface.
class DenseBlocks : public SurfaceBlocks {
 public:
  explicit DenseBlocks(Index vertices) : matrix(Matrix::Zero(3 * vertices, 3 * vertices)) {}
  void add(Index i, const Matrix3& block) override { matrix.block<3, 3>(3 * i, 3 * i) += block; }
  void add_pair(Index i, Index j, const Matrix3& block) override {
    matrix.block<3, 3>(3 * i, 3 * j) += block;
    matrix.block<3, 3>(3 * j, 3 * i) += block.transpose();
  }

  Matrix matrix;
};

}  // namespace tetraction
