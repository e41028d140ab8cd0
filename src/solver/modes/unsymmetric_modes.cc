#include "unsymmetric_modes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <numeric>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A growing space with an orthonormal basis V, and A V.
class SearchSpace {
 public:
  SearchSpace(const std::function<Vector(const Vector&)>& product, const Matrix& start)
      : product_(&product), basis_(start.rows(), 0), image_(start.rows(), 0) {
    for (Index j = 0; j < start.cols(); ++j) add(start.col(j));
  }

  Index size() const { return basis_.cols(); }
  // Returns whether the vector was not in the space yet, up to round-off.
  bool add(Vector z) {
    constexpr double kInside = 1e-10;
    const double length = z.norm();
    if (!(length > 0.0)) return false;
    z /= length;
    for (int pass = 0; pass < 2; ++pass) z -= basis_ * (basis_.transpose() * z);
    if (!(z.norm() > kInside)) return false;
    z.normalize();
    z -= basis_ * (basis_.transpose() * z);
    z.normalize();
    basis_.conservativeResize(Eigen::NoChange, size() + 1);
    basis_.rightCols<1>() = z;
    image_.conservativeResize(Eigen::NoChange, size());
    image_.rightCols<1>() = (*product_)(z);
    return true;
  }
  // The eigenpairs of VᵀAV, by their real parts. A vector is that of coefficients.
  std::vector<ComplexEigenpair> pairs() const {
    const Eigen::EigenSolver<Matrix> solver(Matrix(basis_.transpose() * image_));
    std::vector<Index> order(static_cast<std::size_t>(size()));
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
      return solver.eigenvalues()[a].real() < solver.eigenvalues()[b].real();
    });
    std::vector<ComplexEigenpair> pairs;
    pairs.reserve(order.size());
    for (const Index i : order) {
      pairs.push_back({solver.eigenvalues()[i], solver.eigenvectors().col(i).normalized()});
    }
    return pairs;
  }
  Eigen::VectorXcd vector(const ComplexEigenpair& pair) const { return basis_ * pair.vector; }
  Eigen::VectorXcd residual(const ComplexEigenpair& pair) const {
    return image_ * pair.vector - pair.value * vector(pair);
  }

 private:
  const std::function<Vector(const Vector&)>* product_;
  Matrix basis_;
  Matrix image_;
};

}  // namespace

std::vector<ComplexEigenpair> lowest_unsymmetric(
    const std::function<Vector(const Vector&)>& product,
    const std::function<Vector(const Vector&)>& solve, const Matrix& start, Index count) {
  constexpr int kRounds = 200;
  constexpr double kTolerance = 1e-8;  // of the length of a vector
  const Index most = 6 * start.cols() + 60;
  SearchSpace space(product, start);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<ComplexEigenpair> pairs = space.pairs();
    Index wanted = std::min(count, space.size());
    const auto value = [&](Index i) { return pairs[static_cast<std::size_t>(i)].value; };
    // Not the first of two conjugates alone.
    if (wanted > 0 && wanted < space.size() && value(wanted - 1).imag() != 0.0 &&
        value(wanted) == std::conj(value(wanted - 1))) {
      ++wanted;
    }
    std::vector<Vector> corrections;
    for (Index i = 0; i < wanted; ++i) {
      const ComplexEigenpair& pair = pairs[static_cast<std::size_t>(i)];
      if (pair.value.imag() < 0.0) continue;  // the conjugate needs the same
      const Eigen::VectorXcd residual = space.residual(pair);
      for (const Vector& part : {Vector(residual.real()), Vector(residual.imag())}) {
        const Vector correction = solve(part);
        if (correction.norm() > kTolerance) corrections.push_back(correction);
      }
    }
    bool grown = false;
    if (!corrections.empty() && space.size() + 2 * wanted > most) {
      // Begin anew with the best vectors.
      Matrix best(start.rows(), 2 * start.cols());
      for (Index j = 0; j < start.cols(); ++j) {
        const Eigen::VectorXcd z = space.vector(pairs[static_cast<std::size_t>(j)]);
        best.col(2 * j) = z.real();
        best.col(2 * j + 1) = z.imag();
      }
      space = SearchSpace(product, best);
    }
    for (const Vector& correction : corrections) grown = space.add(correction) || grown;
    if (grown) continue;
    pairs.resize(static_cast<std::size_t>(wanted));
    for (ComplexEigenpair& pair : pairs) pair.vector = space.vector(pair);
    return pairs;
  }
  throw Error(
      "The iterations for the modes under loads that follow the deformation did not converge.");
}

}  // namespace tetraction
