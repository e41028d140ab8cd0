#include "mpi_part.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "assembled_preconditioner.h"
#include "messages.h"

namespace tetraction::petsc {
namespace {

constexpr int kTag = 7;
// Up to so many processes all get the numbers of all and add them up themselves, …
constexpr int kFew = 64;
// … unless they are more than these.
constexpr Index kSmall = 1 << 16;

}  // namespace

MpiPart::MpiPart(const Processes& processes, PartData&& data)
    : rank_(processes.rank()),
      count_(processes.count()),
      neighbors_(std::move(data.neighbors)),
      sent_(neighbors_.size()),
      received_(neighbors_.size()),
      requests_(2 * neighbors_.size(), MPI_REQUEST_NULL) {
  owned_vertices = data.owned_vertices;
  whole = data.whole;
  boundary_faces = std::move(data.boundary_faces);
  boundary_vertices = std::move(data.boundary_vertices);
  vertex_numbers = std::move(data.vertex_numbers);
  for (const Neighbor& neighbor : neighbors_) {
    shared_vertices.insert(shared_vertices.end(), neighbor.shared.begin(), neighbor.shared.end());
  }
  std::sort(shared_vertices.begin(), shared_vertices.end());
  shared_vertices.erase(std::unique(shared_vertices.begin(), shared_vertices.end()),
                        shared_vertices.end());
}

// received_ ← the neighbours' numbers of the shared vertices, some time before MPI_Waitall() ends.
void MpiPart::begin_adding(const double* values, Index width) const {
  const auto size = static_cast<std::size_t>(width);
  for (std::size_t n = 0; n < neighbors_.size(); ++n) {
    const std::vector<Index>& shared = neighbors_[n].shared;
    received_[n].resize(size * shared.size());
    MPI_Irecv(received_[n].data(), static_cast<int>(received_[n].size()), MPI_DOUBLE,
              neighbors_[n].rank, kTag, MPI_COMM_WORLD, &requests_[n]);
  }
  for (std::size_t n = 0; n < neighbors_.size(); ++n) {
    const std::vector<Index>& shared = neighbors_[n].shared;
    sent_[n].resize(size * shared.size());
    double* next = sent_[n].data();
    for (const Index v : shared) next = std::copy_n(values + width * v, width, next);
    MPI_Isend(sent_[n].data(), static_cast<int>(sent_[n].size()), MPI_DOUBLE, neighbors_[n].rank,
              kTag, MPI_COMM_WORLD, &requests_[neighbors_.size() + n]);
  }
}

// All processes add the numbers of a vertex in the order of the processes, so that its copies have the same
// bits.
void MpiPart::end_adding(double* values, Index width) const {
  if (neighbors_.empty()) return;
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  own_.resize(shared_vertices.size() * static_cast<std::size_t>(width));
  double* next = own_.data();
  for (const Index v : shared_vertices) {
    next = std::copy_n(values + width * v, width, next);
    std::fill_n(values + width * v, width, 0.0);
  }
  const auto add = [&](const std::vector<Index>& vertices, const double* numbers) {
    for (const Index v : vertices) {
      for (Index k = 0; k < width; ++k) values[width * v + k] += *numbers++;
    }
  };
  bool is_added = false;
  for (std::size_t n = 0; n < neighbors_.size(); ++n) {
    if (!is_added && neighbors_[n].rank > rank_) {
      add(shared_vertices, own_.data());
      is_added = true;
    }
    add(neighbors_[n].shared, received_[n].data());
  }
  if (!is_added) add(shared_vertices, own_.data());
}

void MpiPart::sum(double* values, Index count) const {
  if (count_ == 1) return;
  const auto size = static_cast<int>(count);
  if (count_ > kFew || count * count_ > kSmall) {
    gathered_.resize(static_cast<std::size_t>(count));
    MPI_Reduce(values, gathered_.data(), size, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    if (rank_ == 0) std::copy(gathered_.begin(), gathered_.end(), values);
    MPI_Bcast(values, size, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    return;
  }
  gathered_.resize(static_cast<std::size_t>(count * count_));
  MPI_Allgather(values, size, MPI_DOUBLE, gathered_.data(), size, MPI_DOUBLE, MPI_COMM_WORLD);
  const double* next = gathered_.data();
  for (Index i = 0; i < count; ++i) values[i] = *next++;
  for (int rank = 1; rank < count_; ++rank) {
    for (Index i = 0; i < count; ++i) values[i] += *next++;
  }
}

void MpiPart::largest(double* values, Index count) const {
  if (count_ == 1) return;
  MPI_Allreduce(MPI_IN_PLACE, values, static_cast<int>(count), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
}

void MpiPart::gather(const double* own, const std::vector<Index>& counts, double* all) const {
  std::vector<int> sizes(counts.begin(), counts.end());
  std::vector<int> begins(sizes.size(), 0);
  std::partial_sum(sizes.begin(), sizes.end() - 1, begins.begin() + 1);
  const auto rank = static_cast<std::size_t>(rank_);
  if (own != all + begins[rank]) std::copy_n(own, sizes[rank], all + begins[rank]);
  MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all, sizes.data(), begins.data(), MPI_DOUBLE,
                 MPI_COMM_WORLD);
}

void MpiPart::broadcast(std::string& text, int from) const {
  int size = static_cast<int>(text.size());
  MPI_Bcast(&size, 1, MPI_INT, from, MPI_COMM_WORLD);
  text.resize(static_cast<std::size_t>(size));
  MPI_Bcast(text.data(), size, MPI_CHAR, from, MPI_COMM_WORLD);
}

// Every other process sends the numbers of its own vertices and then their values.
Vector MpiPart::collect(const Vector& values, Index width) const {
  const auto own = static_cast<std::size_t>(owned_vertices);
  if (rank_ != 0) {
    send_list(vertex_numbers.data(), own, 0);
    send_list(values.data(), own * static_cast<std::size_t>(width), 0);
    return {};
  }
  Vector all(width * whole.vertices);
  const auto place = [&](const Index* numbers, std::size_t count, const double* from) {
    for (std::size_t i = 0; i < count; ++i) {
      std::copy_n(from + static_cast<Index>(i) * width, width, all.data() + numbers[i] * width);
    }
  };
  place(vertex_numbers.data(), own, values.data());
  for (int rank = 1; rank < count_; ++rank) {
    const auto numbers = receive_list<Index>(rank);
    place(numbers.data(), numbers.size(), receive_list<double>(rank).data());
  }
  return all;
}

// Every other process sends the numbers of all its vertices and gets their values.
Vector MpiPart::scatter(const Vector& whole_values, Index width) const {
  const auto pick = [&](const std::vector<Index>& numbers) {
    std::vector<double> picked(numbers.size() * static_cast<std::size_t>(width));
    double* next = picked.data();
    for (const Index v : numbers) next = std::copy_n(whole_values.data() + v * width, width, next);
    return picked;
  };
  std::vector<double> own;
  if (rank_ != 0) {
    send_list(vertex_numbers.data(), vertex_numbers.size(), 0);
    own = receive_list<double>(0);
  } else {
    own = pick(vertex_numbers);
    for (int rank = 1; rank < count_; ++rank) {
      const std::vector<double> picked = pick(receive_list<Index>(rank));
      send_list(picked.data(), picked.size(), rank);
    }
  }
  return Eigen::Map<const Vector>(own.data(), static_cast<Index>(own.size()));
}

std::unique_ptr<BodyPreconditioner> MpiPart::make_preconditioner(
    const MechanicalSystem& system, BodyPreconditioner::Kind kind) const {
  return std::make_unique<AssembledPreconditioner>(system, *this, kind);
}

}  // namespace tetraction::petsc
