#include "vertex_terms.h"

#include <numeric>

#include "tetraction/core/parallel.h"

namespace tetraction {

template <class T>
void VertexTerms<T>::set(const MinimizationProblem& problem, const Vector& u, HessianForm form) {
  has_general_ = problem.has_general_terms();
  if (has_general_) {
    problem.term_hessian(u, form, terms_);
  } else {
    terms_.reset(0);
  }
  const MinimizationProblem::HessianParts parts = problem.hessian_parts(u);
  outers_.set(parts.positions, form, terms_);
  has_outers_ = !outers_.empty();
  diagonal_.resize(static_cast<std::size_t>(4 * system_.vertex_count()));
  if (has_general_) off_.resize(diagonal_.size());
  parallel_for(system_.vertex_count(), 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index v = groups_.vertex(i);
      Vector3 on = vertex_block(parts.diagonal, v);
      if (has_general_) {
        const Matrix3 h = terms_.diagonal(v);
        on += h.diagonal();
        Eigen::Map<Record, Eigen::Aligned16>(off_.data() + 4 * i) =
            Eigen::Vector4d(h(0, 1), h(0, 2), h(1, 2), 0.0).template cast<T>();
      }
      Eigen::Map<Record, Eigen::Aligned16>(diagonal_.data() + 4 * i) =
          Eigen::Vector4d(on[0], on[1], on[2], 0.0).template cast<T>();
    }
  });
  set_neighbors();
}

template <class T>
void VertexTerms<T>::set_neighbors() {
  neighbors_begin_.clear();
  neighbors_.clear();
  if (terms_.pairs().empty()) return;
  if (place_of_.empty()) {
    place_of_.resize(static_cast<std::size_t>(system_.vertex_count()));
    for (Index i = 0; i < system_.vertex_count(); ++i) {
      place_of_[static_cast<std::size_t>(groups_.vertex(i))] = static_cast<std::int32_t>(i);
    }
  }
  const auto place = [&](Index v) { return place_of_[static_cast<std::size_t>(v)]; };
  // Counted, then filled in the order of the pairs.
  neighbors_begin_.assign(static_cast<std::size_t>(system_.vertex_count()) + 1, 0);
  for (const HessianBlocks::Pair& pair : terms_.pairs()) {
    ++neighbors_begin_[static_cast<std::size_t>(place(pair.row)) + 1];
    ++neighbors_begin_[static_cast<std::size_t>(place(pair.column)) + 1];
  }
  std::partial_sum(neighbors_begin_.begin(), neighbors_begin_.end(), neighbors_begin_.begin());
  std::vector<Index> next(neighbors_begin_.begin(), neighbors_begin_.end() - 1);
  neighbors_.resize(2 * terms_.pairs().size());
  const auto enter = [&](Index v, Index other, const Matrix3& block) {
    Index& end = next[static_cast<std::size_t>(place(v))];
    neighbors_[static_cast<std::size_t>(end++)] = {place(other), block.template cast<T>()};
  };
  for (const HessianBlocks::Pair& pair : terms_.pairs()) {
    enter(pair.row, pair.column, pair.block);
    enter(pair.column, pair.row, pair.block.transpose());
  }
}

template <class T>
Matrix3 VertexTerms<T>::block(Index place) const {
  const Record on = diagonal(place);
  Matrix3 block = Vector3(on.template head<3>().template cast<double>()).asDiagonal();
  if (has_general_) {
    const Record off = off_diagonal(place);
    block(0, 1) = block(1, 0) = off[0];
    block(0, 2) = block(2, 0) = off[1];
    block(1, 2) = block(2, 1) = off[2];
  }
  return block;
}

// sum += the blocks of pairs that the vertex at a place takes part in, times p.
template <class T>
void VertexTerms<T>::add_neighbors(const AlignedVector<T>& p, Index place, Record& sum) const {
  const auto begin = static_cast<std::size_t>(neighbors_begin_[static_cast<std::size_t>(place)]);
  const auto end = static_cast<std::size_t>(neighbors_begin_[static_cast<std::size_t>(place) + 1]);
  for (std::size_t k = begin; k < end; ++k) {
    const Neighbor& other = neighbors_[k];
    sum.template head<3>() += other.block * record(p, other.place).template head<3>();
  }
}

template class VertexTerms<float>;
template class VertexTerms<double>;

}  // namespace tetraction
