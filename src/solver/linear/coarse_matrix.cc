#include "coarse_matrix.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetraction {
namespace {

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

void sort_and_unite(std::vector<std::int32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

// The place of a number that is in the list.
std::size_t place_of(const std::vector<std::int32_t>& ascending, std::int32_t number) {
  return static_cast<std::size_t>(std::lower_bound(ascending.begin(), ascending.end(), number) -
                                  ascending.begin());
}

// The lists of all parts, one after the other; on one process its own.
std::vector<std::vector<std::int32_t>> lists_of_parts(const MeshPart* part,
                                                      const std::vector<std::int32_t>& own) {
  if (part == nullptr) return {own};
  const std::vector<Index> counts = part->counts_of_parts(static_cast<Index>(own.size()));
  const std::vector<double> numbers(own.begin(), own.end());
  std::vector<double> all(at(std::accumulate(counts.begin(), counts.end(), Index{0})));
  part->gather(numbers.data(), counts, all.data());
  std::vector<std::vector<std::int32_t>> lists;
  auto next = all.begin();
  for (const Index count : counts) {
    lists.emplace_back();
    for (Index i = 0; i < count; ++i) lists.back().push_back(static_cast<std::int32_t>(*next++));
  }
  return lists;
}

}  // namespace

void CoarseMatrix::Sparse::make_pattern(
    const std::vector<std::vector<std::int32_t>>& rows_of_column) {
  column_begin.assign(1, 0);
  for (const std::vector<std::int32_t>& of_column : rows_of_column) {
    for (int j = 0; j < 6; ++j) {
      for (const std::int32_t row : of_column) {
        for (int i = 0; i < 6; ++i) rows.push_back(6 * row + i);
      }
      column_begin.push_back(static_cast<int>(rows.size()));
    }
  }
  values.resize(rows.size());
  cholesky = std::make_unique<SparseCholesky>(column_begin, rows);
}

void CoarseMatrix::Sparse::prepare_diagonal(double shift) {
  constexpr double kRoundOff = 1e-10;
  for (Index first = 0; first < size(); first += 6) {
    // The diagonal block comes first in its columns.
    const auto diagonal = [&](Index i) -> double& {
      return values[at(column_begin[at(first + i)] + i)];
    };
    double largest = 0.0;
    for (Index i = 0; i < 6; ++i) largest = std::max(largest, std::abs(diagonal(i)));
    for (Index i = 0; i < 6; ++i) {
      double& d = diagonal(i);
      if (d > 0.0) {
        d *= 1.0 + shift;
      } else if (d >= -kRoundOff * largest) {
        d = largest > 0.0 ? largest : 1.0;
      }
    }
  }
}

CoarseMatrix::CoarseMatrix(const MeshPart* part, Index own_groups,
                           const std::vector<std::int32_t>& interface_numbers,
                           const std::vector<GroupPair>& pairs)
    : part_(part), own_groups_(own_groups) {
  make_interface(interface_numbers);
  inner_rows_.resize(inner_groups_.size());
  for (std::size_t i = 0; i < inner_rows_.size(); ++i) {
    inner_rows_[i].push_back(static_cast<std::int32_t>(i));
  }
  for (const auto& [first, second] : pairs) {
    const bool first_is_inner = is_inner(first);
    if (first_is_inner && is_inner(second)) {
      // Inner groups are numbered in the order of the groups.
      inner_rows_[at(inner_of_[at(first)])].push_back(inner_of_[at(second)]);
    } else if (first_is_inner != is_inner(second)) {
      const auto [inner, boundary] =
          first_is_inner ? std::pair(first, second) : std::pair(second, first);
      couplings_.push_back({inner_of_[at(inner)], boundary_of_[at(boundary)], Block::Zero()});
    }
  }
  for (auto& rows : inner_rows_) sort_and_unite(rows);
  std::sort(couplings_.begin(), couplings_.end(),
            [](const Coupling& a, const Coupling& b) { return a.key() < b.key(); });
  const auto repeated =
      std::unique(couplings_.begin(), couplings_.end(),
                  [](const Coupling& a, const Coupling& b) { return a.key() == b.key(); });
  couplings_.erase(repeated, couplings_.end());
  inner_.make_pattern(inner_rows_);
}

// Every process couples all interface groups that it touches with one another.
void CoarseMatrix::make_interface(const std::vector<std::int32_t>& interface_numbers) {
  inner_of_.assign(interface_numbers.size(), -1);
  boundary_of_.assign(interface_numbers.size(), -1);
  for (std::size_t g = 0; g < interface_numbers.size(); ++g) {
    if (interface_numbers[g] < 0) {
      inner_of_[g] = static_cast<std::int32_t>(inner_groups_.size());
      inner_groups_.push_back(static_cast<std::int32_t>(g));
    } else {
      boundary_groups_.push_back(static_cast<std::int32_t>(g));
    }
  }
  std::sort(boundary_groups_.begin(), boundary_groups_.end(), [&](std::int32_t a, std::int32_t b) {
    return interface_numbers[at(a)] < interface_numbers[at(b)];
  });
  for (std::size_t b = 0; b < boundary_groups_.size(); ++b) {
    boundary_of_[at(boundary_groups_[b])] = static_cast<std::int32_t>(b);
    interface_.push_back(interface_numbers[at(boundary_groups_[b])]);
  }
  boundary_.setZero(6 * static_cast<Index>(interface_.size()),
                    6 * static_cast<Index>(interface_.size()));
  for (const std::vector<std::int32_t>& touched : lists_of_parts(part_, interface_)) {
    for (std::size_t j = 0; j < touched.size(); ++j) {
      if (complement_rows_.size() <= at(touched[j])) complement_rows_.resize(at(touched[j]) + 1);
      auto& rows = complement_rows_[at(touched[j])];
      rows.insert(rows.end(), touched.begin() + static_cast<std::ptrdiff_t>(j), touched.end());
    }
  }
  for (auto& rows : complement_rows_) sort_and_unite(rows);
  complement_.make_pattern(complement_rows_);
}

void CoarseMatrix::set_zero() {
  std::fill(inner_.values.begin(), inner_.values.end(), 0.0);
  std::fill(complement_.values.begin(), complement_.values.end(), 0.0);
  boundary_.setZero();
  for (Coupling& coupling : couplings_) coupling.block.setZero();
}

// The block of A_IB of two groups, of which one is an inner one; the end if there is none.
std::vector<CoarseMatrix::Coupling>::const_iterator CoarseMatrix::find_coupling(
    Index row, Index column) const {
  const bool row_is_inner = is_inner(row);
  const std::tuple key(inner_of_[at(row_is_inner ? row : column)],
                       boundary_of_[at(row_is_inner ? column : row)]);
  const auto found =
      std::lower_bound(couplings_.begin(), couplings_.end(), key,
                       [](const Coupling& c, const auto& wanted) { return c.key() < wanted; });
  return found != couplings_.end() && found->key() == key ? found : couplings_.end();
}

bool CoarseMatrix::has(Index row, Index column) const {
  if (is_inner(row) != is_inner(column)) return find_coupling(row, column) != couplings_.end();
  if (!is_inner(row)) return true;
  const auto [low, high] = std::minmax(inner_of_[at(row)], inner_of_[at(column)]);
  const auto& rows = inner_rows_[at(low)];
  return std::binary_search(rows.begin(), rows.end(), high);
}

void CoarseMatrix::add(Index row, Index column, const Block& block) {
  if (is_inner(row) != is_inner(column)) {
    Block& to = couplings_[at(find_coupling(row, column) - couplings_.cbegin())].block;
    is_inner(row) ? to += block : to += block.transpose();
    return;
  }
  const std::vector<std::int32_t>& number = is_inner(row) ? inner_of_ : boundary_of_;
  const bool is_below = number[at(row)] >= number[at(column)];
  const std::int32_t low = number[at(is_below ? column : row)];
  const std::int32_t high = number[at(is_below ? row : column)];
  if (!is_inner(row)) {
    auto to = boundary_.block<6, 6>(6 * high, 6 * low);
    is_below ? to += block : to += block.transpose();
    return;
  }
  const std::size_t place = place_of(inner_rows_[at(low)], high);
  for (int j = 0; j < 6; ++j) {
    inner_.column(low, j, place) += is_below ? Motion(block.col(j)) : Motion(block.row(j));
  }
}

bool CoarseMatrix::factorize(double shift) {
  inner_.prepare_diagonal(shift);
  const bool is_positive = inner_groups_.empty() || inner_.factorize();
  if (!everywhere(part_, is_positive)) return false;
  return complement_rows_.empty() || add_complements(shift);
}

// W, of which groups far from the border have no rows.
void CoarseMatrix::make_coupling_root() {
  Matrix w = Matrix::Zero(inner_.size(), boundary_.cols());
  for (const Coupling& c : couplings_) w.block<6, 6>(6 * c.inner, 6 * c.boundary) = c.block;
  w = inner_.cholesky->solve_transposed_root(w);
  root_rows_.clear();
  for (Index row = 0; row < w.rows(); ++row) {
    if ((w.row(row).array() != 0.0).any()) root_rows_.push_back(row);
  }
  root_ = w(root_rows_, Eigen::all);
}

// S, the sum of the complements of all parts, and its factor.
bool CoarseMatrix::add_complements(double shift) {
  boundary_.diagonal() *= 1.0 + shift;
  if (!couplings_.empty()) {
    make_coupling_root();
    boundary_.selfadjointView<Eigen::Lower>().rankUpdate(root_.transpose(), -1.0);
  }
  for (std::size_t column = 0; column < interface_.size(); ++column) {
    const std::vector<std::int32_t>& rows = complement_rows_[at(interface_[column])];
    for (std::size_t row = column; row < interface_.size(); ++row) {
      const std::size_t place = place_of(rows, interface_[row]);
      for (int j = 0; j < 6; ++j) {
        complement_.column(interface_[column], j, place) =
            boundary_.block<6, 1>(6 * static_cast<Index>(row), 6 * static_cast<Index>(column) + j);
      }
    }
  }
  sum_over_parts(part_, complement_.values.data(), static_cast<Index>(complement_.values.size()));
  complement_.prepare_diagonal(0.0);
  return complement_.factorize();
}

double CoarseMatrix::solve(std::vector<Motion>& motions) {
  Vector right(inner_.size());
  for (std::size_t i = 0; i < inner_groups_.size(); ++i) {
    right.segment<6>(6 * static_cast<Index>(i)) = motions[at(inner_groups_[i])];
  }
  // With A_II = RᵀR, the inner groups by themselves have R⁻¹ y, and their product is y · y.
  Vector y = inner_groups_.empty() ? right : inner_.cholesky->solve_transposed_root(right);
  double product = y.squaredNorm();
  if (part_ != nullptr) product = solve_interface(motions, product, y);
  if (inner_groups_.empty()) return product;
  const Vector inner = inner_.cholesky->solve_root(y);
  for (std::size_t i = 0; i < inner_groups_.size(); ++i) {
    motions[at(inner_groups_[i])] = inner.segment<6>(6 * static_cast<Index>(i));
  }
  return product;
}

// Sets the motions of the interface, and changes y to that of inner groups that follow it. Returns the product over
// the whole body. `product`: that of the inner groups of this part.
double CoarseMatrix::solve_interface(std::vector<Motion>& motions, double product, Vector& y) {
  const Index size = complement_.size();
  const bool is_coupled = !couplings_.empty();
  Vector coupled(static_cast<Index>(root_rows_.size()));  // the rows of y that W has
  Vector at_boundary = Vector::Zero(boundary_.cols());
  if (is_coupled) {
    coupled = y(root_rows_);
    at_boundary.noalias() -= root_.transpose() * coupled;
  }
  shared_.setZero(size + 1);
  shared_[size] = product;
  for (std::size_t b = 0; b < interface_.size(); ++b) {
    const std::int32_t group = boundary_groups_[b];
    auto to = shared_.segment<6>(6 * interface_[b]);
    if (group < own_groups_) to = motions[at(group)];
    to += at_boundary.segment<6>(6 * static_cast<Index>(b));
  }
  sum_over_parts(part_, shared_.data(), shared_.size());
  product = shared_[size];
  if (size == 0) return product;
  const Vector forces = shared_.head(size);
  const Vector moved = complement_.cholesky->solve(forces);
  for (std::size_t b = 0; b < interface_.size(); ++b) {
    motions[at(boundary_groups_[b])] = moved.segment<6>(6 * interface_[b]);
    at_boundary.segment<6>(6 * static_cast<Index>(b)) = motions[at(boundary_groups_[b])];
  }
  if (is_coupled) {
    coupled.noalias() -= root_ * at_boundary;
    y(root_rows_) = coupled;
  }
  return product + forces.dot(moved);
}

}  // namespace tetraction
