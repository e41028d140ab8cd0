#include "sparse_cholesky.h"

#include <cholmod.h>

#include <new>

namespace tetraction {

struct SparseCholesky::Impl {
  cholmod_common common{};
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;

  Impl() { cholmod_start(&common); }
  ~Impl() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

SparseCholesky::SparseCholesky(const SparsityPattern& pattern) : impl_(std::make_unique<Impl>()) {
  impl_->common.print = 0;  // not positive definite is a result here, not a message
  cholmod_sparse& a = impl_->matrix;
  a.nrow = a.ncol = static_cast<std::size_t>(pattern.size());
  a.nzmax = static_cast<std::size_t>(pattern.nonzeros());
  // CHOLMOD does not write to what it is given to factorise.
  a.p = const_cast<int*>(pattern.column_begin().data());
  a.i = const_cast<int*>(pattern.rows().data());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
}

SparseCholesky::~SparseCholesky() = default;

bool SparseCholesky::factorize(const std::vector<double>& values) {
  Impl& s = *impl_;
  s.matrix.x = const_cast<double*>(values.data());
  if (s.factor == nullptr) s.factor = cholmod_analyze(&s.matrix, &s.common);
  if (s.factor == nullptr) throw std::bad_alloc();
  cholmod_factorize(&s.matrix, s.factor, &s.common);
  if (s.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  return s.common.status == CHOLMOD_OK && s.factor->minor == s.matrix.nrow;
}

Vector SparseCholesky::solve(const Vector& b) {
  Impl& s = *impl_;
  cholmod_dense right{};
  right.nrow = right.d = right.nzmax = static_cast<std::size_t>(b.size());
  right.ncol = 1;
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, s.factor, &right, &s.common);
  if (x == nullptr) throw std::bad_alloc();
  Vector result = Eigen::Map<const Vector>(static_cast<const double*>(x->x), b.size());
  cholmod_free_dense(&x, &s.common);
  return result;
}

}  // namespace tetraction
