#include "part_data.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "vertex_values.h"

namespace tetraction::petsc {
namespace {

using Triangle = std::array<Index, 3>;

Triangle sorted(Triangle triangle) {
  std::sort(triangle.begin(), triangle.end());
  return triangle;
}

// The faces of a tetrahedron of positive volume, with outward normals.
constexpr std::array<std::array<std::size_t, 3>, 4> kOutwardFaces{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// Lists of different lengths, one after the other.
struct Lists {
  std::vector<std::size_t> first{0};
  std::vector<int> items;

  std::span<const int> operator[](std::size_t i) const {
    return {items.data() + first[i], first[i + 1] - first[i]};
  }
  void append(std::span<const int> list) {
    items.insert(items.end(), list.begin(), list.end());
    first.push_back(items.size());
  }
};

// A cell of a group, by the numbers of the whole mesh.
template <std::size_t kCount>
struct Member {
  Index group;
  std::array<Index, kCount> numbers;
  bool is_on_boundary;
};

class PartCollection {
 public:
  PartCollection(MeshChunk chunk, const std::vector<int>& part, const FaceMatches& faces,
                 const AllToAll& processes)
      : chunk_(std::move(chunk)), part_(part), faces_(faces), processes_(processes) {}

  PartData collect() {
    data_.whole = chunk_.whole;
    data_.mesh.source = chunk_.mesh.source;
    data_.mesh.report = chunk_.mesh.report;
    collect_tetrahedra();
    collect_vertices();
    number_vertices();
    collect_faces();
    collect_groups();
    return std::move(data_);
  }

 private:
  template <class Item>
  std::vector<std::vector<Item>> lists() const {
    return std::vector<std::vector<Item>>(at(processes_.count()));
  }
  // The chunk's values of tetrahedra, `width` for each, for the processes that get them. The ranges of the
  // processes ascend, so that the tetrahedra stay in their order.
  template <class Item>
  std::vector<Item> of_tetrahedra(const Item* values, std::size_t width) const {
    auto sent = lists<Item>();
    for (std::size_t e = 0; e < part_.size(); ++e) {
      auto& list = sent[at(part_[e])];
      list.insert(list.end(), values + width * e, values + width * (e + 1));
    }
    return processes_.exchange_joined(sent);
  }

  void collect_tetrahedra() {
    TetMesh& mesh = chunk_.mesh;
    std::vector<Index> numbers;
    for (std::size_t e = 0; e < part_.size(); ++e) {
      numbers.push_back(chunk_.first_tetrahedron + static_cast<Index>(e));
    }
    tetrahedra_ = of_tetrahedra(numbers.data(), 1);
    data_.mesh.tetrahedra.own() = of_tetrahedra(mesh.tetrahedra.own().data(), 1);
    data_.mesh.tetrahedron_ids = of_tetrahedra(mesh.tetrahedron_ids.data(), 1);
    data_.mesh.regions = of_tetrahedra(mesh.regions.data(), mesh.regions.empty() ? 0 : 1);
    for (const auto& [name, values] : mesh.cell_arrays) {
      const std::vector<double> own = of_tetrahedra(values.data(), at(values.rows()));
      data_.mesh.cell_arrays[name] =
          Eigen::Map<const Matrix>(own.data(), values.rows(), data_.mesh.tetrahedron_count());
    }
    mesh.tetrahedra = {};
    mesh.tetrahedron_ids = {};
    mesh.cell_arrays.clear();
  }

  // In the order of the whole mesh: what the vertices of the part are, and which processes have them.
  void collect_vertices() {
    vertices_ = vertices_of(data_.mesh.tetrahedra);
    const auto asked = processes_.exchange(by_process(chunk_, vertices_, processes_));
    const auto in_chunk = [&](Index v) { return at(v - chunk_.first_vertex); };
    // The lists of the processes are ascending, and are read together vertex by vertex.
    std::vector<std::size_t> next(asked.size(), 0);
    std::vector<int> own;
    for (Index v = chunk_.first_vertex; v < chunk_.first_vertex + chunk_.mesh.vertex_count(); ++v) {
      own.clear();
      for (std::size_t p = 0; p < asked.size(); ++p) {
        if (next[p] < asked[p].size() && asked[p][next[p]] == v) {
          own.push_back(static_cast<int>(p));
          ++next[p];
        }
      }
      sharers_in_chunk_.append(own);
    }
    const auto counts = answers(asked, processes_, [&](Index v) {
      return static_cast<int>(sharers_in_chunk_[in_chunk(v)].size());
    });
    auto sharers = lists<int>();
    for (std::size_t p = 0; p < asked.size(); ++p) {
      for (const Index v : asked[p]) {
        const auto list = sharers_in_chunk_[in_chunk(v)];
        sharers[p].insert(sharers[p].end(), list.begin(), list.end());
      }
    }
    sharers_.items = processes_.exchange_joined(sharers);
    for (const int count : counts) sharers_.first.push_back(sharers_.first.back() + at(count));

    positions_ = positions_of(chunk_, asked, processes_);
    ids_ = answers(asked, processes_, [&](Index v) { return chunk_.mesh.vertex_ids[in_chunk(v)]; });
    const std::vector<std::uint8_t> on_boundary = boundary_vertices_in_chunk();
    on_boundary_ = answers(asked, processes_, [&](Index v) { return on_boundary[in_chunk(v)]; });
    for (const auto& [name, values] : chunk_.mesh.point_arrays) {
      auto sent = lists<double>();
      for (std::size_t p = 0; p < asked.size(); ++p) {
        for (const Index v : asked[p]) {
          const auto column = values.col(v - chunk_.first_vertex);
          sent[p].insert(sent[p].end(), column.begin(), column.end());
        }
      }
      const std::vector<double> own_values = processes_.exchange_joined(sent);
      point_arrays_[name] = Eigen::Map<const Matrix>(own_values.data(), values.rows(),
                                                     static_cast<Index>(vertices_.size()));
    }
  }

  // A process knows the faces with their least vertex in its chunk, and tells the others of the other vertices.
  std::vector<std::uint8_t> boundary_vertices_in_chunk() const {
    std::vector<Index> vertices;
    for (const Triangle& face : faces_.boundary) {
      vertices.insert(vertices.end(), face.begin(), face.end());
    }
    sort_and_unite(vertices);
    std::vector<std::uint8_t> on_boundary(at(chunk_.mesh.vertex_count()), 0);
    for (const Index v : processes_.exchange_joined(by_process(chunk_, vertices, processes_))) {
      on_boundary[at(v - chunk_.first_vertex)] = 1;
    }
    return on_boundary;
  }

  // The part's own vertices come before the copies.
  void number_vertices() {
    TetMesh& mesh = data_.mesh;
    std::vector<std::size_t> order;  // places in vertices_
    std::vector<std::size_t> copies;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const auto sharers = sharers_[i];
      // Vertices with the same sharers have the same owner, and pairs of processes take turns.
      const int sum = std::accumulate(sharers.begin(), sharers.end(), 0);
      const int owner = sharers[at(sum) % sharers.size()];
      (owner == processes_.rank() ? order : copies).push_back(i);
    }
    data_.owned_vertices = static_cast<Index>(order.size());
    order.insert(order.end(), copies.begin(), copies.end());
    local_.resize(vertices_.size());
    mesh.vertices.own().reserve(order.size());
    for (const std::size_t i : order) {
      const auto v = static_cast<Index>(mesh.vertices.size());
      local_[i] = v;
      mesh.vertices.own().push_back(positions_[i]);
      mesh.vertex_ids.push_back(ids_[i]);
      data_.vertex_numbers.push_back(vertices_[i]);
      if (on_boundary_[i] != 0) data_.boundary_vertices.push_back(v);
    }
    for (auto& [name, values] : point_arrays_) {
      Matrix& to = mesh.point_arrays[name];
      to.resize(values.rows(), values.cols());
      for (std::size_t i = 0; i < local_.size(); ++i) {
        to.col(local_[i]) = values.col(static_cast<Index>(i));
      }
    }
    for (auto& corners : mesh.tetrahedra.own()) {
      for (Index& v : corners) v = local(v);
    }
    std::map<int, std::vector<Index>> shared;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      for (const int p : sharers_[i]) {
        if (p != processes_.rank()) shared[p].push_back(local_[i]);
      }
    }
    for (auto& [rank, list] : shared) data_.neighbors.push_back({rank, std::move(list)});
    positions_ = {};
    ids_ = {};
    point_arrays_.clear();
  }

  Index local(Index v) const { return local_[at(place_of(vertices_, v))]; }
  // Whether all of them are in the part, whose numbers they then get.
  template <std::size_t kCount>
  bool to_local(std::array<Index, kCount>& vertices) const {
    for (Index& v : vertices) {
      const Index place = place_of(vertices_, v);
      if (place == static_cast<Index>(vertices_.size()) || vertices_[at(place)] != v) return false;
      v = local_[at(place)];
    }
    return true;
  }

  // The faces of the part's tetrahedra on the boundary of the whole mesh, in the order of boundary_faces().
  void collect_faces() {
    auto sent = lists<FaceMatches::OuterFace>();
    for (const FaceMatches::OuterFace& face : faces_.of_tetrahedra) {
      sent[at(part_[at(face.tetrahedron - chunk_.first_tetrahedron)])].push_back(face);
    }
    std::map<Triangle, Triangle> outward;  // by sorted vertices of the part
    for (const auto& [tetrahedron, vertices] : processes_.exchange_joined(sent)) {
      Triangle key = vertices;
      to_local(key);
      key = sorted(key);
      outward.emplace(key, outward_face(place_of(tetrahedra_, tetrahedron), key));
    }
    for (const auto& [key, face] : outward) data_.boundary_faces.push_back(face);
  }

  // The face of the part's tetrahedron e with these vertices, seen from outside.
  Triangle outward_face(Index e, const Triangle& ascending) const {
    const auto corners = data_.mesh.tetrahedra[at(e)];
    for (const auto& face : kOutwardFaces) {
      const Triangle vertices{corners[face[0]], corners[face[1]], corners[face[2]]};
      if (sorted(vertices) == ascending) return vertices;
    }
    return ascending;
  }

  // Sends the cells of groups to the processes that `to` lists for each.
  template <std::size_t kCount, class Cells, class To>
  std::vector<Member<kCount>> members(const Cells& cells, const To& to) const {
    auto sent = lists<Member<kCount>>();
    for (std::size_t g = 0; g < chunk_.mesh.groups.size(); ++g) {
      for (const auto& cell : cells(chunk_.mesh.groups[g])) {
        Member<kCount> member{static_cast<Index>(g), {}, false};
        if constexpr (kCount == 1) {
          member.numbers = {cell};
        } else {
          member.numbers = cell;
        }
        if constexpr (kCount == 3) member.is_on_boundary = faces_.is_on_boundary(sorted(cell));
        for (const int p : to(member.numbers)) sent[at(p)].push_back(member);
      }
    }
    return processes_.exchange_joined(sent);
  }

  // Groups stay in all parts, so that their names are known there.
  void collect_groups() {
    std::vector<Group>& groups = data_.mesh.groups;
    for (const Group& group : chunk_.mesh.groups) {
      Group& own = groups.emplace_back();
      own.name = group.name;
      own.dimension = group.dimension;
      own.tag = group.tag;
      own.detached_triangles = group.detached_triangles;
      own.detached_lines = group.detached_lines;
    }
    const auto sharers = [&](const auto& vertices) {
      const Index least = *std::min_element(vertices.begin(), vertices.end());
      return sharers_in_chunk_[at(least - chunk_.first_vertex)];
    };
    const auto vertices = members<1>(
        [](const Group& g) -> auto& { return g.vertices; }, sharers);
    for (const auto& [group, numbers, unused] : vertices) {
      groups[at(group)].vertices.push_back(local(numbers[0]));
    }
    const auto tetrahedra = members<1>(
        [](const Group& g) -> auto& { return g.tetrahedra; },
        [&](const std::array<Index, 1>& e) {
          return std::span<const int>(&part_[at(e[0] - chunk_.first_tetrahedron)], 1);
        });
    for (const auto& [group, numbers, unused] : tetrahedra) {
      groups[at(group)].tetrahedra.push_back(place_of(tetrahedra_, numbers[0]));
    }
    std::set<Triangle> own_faces;
    for (const Triangle& face : data_.boundary_faces) own_faces.insert(sorted(face));
    for (auto& [group, triangle, is_on_boundary] : members<3>(
             [](const Group& g) -> auto& { return g.triangles; }, sharers)) {
      if (!to_local(triangle)) continue;
      // A triangle of the boundary belongs to the part of its tetrahedron.
      if (is_on_boundary && !own_faces.contains(sorted(triangle))) continue;
      groups[at(group)].triangles.push_back(triangle);
    }
    for (auto& [group, line, unused] : members<2>(
             [](const Group& g) -> auto& { return g.lines; }, sharers)) {
      if (to_local(line)) groups[at(group)].lines.push_back(line);
    }
    for (Group& group : groups) std::sort(group.vertices.begin(), group.vertices.end());
  }

  MeshChunk chunk_;
  const std::vector<int>& part_;
  const FaceMatches& faces_;
  const AllToAll& processes_;
  PartData data_;
  std::vector<Index> tetrahedra_;  // numbers in the whole mesh, ascending
  // The part's vertices, in the order of the whole mesh:
  std::vector<Index> vertices_;  // their numbers there
  std::vector<Index> local_;     // … and in the part
  Lists sharers_;                // the processes that have them, ascending
  std::vector<Vector3> positions_;
  std::vector<std::int64_t> ids_;
  std::vector<std::uint8_t> on_boundary_;
  std::map<std::string, Matrix> point_arrays_;
  Lists sharers_in_chunk_;  // of the chunk's vertices
};

}  // namespace

PartData collect_part(MeshChunk chunk, const std::vector<int>& part, const FaceMatches& faces,
                      const AllToAll& processes) {
  return PartCollection(std::move(chunk), part, faces, processes).collect();
}

}  // namespace tetraction::petsc
