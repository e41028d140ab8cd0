#include "proper_rotation.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace tetraction {

Matrix3 proper_rotation(const Matrix3& a) {
  const Eigen::JacobiSVD<Matrix3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3 signs = Vector3::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs[2] = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace tetraction
