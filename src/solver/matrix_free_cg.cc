#include "matrix_free_cg.h"

#include <Eigen/LU>
#include <cmath>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kGrain = 1024;

// The part of x along the directions in which the vertex may move. Reactions are kept out of
// residuals like this: next to them the rest would be round-off.
Vector3 project(const FreeCoordinates& coordinates, Index v, const Vector3& x) {
  const FreeCoordinates::VertexMap map = coordinates.map(v);
  Vector3 projected = Vector3::Zero();
  for (int i = 0; i < map.count; ++i) {
    projected += map.columns.col(i).dot(x) * map.columns.col(i);
  }
  return projected;
}

template <class T>
Eigen::Matrix<T, 4, 1> project(const FreeCoordinates& coordinates, Index v,
                               const Eigen::Matrix<T, 4, 1>& x) {
  const Vector3 projected =
      project(coordinates, v, Vector3(x.template head<3>().template cast<double>()));
  return Eigen::Vector4d(projected[0], projected[1], projected[2], 0.0).template cast<T>();
}

// Sum of many products: in the vectors' precision over a few rows, then in double precision.
template <class T>
class RowSum {
 public:
  using Row = Eigen::Matrix<T, 4, 1>;
  void add(const Row& products) {
    part_ += products;
    if (++count_ % 16 == 0) flush();
  }
  double total() {
    flush();
    return total_.sum();
  }

 private:
  void flush() {
    total_ += part_.template cast<double>();
    part_.setZero();
  }
  Row part_ = Row::Zero();
  Eigen::Vector4d total_ = Eigen::Vector4d::Zero();
  int count_ = 0;
};

}  // namespace

template <class T>
bool MatrixFreeCg<T>::supports(const MechanicalSystem& system) {
  return system.coordinates().sets().empty() && TangentOperator<T>::supports(system.elastic());
}

template <class T>
MatrixFreeCg<T>::MatrixFreeCg(const MechanicalSystem& system)
    : system_(system), operator_(system.elastic()) {
  const auto size = static_cast<std::size_t>(4 * system.vertex_count());
  for (AlignedVector<T>* field : {&diagonal_, &x_, &r_, &p_, &z_, &ap_}) field->resize(size);
  inverse_.resize(3 * size);
}

template <class T>
void MatrixFreeCg<T>::set(const StepProblem& problem, const Vector& x) {
  operator_.set(x, problem.viscous());
  curved_ = !system_.environment().is_uniform();
  if (curved_) off_.resize(diagonal_.size());
  parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Vector3 on = vertex_block(problem.coefficient(), v);
      if (curved_) {
        const Matrix3 h = system_.environment().hessian(system_.mass()[v], vertex_block(x, v));
        on += h.diagonal();
        row(off_, v) = Eigen::Vector4d(h(0, 1), h(0, 2), h(1, 2), 0.0).template cast<T>();
      }
      row(diagonal_, v) = Eigen::Vector4d(on[0], on[1], on[2], 0.0).template cast<T>();
    }
  });
  make_preconditioner(problem);
}

template <class T>
void MatrixFreeCg<T>::make_preconditioner(const StepProblem& problem) {
  operator_.diagonal(p_, z_);
  const FreeCoordinates& coordinates = system_.coordinates();
  parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Eigen::Matrix<double, 4, 3> inverse = Eigen::Matrix<double, 4, 3>::Zero();
      if (!coordinates.is_held(v)) {
        Eigen::Vector4d on = (row(p_, v) + row(diagonal_, v)).template cast<double>();
        Eigen::Vector4d off = row(z_, v).template cast<double>();
        if (curved_) off += row(off_, v).template cast<double>();
        Matrix3 block;
        block << on[0], off[0], off[1], off[0], on[1], off[2], off[1], off[2], on[2];
        if (coordinates.is_free(v)) {
          Matrix3 inverted = block.inverse();
          // The blocks of an indefinite matrix need not be positive definite.
          const bool positive = block(0, 0) > 0.0 &&
                                block(0, 0) * block(1, 1) > block(0, 1) * block(0, 1) &&
                                block.determinant() > 0.0;
          if (!positive) {
            inverted = vertex_block(problem.coefficient(), v).cwiseInverse().asDiagonal();
          }
          inverse.topRows<3>() = inverted;
        } else {
          const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> t = coordinates.map(v).columns;
          const Matrix own = t.transpose() * block * t;
          const bool positive = own(0, 0) > 0.0 && own.determinant() > 0.0;
          inverse.topRows<3>() = t *
                                 (positive ? Matrix(own.inverse())
                                           : Matrix(Matrix::Identity(own.rows(), own.rows()) /
                                                    problem.coefficient()[3 * v])) *
                                 t.transpose();
        }
      }
      Eigen::Map<Eigen::Matrix<T, 4, 3>>(inverse_.data() + 12 * v) = inverse.template cast<T>();
    }
  });
}

template <class T>
CgReport MatrixFreeCg<T>::solve(const Vector& gradient, double forcing, int max_iterations,
                                Vector& step) {
  const Index n = system_.vertex_count();
  const auto precondition = [&](const Row& r, Index v) -> Row {
    const T* m = inverse_.data() + 12 * v;
    return Eigen::Map<const Row, Eigen::Aligned16>(m) * r[0] +
           Eigen::Map<const Row, Eigen::Aligned16>(m + 4) * r[1] +
           Eigen::Map<const Row, Eigen::Aligned16>(m + 8) * r[2];
  };
  const FreeCoordinates& coordinates = system_.coordinates();
  CgReport report;
  // The gradient is scaled so that single precision holds any units.
  const double scale = coordinates.restricted_norm(gradient);
  if (!(scale > 0.0)) {
    step.setZero(3 * n);
    report.converged = true;
    return report;
  }
  double rz = parallel_sum(n, [&](Index begin, Index end) {
    RowSum<T> sum;
    for (Index v = begin; v < end; ++v) {
      Vector3 g = vertex_block(gradient, v) / -scale;
      if (!coordinates.is_free(v)) g = project(coordinates, v, g);
      row(x_, v).setZero();
      row(r_, v) = Eigen::Vector4d(g[0], g[1], g[2], 0.0).template cast<T>();
      const Row z = precondition(row(r_, v), v);
      row(p_, v) = z;
      sum.add(row(r_, v).cwiseProduct(z));
    }
    return sum.total();
  });
  const double target = forcing * forcing * rz;
  const double start = rz;
  while (report.iterations < max_iterations) {
    if (rz <= target) {
      report.converged = true;
      break;
    }
    ++report.iterations;
    operator_.multiply(p_.data());
    const double curvature = parallel_sum(n, [&](Index begin, Index end) {
      RowSum<T> sum;
      for (Index v = begin; v < end; ++v) {
        const Row p = row(p_, v);
        Row ap = operator_.row_sum(v) + row(diagonal_, v).cwiseProduct(p);
        if (curved_) {
          const Row off = row(off_, v);
          ap += Row(off[0] * p[1] + off[1] * p[2], off[0] * p[0] + off[2] * p[2],
                    off[1] * p[0] + off[2] * p[1], T(0));
        }
        if (!coordinates.is_free(v)) ap = project(coordinates, v, ap);
        row(ap_, v) = ap;
        sum.add(p.cwiseProduct(ap));
      }
      return sum.total();
    });
    if (!(curvature > 0.0)) {
      report.negative_curvature = true;
      if (report.iterations == 1) x_ = p_;  // the preconditioned gradient itself
      break;
    }
    const T alpha = static_cast<T>(rz / curvature);
    const double next = parallel_sum(n, [&](Index begin, Index end) {
      RowSum<T> sum;
      for (Index v = begin; v < end; ++v) {
        const Row r = row(r_, v) - alpha * row(ap_, v);
        row(r_, v) = r;
        const Row z = precondition(r, v);
        row(z_, v) = z;
        sum.add(r.cwiseProduct(z));
      }
      return sum.total();
    });
    const T beta = static_cast<T>(next / rz);
    rz = next;
    parallel_for(n, kGrain, [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        const Row p = row(p_, v);
        row(x_, v) += alpha * p;
        row(p_, v) = row(z_, v) + beta * p;
      }
    });
  }
  report.reduction = std::sqrt(std::max(rz, 0.0) / start);
  step.resize(3 * n);
  parallel_for(n, kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      row(x_, v) *= static_cast<T>(scale);
      Vector3 own = row(x_, v).template head<3>().template cast<double>();
      if (!coordinates.is_free(v)) own = project(coordinates, v, own);
      vertex_block(step, v) = own;
    }
  });
  return report;
}

template class MatrixFreeCg<float>;
template class MatrixFreeCg<double>;

}  // namespace tetraction
