#include "python_objects.h"

#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "interpreter.h"
#include "tetraction/core/error.h"
#include "tetraction/core/interruption.h"
#include "tetraction/core/positive_semidefinite.h"

namespace py = pybind11;

namespace tetraction::python {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Functions of the user, as attributes of an object. That object belongs to the material or field in Python,
// which scenes and sessions of Python keep. A reference from here would keep it for ever, since Python cannot
// see that such a function refers to a session that has it.
class Functions {
 public:
  Functions(std::string of, const py::object& owner)
      : of_(std::move(of)), owner_(new py::weakref(owner), [](const py::weakref* held) {
          // References are released with the interpreter's lock, in whatever thread that happens. When
          // the interpreter ends, nobody needs that any more.
          try {
            const Acquired lock;
            delete held;
          } catch (const Interrupted&) {
          }
        }) {}

  // With the interpreter's lock.
  py::object get(const char* name) const {
    const py::object owner = (*owner_)();
    if (owner.is_none()) {
      throw InputError(of_ +
                       ": this object of Python was deleted while the library still needs it.");
    }
    return owner.attr(name);
  }

 private:
  std::string of_;
  std::shared_ptr<const py::weakref> owner_;
};

std::string shape_text(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (const py::ssize_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : ", ", n);
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

// The result of a user's function as an array of a certain shape.
Array checked(const py::object& result, const std::vector<py::ssize_t>& shape,
              const std::string& what) {
  Array array = Array::ensure(result);
  if (!array) {
    PyErr_Clear();
    throw InputError(fmt::format("{} must return an array of numbers of the shape {}.", what,
                                 shape_text(shape)));
  }
  const std::vector<py::ssize_t> found(array.shape(), array.shape() + array.ndim());
  if (found != shape) {
    throw InputError(fmt::format("{} must return an array of the shape {}, but it has returned {}.",
                                 what, shape_text(shape), shape_text(found)));
  }
  return array;
}

// The matrices as an array (n, 3, 3). It is a copy, because the user may keep it.
py::array array_of(std::span<const Matrix3> matrices) {
  Array array({static_cast<py::ssize_t>(matrices.size()), py::ssize_t{3}, py::ssize_t{3}});
  double* data = array.mutable_data();
  for (const Matrix3& matrix : matrices) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> entry(data);
    entry = matrix;
    data += 9;
  }
  return array;
}

class PythonMaterial {
 public:
  PythonMaterial(std::string name, const LameParameters& lame, const py::object& functions)
      : name_(std::move(name)), lame_(lame), functions_(name_, functions) {}

  bool admissible(const Matrix3& f) const {
    char result = 0;
    evaluate({{&f, 1}, {&result, 1}, {}, {}, {}});
    return result != 0;
  }
  double energy_density(const Matrix3& f) const {
    char ignored = 0;
    double result = 0.0;
    evaluate({{&f, 1}, {&ignored, 1}, {&result, 1}, {}, {}});
    return result;
  }
  Matrix3 first_piola(const Matrix3& f) const {
    char ignored = 0;
    Matrix3 result;
    evaluate({{&f, 1}, {&ignored, 1}, {}, {&result, 1}, {}});
    return result;
  }
  Matrix9 stiffness(const Matrix3& f) const {
    char ignored = 0;
    Matrix9 result;
    evaluate({{&f, 1}, {&ignored, 1}, {}, {}, {&result, 1}});
    return result;
  }
  LameParameters initial_lame() const { return lame_; }

  // The user's functions see those F only where Ψ is defined.
  void evaluate(const MaterialValues& values) const {
    const Acquired lock;
    const auto n = values.f.size();
    mark_admissible(values);
    std::vector<std::size_t> places;
    std::vector<Matrix3> defined;
    for (std::size_t k = 0; k < n; ++k) {
      if (values.admissible[k] == 0) continue;
      places.push_back(k);
      defined.push_back(values.f[k]);
    }
    if (places.empty()) return;
    const auto count = static_cast<py::ssize_t>(places.size());
    const py::array f = array_of(defined);
    if (!values.energy.empty()) {
      const Array result = checked(functions_.get("energy")(f), {count}, name_ + ": energy");
      for (std::size_t k = 0; k < places.size(); ++k) values.energy[places[k]] = result.data()[k];
    }
    if (!values.stress.empty()) {
      const Array result = checked(functions_.get("stress")(f), {count, 3, 3}, name_ + ": stress");
      for (std::size_t k = 0; k < places.size(); ++k) {
        values.stress[places[k]] =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(result.data() + 9 * k);
      }
    }
    if (!values.stiffness.empty()) {
      const Array result =
          checked(functions_.get("stiffness")(f), {count, 3, 3, 3, 3}, name_ + ": stiffness");
      for (std::size_t k = 0; k < places.size(); ++k) {
        const double* a = result.data() + 81 * k;  // [i, J, k, L]
        Matrix9& target = values.stiffness[places[k]];
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            for (int m = 0; m < 3; ++m) {
              for (int l = 0; l < 3; ++l) {
                target(i + 3 * j, m + 3 * l) = a[((3 * i + j) * 3 + m) * 3 + l];
              }
            }
          }
        }
      }
    }
  }

 private:
  void mark_admissible(const MaterialValues& values) const {
    const py::object admissible = functions_.get("admissible");
    if (admissible.is_none()) {
      for (std::size_t k = 0; k < values.f.size(); ++k) {
        values.admissible[k] = jacobian(values.f[k]) > 0.0 ? 1 : 0;
      }
      return;
    }
    const auto n = static_cast<py::ssize_t>(values.f.size());
    const Array result = checked(admissible(array_of(values.f)), {n}, name_ + ": admissible");
    for (std::size_t k = 0; k < values.f.size(); ++k) {
      values.admissible[k] = result.data()[k] != 0.0 ? 1 : 0;
    }
  }

  std::string name_;
  LameParameters lame_;
  Functions functions_;
};

// Throws unless P = ∂Ψ/∂F and A = ∂P/∂F at some F near rest, by central differences.
void check_derivatives(const CustomMaterial& material, double modulus) {
  constexpr double kStep = 1e-5;
  constexpr double kAllowed = 1e-5;  // the differences have errors of some 1e-9
  std::vector<Matrix3> points(2, Matrix3::Identity());
  points[0] << 1.05, 0.02, -0.03, 0.04, 0.96, 0.01, -0.02, 0.03, 1.02;
  points[1] << 0.93, -0.06, 0.02, 0.01, 1.08, 0.05, 0.03, -0.04, 0.99;
  const auto refuse = [&](const char* what, double error) {
    throw InputError(
        fmt::format("{}: {} by {:.2g} of the material's modulus λ + 2μ. Energy balances and "
                    "implicit steps need "
                    "exact derivatives.",
                    material.name(), what, error));
  };
  for (const Matrix3& f : points) {
    if (!material.admissible(f)) continue;
    const Matrix3 stress = material.first_piola(f);
    const Matrix9 stiffness = material.stiffness(f);
    double stress_error = 0.0;
    double stiffness_error = 0.0;
    for (int c = 0; c < 9; ++c) {
      Matrix3 ahead = f;
      Matrix3 behind = f;
      ahead.data()[c] += kStep;
      behind.data()[c] -= kStep;
      const double slope =
          (material.energy_density(ahead) - material.energy_density(behind)) / (2.0 * kStep);
      stress_error = std::max(stress_error, std::abs(slope - stress.data()[c]));
      const Matrix3 slopes =
          (material.first_piola(ahead) - material.first_piola(behind)) / (2.0 * kStep);
      const Eigen::Map<const Vector9> column(slopes.data());
      stiffness_error =
          std::max(stiffness_error, (column - stiffness.col(c)).cwiseAbs().maxCoeff());
    }
    const double scale = std::max({modulus, stress.norm(), stiffness.norm()});
    if (!(stress_error <= kAllowed * scale)) {
      refuse("the stress differs from the derivative of the energy", stress_error / modulus);
    }
    if (!(stiffness_error <= kAllowed * scale)) {
      refuse("the stiffness differs from the derivative of the stress", stiffness_error / modulus);
    }
  }
}

// U(x) = Σ_v U_v(m_v, x_v). Each function is called once for all vertices.
class PythonField : public ForceTerm {
 public:
  PythonField(std::string name, const py::object& functions)
      : name_(std::move(name)), functions_(name_, functions) {}

  std::string name() const override { return name_; }
  bool has_potential() const override { return true; }
  double energy(const ForcePoint& at) const override {
    const Acquired lock;
    return energies(at).sum();
  }
  double energy_change(const ForcePoint& from, const ForcePoint& to) const override {
    const Acquired lock;
    return (energies(to) - energies(from)).sum();
  }
  void add_gradient(const ForcePoint& at, Vector& gradient) const override {
    const Acquired lock;
    const Array result = call(functions_.get("gradient"), at, {3}, "gradient");
    gradient += Eigen::Map<const Vector>(result.data(), gradient.size());
  }
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override {
    const Acquired lock;
    const Array result = call(functions_.get("hessian"), at, {3, 3}, "hessian");
    for (Index v = 0; v < at.mass.size(); ++v) {
      const Eigen::Map<const Matrix3> block(result.data() + 9 * v);
      const Matrix3 symmetric = 0.5 * (block + block.transpose());
      hessian.add(v,
                  form == HessianForm::kExact ? symmetric : positive_semidefinite_part(symmetric));
    }
  }

 private:
  Vector energies(const ForcePoint& at) const {
    const Array result = call(functions_.get("energy"), at, {}, "energy");
    return Eigen::Map<const Vector>(result.data(), at.mass.size());
  }
  // The result of a function at these positions, one entry of the shape `entry` for each vertex.
  Array call(const py::object& function, const ForcePoint& at,
             const std::vector<py::ssize_t>& entry, const char* what) const {
    const auto n = static_cast<py::ssize_t>(at.mass.size());
    const Array mass(n, at.mass.data());
    const Array position({n, py::ssize_t{3}}, at.position.data());
    std::vector<py::ssize_t> shape{n};
    shape.insert(shape.end(), entry.begin(), entry.end());
    return checked(function(mass, position), shape, fmt::format("{}: {}", name_, what));
  }

  std::string name_;
  Functions functions_;
};

}  // namespace

CustomMaterial make_material(const std::string& name, double mu, double lambda,
                             const py::object& functions) {
  const LameParameters lame{mu, lambda};
  CustomMaterial material(PythonMaterial(name, lame, functions), name, lame);
  check_derivatives(material, std::abs(lambda) + 2.0 * mu);
  return material;
}

std::shared_ptr<const ForceTerm> make_force_field(const std::string& name,
                                                  const py::object& functions) {
  const bool is_name = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!is_name) {
    throw InputError(fmt::format(
        "\"{}\" is not a name of a force field: take lower-case letters, digits and underscores.",
        name));
  }
  return std::make_shared<PythonField>(name, functions);
}

}  // namespace tetraction::python
