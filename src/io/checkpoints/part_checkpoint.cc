#include "part_checkpoint.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "checkpoint_members.h"

namespace tetraction {
namespace {

using FixList = std::vector<PrescribedVertices>;

constexpr std::size_t kVertexVectors = 5;

// The vectors of a checkpoint that have three numbers for each vertex, but for the external force, which may be empty.
std::array<Vector*, kVertexVectors> vertex_vectors(Checkpoint& checkpoint) {
  State& state = checkpoint.state;
  return {&state.position, &state.momentum, &state.velocity, &checkpoint.reactions.force,
          &checkpoint.reactions.delay};
}

// The vertices of a [[fix]] of all parts with their positions, by their numbers in the whole mesh.
void collect_fix(const MeshPart& part, PrescribedVertices& fix) {
  constexpr Index kWidth = 4;
  std::vector<double> own;
  for (std::size_t i = 0; i < fix.vertices.size(); ++i) {
    const Index v = fix.vertices[i];
    if (v >= part.owned_vertices) continue;
    const Vector3 start = fix.start.col(static_cast<Index>(i));
    own.push_back(static_cast<double>(part.vertex_numbers[static_cast<std::size_t>(v)]));
    own.insert(own.end(), start.begin(), start.end());
  }
  const std::vector<Index> counts = part.counts_of_parts(static_cast<Index>(own.size()));
  Index total = 0;
  for (const Index count : counts) total += count;
  Matrix all(kWidth, total / kWidth);
  part.gather(own.data(), counts, all.data());
  std::vector<Index> order(static_cast<std::size_t>(all.cols()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
  std::ranges::sort(order, {}, [&](Index i) { return all(0, i); });
  fix.vertices.clear();
  fix.start.resize(3, all.cols());
  for (const Index i : order) {
    fix.start.col(static_cast<Index>(fix.vertices.size())) = all.col(i).tail<3>();
    fix.vertices.push_back(static_cast<Index>(all(0, i)));
  }
}

// Those of the vertices that the part has, by their numbers there.
void pick_fix(const std::map<Index, Index>& own_number, PrescribedVertices& fix) {
  std::vector<std::pair<Index, Index>> places;  // own number, place in the list
  for (std::size_t i = 0; i < fix.vertices.size(); ++i) {
    const auto found = own_number.find(fix.vertices[i]);
    if (found != own_number.end()) places.emplace_back(found->second, static_cast<Index>(i));
  }
  std::ranges::sort(places);
  const Matrix start = std::exchange(fix.start, Matrix(3, static_cast<Index>(places.size())));
  fix.vertices.clear();
  for (const auto& [v, place] : places) {
    fix.start.col(static_cast<Index>(fix.vertices.size())) = start.col(place);
    fix.vertices.push_back(v);
  }
}

}  // namespace

Checkpoint collected(const MeshPart& part, const Checkpoint& own) {
  Checkpoint whole = own;
  for (Vector* vector : vertex_vectors(whole)) *vector = part.collect(*vector, 3);
  // It is empty in parts without such a force.
  Vector& force = whole.progress.external_force;
  if (anywhere(&part, force.size() > 0)) {
    if (force.size() == 0) force.setZero(own.state.position.size());
    force = part.collect(force, 3);
  }
  for (PrescribedVertices& fix : whole.settings.constraints.fixes) collect_fix(part, fix);
  return whole;
}

StoredCheckpoint scattered(const MeshPart& part, StoredCheckpoint whole) {
  // Everything but the vectors goes to all processes.
  std::array<Vector, kVertexVectors> vectors;
  Vector force;
  std::string bytes;
  if (part.rank() == 0) {
    const auto from = vertex_vectors(whole.checkpoint);
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = std::exchange(*from[i], {});
    force = std::exchange(whole.checkpoint.progress.external_force, {});
    ArchiveWriter writer;
    transfer(writer, whole);
    bytes = writer.take();
  }
  part.broadcast(bytes, 0);
  StoredCheckpoint own;
  ArchiveReader reader(bytes);
  transfer(reader, own);
  const auto to = vertex_vectors(own.checkpoint);
  for (std::size_t i = 0; i < vectors.size(); ++i) *to[i] = part.scatter(vectors[i], 3);
  if (anywhere(&part, force.size() > 0)) {
    own.checkpoint.progress.external_force = part.scatter(force, 3);
  }
  own.checkpoint.progress.plan.automatic.modes = {};  // over the free coordinates of the whole body
  std::map<Index, Index> own_number;
  for (std::size_t v = 0; v < part.vertex_numbers.size(); ++v) {
    own_number.emplace(part.vertex_numbers[v], static_cast<Index>(v));
  }
  for (PrescribedVertices& fix : own.checkpoint.settings.constraints.fixes) {
    pick_fix(own_number, fix);
  }
  return own;
}

}  // namespace tetraction
