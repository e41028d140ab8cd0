#include "tetraction/dynamics/contact/moved_masses.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The largest part of its mass that the correction may take from a vertex: with the tensor of inertia kept, and
// without.
constexpr double kMostOfQuadratic = 0.75;
constexpr double kMostOfLinear = 0.9;
// Of the moments that are to be kept, relative to those of the whole body.
constexpr double kRoundOffOfMoments = 1e-10;

[[noreturn]] void refuse(const std::string& why) {
  throw InputError(fmt::format(
      "contact.mass: {}. Let fewer faces touch the obstacles (obstacle.select), take a finer mesh, "
      "or leave the key out.",
      why));
}

// The edges between vertices, as the numbers of neighbours with the mass of the tetrahedra that they share.
std::vector<std::map<Index, double>> neighbors_of(const Body& body) {
  std::vector<std::map<Index, double>> neighbors(static_cast<std::size_t>(body.vertex_count()));
  for (Index e = 0; e < body.rest().element_count(); ++e) {
    const double mass = body.element_mass(e);
    const ElementNodes nodes = body.rest().nodes(e);
    for (const Index a : nodes) {
      for (const Index b : nodes) {
        if (a != b) neighbors[static_cast<std::size_t>(a)][b] += mass;
      }
    }
  }
  return neighbors;
}

class MassMove {
 public:
  MassMove(const Body& body, const std::vector<Index>& contact)
      : neighbors_(neighbors_of(body)),
        touches_(static_cast<std::size_t>(body.vertex_count()), false) {
    for (const Index v : contact) touches_[static_cast<std::size_t>(v)] = true;
  }

  bool touches(Index v) const { return touches_[static_cast<std::size_t>(v)]; }

  // The vertices that take the mass of v, with their shares, which add up to 1. Empty if there are none.
  std::vector<std::pair<Index, double>> receivers(Index v) const {
    std::vector<std::pair<Index, double>> found;
    double sum = 0.0;
    for (const auto& [j, mass] : neighbors_[static_cast<std::size_t>(v)]) {
      if (touches(j)) continue;
      found.emplace_back(j, mass);
      sum += mass;
    }
    if (found.empty()) {
      for (const Index j : nearest_inside(v)) found.emplace_back(j, 1.0);
      sum = static_cast<double>(found.size());
    }
    for (auto& [j, weight] : found) weight /= sum;
    return found;
  }

 private:
  // The vertices inside with the fewest edges between them and v.
  std::set<Index> nearest_inside(Index v) const {
    std::set<Index> seen{v};
    std::set<Index> front{v};
    while (!front.empty()) {
      std::set<Index> next;
      std::set<Index> inside;
      for (const Index i : front) {
        for (const auto& [j, mass] : neighbors_[static_cast<std::size_t>(i)]) {
          if (!seen.insert(j).second) continue;
          next.insert(j);
          if (!touches(j)) inside.insert(j);
        }
      }
      if (!inside.empty()) return inside;
      front = std::move(next);
    }
    return {};
  }

  std::vector<std::map<Index, double>> neighbors_;
  std::vector<bool> touches_;
};

// 1, x, y, z, and for the tensor of inertia x², y², z², xy, yz, xz.
Vector powers(const Vector3& x, Index count) {
  Vector result(count);
  result.head<4>() << 1.0, x;
  if (count > 4) {
    result.tail<6>() << x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.x() * x.y(), x.y() * x.z(),
        x.x() * x.z();
  }
  return result;
}

// Multiplies the masses of vertices inside by 1 + p. Returns false, and changes nothing, if there is no p, or if it
// takes more than `most` of a mass.
bool correct(const MassMove& move, const Matrix& x, const Vector& wanted, Index count, double most,
             Vector& mass) {
  Matrix gram = Matrix::Zero(count, count);
  Vector missing = Vector::Zero(count);
  for (Index v = 0; v < mass.size(); ++v) {
    const Vector own = powers(x.col(v), count);
    missing += (wanted[v] - mass[v]) * own;
    if (!move.touches(v)) gram += mass[v] * own * own.transpose();
  }
  const Vector p = gram.completeOrthogonalDecomposition().solve(missing);
  if (!((gram * p - missing).norm() <= kRoundOffOfMoments * wanted.sum())) return false;
  Vector corrected = mass;
  for (Index v = 0; v < mass.size(); ++v) {
    if (move.touches(v)) continue;
    const double factor = 1.0 + p.dot(powers(x.col(v), count));
    if (!(factor >= 1.0 - most)) return false;
    corrected[v] *= factor;
  }
  mass = std::move(corrected);
  return true;
}

}  // namespace

Vector moved_masses(const Body& body, const std::vector<Index>& contact, double share) {
  const MassMove move(body, contact);
  const Vector wanted = body.lumped_masses();
  Vector mass = wanted;
  for (const Index v : contact) {
    const double moved = (1.0 - share) * wanted[v];
    const auto receivers = move.receivers(v);
    if (receivers.empty()) {
      refuse(
          fmt::format("all vertices of the part of the body with vertex {} may touch obstacles, so "
                      "that their masses have no place inside",
                      body.mesh().vertex_id(v)));
    }
    mass[v] -= moved;
    for (const auto& [j, weight] : receivers) mass[j] += weight * moved;
  }
  // Positions from the centre of mass, of the size of the body.
  Matrix x = body.mesh().rest_positions().reshaped(3, body.vertex_count());
  const Vector3 center = x * wanted / wanted.sum();
  x.colwise() -= center;
  x /= x.colwise().norm().maxCoeff();
  if (correct(move, x, wanted, 10, kMostOfQuadratic, mass)) return mass;
  if (correct(move, x, wanted, 4, kMostOfLinear, mass)) return mass;
  refuse(
      "the body has too few vertices beyond those that may touch obstacles to keep its centre of "
      "mass where it is");
}

}  // namespace tetraction
