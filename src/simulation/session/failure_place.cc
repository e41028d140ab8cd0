#include "failure_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/derived_fields.h"

namespace tetraction {
namespace {

// Elements with so much of the largest energy density belong to the place of a failure.
constexpr double kConcerned = 0.5;

Vector3 rest_centroid(const TetMesh& mesh, Index e) {
  Vector3 sum = Vector3::Zero();
  for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
    sum += mesh.vertices[static_cast<std::size_t>(v)];
  }
  return 0.25 * sum;
}

// In single precision, in which numbers that differ by round-off only are mostly equal. Symmetric bodies have such
// elements, and the one with the lowest number is then named.
double rounded(double number) {
  return static_cast<double>(static_cast<float>(number));
}

// Elements, the worst first, and how bad that one is, to compare it with those of other parts.
struct ConcernedElements {
  std::vector<Index> elements;
  double badness = -std::numeric_limits<double>::infinity();
};

// The elements that a motion to q inverts or tears to places that are no numbers, the worst first.
ConcernedElements broken_elements(const MechanicalSystem& system, const Vector& q) {
  std::vector<std::pair<double, Index>> broken;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const double jacobian = least_jacobian(system, e, q);
    if (jacobian > 0.0 && std::isfinite(jacobian)) continue;
    broken.emplace_back(
        std::isfinite(jacobian) ? rounded(jacobian) : -std::numeric_limits<double>::infinity(), e);
  }
  std::sort(broken.begin(), broken.end());
  ConcernedElements found;
  if (!broken.empty()) found.badness = -broken.front().first;
  found.elements.reserve(broken.size());
  for (const auto& entry : broken) found.elements.push_back(entry.second);
  return found;
}

// The elements with the largest energy densities at q, the largest first.
ConcernedElements hot_elements(const MechanicalSystem& system, const Vector& q) {
  Vector of_points;
  system.elastic_energy_densities(q, of_points);
  const Vector densities =
      of_points.reshaped(system.rest().points_per_element(), system.rest().element_count())
          .colwise()
          .maxCoeff()
          .transpose()
          .unaryExpr(&rounded);
  const double most = largest_of_parts(system.part(), densities.maxCoeff());
  std::vector<Index> elements;
  for (Index e = 0; e < densities.size(); ++e) {
    if (!(densities[e] < kConcerned * most)) elements.push_back(e);
  }
  std::stable_sort(elements.begin(), elements.end(),
                   [&](Index a, Index b) { return densities[a] > densities[b]; });
  // Where the energy is the same everywhere, as in a body at rest, it tells nothing.
  const double count = sum_over_parts(system.part(), static_cast<double>(elements.size()));
  if (count > 0.5 * static_cast<double>(global_tetrahedron_count(system))) elements.clear();
  ConcernedElements found;
  if (!elements.empty()) found.badness = densities[elements.front()];
  found.elements = std::move(elements);
  return found;
}

// The elements at the vertex with the largest force (3 per vertex; empty: none).
ConcernedElements loaded_elements(const MechanicalSystem& system, const Vector& forces) {
  Index loaded = 0;
  double most = -1.0;
  const Index count = std::min(forces.size() / 3, system.owned_vertex_count());
  for (Index v = 0; v < count; ++v) {
    const double force = vertex_block(forces, v).norm();
    if (force <= most) continue;
    most = force;
    loaded = v;
  }
  ConcernedElements found;
  found.badness = most;
  // The other parts leave this to the one that owns the vertex.
  if (most < largest_of_parts(system.part(), most)) return found;
  std::vector<Index>& elements = found.elements;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const ElementNodes nodes = system.rest().nodes(e);
    if (std::find(nodes.begin(), nodes.end(), loaded) != nodes.end()) elements.push_back(e);
  }
  return found;
}

bool holds_moving_vertex(const MechanicalSystem& system, Index e) {
  const Constraints& constraints = system.constraints();
  if (!constraints.moving()) return false;
  const std::vector<Index> held = constraints.constrained_vertices();
  const ElementNodes nodes = system.rest().nodes(e);
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](Index v) { return std::binary_search(held.begin(), held.end(), v); });
}

}  // namespace

void locate(const RunData& run, Index element, StepFailure& failure) {
  const MechanicalSystem& system = *run.system;
  const MeshPart* part = system.part();
  const Vector& trial = failure.attempted_position;
  ConcernedElements found;
  const auto is_found = [&] { return anywhere(part, !found.elements.empty()); };
  if (trial.size() > 0) found = broken_elements(system, trial);
  const bool is_broken = is_found();
  if (!is_broken && element >= 0) found = {{element}, 0.0};
  if (!is_found()) found = hot_elements(system, run.state().position);
  if (!is_found()) found = loaded_elements(system, next_external_force(run));
  failure.elements = std::move(found.elements);
  failure.element_count =
      static_cast<Index>(sum_over_parts(part, static_cast<double>(failure.elements.size())));
  if (part != nullptr) {
    bool is_worst =
        largest_of_parts(part, found.badness) == found.badness && !failure.elements.empty();
    const double id =
        is_worst ? static_cast<double>(system.mesh().tetrahedron_id(failure.elements.front()))
                 : std::numeric_limits<double>::infinity();
    is_worst = least_of_parts(part, id) == id && is_worst;
    failure.process = first_process(*part, is_worst);
    if (failure.process == part->count()) failure.process = 0;
  }
  if (failure.elements.empty()) return;
  failure.jacobian =
      least_jacobian(system, failure.elements.front(), is_broken ? trial : run.state().position);
}

bool worst_is_held(const MechanicalSystem& system, const StepFailure& failure) {
  const MeshPart* part = system.part();
  const bool is_worst = part == nullptr || part->rank() == failure.process;
  return anywhere(part, is_worst && !failure.elements.empty() &&
                            holds_moving_vertex(system, failure.elements.front()));
}

std::string place_of(const MechanicalSystem& system, const StepFailure& failure) {
  if (failure.elements.empty()) return {};
  const Index e = failure.elements.front();
  const Vector3 center = rest_centroid(system.mesh(), e);
  std::string text = fmt::format(
      " at element {} (region {}, centroid ({:.4g}, {:.4g}, {:.4g}) m at rest, ",
      system.mesh().tetrahedron_id(e), system.region(e), center.x(), center.y(), center.z());
  text += std::isfinite(failure.jacobian) ? fmt::format("J = {:.3g}", failure.jacobian)
                                          : "J is not a finite number";
  // The step did not get as far as where an element is inverted.
  if (failure.jacobian > 0.0 && failure.attempted_position.size() == 0) text += " before the step";
  text += ")";
  if (failure.element_count > 1) {
    text += fmt::format(" and {} more", failure.element_count - 1);
  }
  return text;
}

}  // namespace tetraction
