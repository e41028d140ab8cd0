#include "sparse_cholesky.h"

#include <cholmod.h>

#include <mutex>
#include <new>

#include "solver/ceres/serial_openmp.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"

namespace tetraction {

struct SparseCholesky::Impl {
  cholmod_common common{};
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;
  CholeskyCost cost;
  cholmod_dense* solution = nullptr;  // work space, kept between solves
  cholmod_dense* y = nullptr;
  cholmod_dense* e = nullptr;

  Impl() { cholmod_start(&common); }
  ~Impl() {
    for (cholmod_dense** work : {&solution, &y, &e}) cholmod_free_dense(work, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // The solution with the whole matrix or with a part of its factor.
  template <class Columns>
  Columns solve(int system, const Columns& b) {
    const SerialOpenMp serial;
    const SerialBlas serial_blas;
    cholmod_dense right{};
    right.nrow = right.d = static_cast<std::size_t>(b.rows());
    right.ncol = static_cast<std::size_t>(b.cols());
    right.nzmax = static_cast<std::size_t>(b.size());
    right.x = const_cast<double*>(b.data());
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    if (cholmod_solve2(system, factor, &right, nullptr, &solution, nullptr, &y, &e, &common) == 0) {
      throw std::bad_alloc();
    }
    return Eigen::Map<const Columns>(static_cast<const double*>(solution->x), b.rows(), b.cols());
  }
};

SparseCholesky::SparseCholesky(const std::vector<int>& column_begin, const std::vector<int>& rows)
    : impl_(std::make_unique<Impl>()) {
  // L Lᵀ is needed because L D Lᵀ would accept an indefinite matrix without an error.
  impl_->common.final_ll = 1;
  impl_->common.print = 0;  // not positive definite is a result here, not a message
  cholmod_sparse& a = impl_->matrix;
  a.nrow = a.ncol = column_begin.size() - 1;
  a.nzmax = rows.size();
  // CHOLMOD does not change the matrix that it factorises.
  a.p = const_cast<int*>(column_begin.data());
  a.i = const_cast<int*>(rows.data());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
}

SparseCholesky::~SparseCholesky() = default;

void SparseCholesky::analyze() {
  Impl& s = *impl_;
  if (s.factor != nullptr) return;
  // Nested dissection takes longer than a minimum degree ordering. For solids of more than some
  // thousand vertices it saves this time within the first few factorisations.
  constexpr std::size_t kDissect = 9000;
  s.common.nmethods = 1;
  s.common.method[0].ordering = s.matrix.nrow > kDissect ? CHOLMOD_METIS : CHOLMOD_AMD;
  s.common.postorder = 1;
  cholmod_sparse pattern = s.matrix;
  pattern.x = nullptr;
  pattern.xtype = CHOLMOD_PATTERN;
  // METIS takes its numbers from std::rand(), whose sequence all threads share.
  static std::mutex of_random_numbers;
  const std::lock_guard lock(of_random_numbers);
  s.factor = cholmod_analyze(&pattern, &s.common);
  if (s.factor == nullptr) throw std::bad_alloc();
  s.cost = {s.common.fl, s.common.lnz};
}

const CholeskyCost& SparseCholesky::cost() {
  analyze();
  return impl_->cost;
}

bool SparseCholesky::factorize(const std::vector<double>& values) {
  Impl& s = *impl_;
  const SerialOpenMp serial;
  const SerialBlas serial_blas;
  analyze();
  s.matrix.x = const_cast<double*>(values.data());
  cholmod_factorize(&s.matrix, s.factor, &s.common);
  if (s.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  return s.common.status == CHOLMOD_OK && s.factor->minor == s.matrix.nrow;
}

Vector SparseCholesky::solve(const Vector& b) {
  return impl_->solve(CHOLMOD_A, b);
}

Vector SparseCholesky::solve_transposed_root(const Vector& b) {
  return impl_->solve(CHOLMOD_L, impl_->solve(CHOLMOD_P, b));
}

Matrix SparseCholesky::solve_transposed_root(const Matrix& columns) {
  return impl_->solve(CHOLMOD_L, impl_->solve(CHOLMOD_P, columns));
}

Vector SparseCholesky::solve_root(const Vector& b) {
  return impl_->solve(CHOLMOD_Pt, impl_->solve(CHOLMOD_Lt, b));
}

void SparseCholesky::copy_to(SinglePrecisionFactor& copy) const {
  if (impl_->factor == nullptr) throw Error("There is no factor to copy.");
  copy.assign(*impl_->factor);
}

void SparseCholesky::release_factor() {
  Impl& s = *impl_;
  if (s.factor == nullptr) return;
  cholmod_change_factor(CHOLMOD_PATTERN, s.factor->is_ll, s.factor->is_super, 1, 1, s.factor,
                        &s.common);
}

}  // namespace tetraction
