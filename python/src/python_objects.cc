#include "python_objects.h"

#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
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

// The arguments of functions that describe places: the elements (n) and the rest positions (n, 3); none without places.
py::tuple arrays_of(std::span<const MaterialPlace> places) {
  if (places.empty()) return py::tuple();
  const auto n = static_cast<py::ssize_t>(places.size());
  py::array_t<std::int64_t> elements(n);
  Array positions({n, py::ssize_t{3}});
  for (py::ssize_t k = 0; k < n; ++k) {
    const MaterialPlace& place = places[static_cast<std::size_t>(k)];
    elements.mutable_data()[k] = place.element;
    std::copy(place.position.begin(), place.position.end(), positions.mutable_data() + 3 * k);
  }
  return py::make_tuple(elements, positions);
}

// The functions of a law in Python, which are called for many F at once.
class PythonLaw {
 public:
  PythonLaw(std::string name, const LameParameters& lame, const py::object& functions)
      : name_(std::move(name)), lame_(lame), functions_(name_, functions) {}

  bool admissible(const Matrix3& f, std::span<const MaterialPlace> place) const {
    char result = 0;
    evaluate({{&f, 1}, {&result, 1}, {}, {}, {}, place});
    return result != 0;
  }
  double energy_density(const Matrix3& f, std::span<const MaterialPlace> place) const {
    char ignored = 0;
    double result = 0.0;
    evaluate({{&f, 1}, {&ignored, 1}, {&result, 1}, {}, {}, place});
    return result;
  }
  Matrix3 first_piola(const Matrix3& f, std::span<const MaterialPlace> place) const {
    char ignored = 0;
    Matrix3 result;
    evaluate({{&f, 1}, {&ignored, 1}, {}, {&result, 1}, {}, place});
    return result;
  }
  Matrix9 stiffness(const Matrix3& f, std::span<const MaterialPlace> place) const {
    char ignored = 0;
    Matrix9 result;
    evaluate({{&f, 1}, {&ignored, 1}, {}, {}, {&result, 1}, place});
    return result;
  }
  LameParameters initial_lame() const { return lame_; }

  // The user's functions see those F only where Ψ is defined.
  void evaluate(const MaterialValues& values) const {
    const Acquired lock;
    const auto n = values.f.size();
    mark_admissible(values);
    std::vector<std::size_t> entries;
    std::vector<Matrix3> defined;
    std::vector<MaterialPlace> places;
    for (std::size_t k = 0; k < n; ++k) {
      if (values.admissible[k] == 0) continue;
      entries.push_back(k);
      defined.push_back(values.f[k]);
      if (!values.places.empty()) places.push_back(values.places[k]);
    }
    if (entries.empty()) return;
    const auto count = static_cast<py::ssize_t>(entries.size());
    // Each function gets arrays of its own, which it may change.
    const auto call = [&](const char* what) {
      return functions_.get(what)(array_of(defined), *arrays_of(places));
    };
    if (!values.energy.empty()) {
      const Array result = checked(call("energy"), {count}, name_ + ": energy");
      for (std::size_t k = 0; k < entries.size(); ++k) values.energy[entries[k]] = result.data()[k];
    }
    if (!values.stress.empty()) {
      const Array result = checked(call("stress"), {count, 3, 3}, name_ + ": stress");
      for (std::size_t k = 0; k < entries.size(); ++k) {
        values.stress[entries[k]] =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(result.data() + 9 * k);
      }
    }
    if (!values.stiffness.empty()) {
      const Array result = checked(call("stiffness"), {count, 3, 3, 3, 3}, name_ + ": stiffness");
      for (std::size_t k = 0; k < entries.size(); ++k) {
        const double* a = result.data() + 81 * k;  // [i, J, k, L]
        Matrix9& target = values.stiffness[entries[k]];
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
    const Array result = checked(admissible(array_of(values.f), *arrays_of(values.places)), {n},
                                 name_ + ": admissible");
    for (std::size_t k = 0; k < values.f.size(); ++k) {
      values.admissible[k] = result.data()[k] != 0.0 ? 1 : 0;
    }
  }

  std::string name_;
  LameParameters lame_;
  Functions functions_;
};

// A law that is the same everywhere.
class PythonMaterial {
 public:
  explicit PythonMaterial(PythonLaw law) : law_(std::move(law)) {}

  bool admissible(const Matrix3& f) const { return law_.admissible(f, {}); }
  double energy_density(const Matrix3& f) const { return law_.energy_density(f, {}); }
  Matrix3 first_piola(const Matrix3& f) const { return law_.first_piola(f, {}); }
  Matrix9 stiffness(const Matrix3& f) const { return law_.stiffness(f, {}); }
  LameParameters initial_lame() const { return law_.initial_lame(); }
  void evaluate(const MaterialValues& values) const { law_.evaluate(values); }

 private:
  PythonLaw law_;
};

// A law that gets the places.
class PythonPlacedMaterial {
 public:
  explicit PythonPlacedMaterial(PythonLaw law) : law_(std::move(law)) {}

  class AtPlace {
   public:
    AtPlace(const PythonLaw& law, const MaterialPlace& place) : law_(law), place_(place) {}
    bool admissible(const Matrix3& f) const { return law_.admissible(f, {&place_, 1}); }
    double energy_density(const Matrix3& f) const { return law_.energy_density(f, {&place_, 1}); }
    Matrix3 first_piola(const Matrix3& f) const { return law_.first_piola(f, {&place_, 1}); }
    Matrix9 stiffness(const Matrix3& f) const { return law_.stiffness(f, {&place_, 1}); }

   private:
    const PythonLaw& law_;
    MaterialPlace place_;
  };
  AtPlace at(const MaterialPlace& place) const { return {law_, place}; }
  void evaluate(const MaterialValues& values) const { law_.evaluate(values); }

 private:
  PythonLaw law_;
};

// The least of the differences between the given derivatives and those that follow from values ahead, here and
// behind: by both sides, or by one of them. A function whose second derivative jumps, such as that of fibres that
// bear no compression, agrees with one side only.
double least_error(const Eigen::MatrixXd& ahead, const Eigen::MatrixXd& here,
                   const Eigen::MatrixXd& behind, double step, const Eigen::MatrixXd& given) {
  const auto error = [&](const Eigen::MatrixXd& slope) {
    return (slope - given).cwiseAbs().maxCoeff();
  };
  return std::min({error((ahead - behind) / (2.0 * step)), error((ahead - here) / step),
                   error((here - behind) / step)});
}

// Throws unless P = ∂Ψ/∂F and A = ∂P/∂F at some F near rest, by differences. The law is `material`, which has
// this name.
template <class Law>
void check_derivatives(const Law& material, const std::string& name, double modulus) {
  constexpr double kStep = 1e-5;
  constexpr double kAllowed = 1e-5;  // central differences have errors of some 1e-9
  std::vector<Matrix3> points(2, Matrix3::Identity());
  points[0] << 1.05, 0.02, -0.03, 0.04, 0.96, 0.01, -0.02, 0.03, 1.02;
  points[1] << 0.93, -0.06, 0.02, 0.01, 1.08, 0.05, 0.03, -0.04, 0.99;
  const auto refuse = [&](const char* what, double error) {
    throw InputError(
        fmt::format("{}: {} by {:.2g} of the material's modulus λ + 2μ. Energy balances and "
                    "implicit steps need exact derivatives.",
                    name, what, error));
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
      const Eigen::MatrixXd column = stiffness.col(c).reshaped(3, 3);
      stiffness_error =
          std::max(stiffness_error, least_error(material.first_piola(ahead), stress,
                                                material.first_piola(behind), kStep, column));
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
  Index undefined_vertex(const ForcePoint& at) const override {
    const Acquired lock;
    const py::object defined = functions_.get("defined");
    if (defined.is_none()) return -1;
    const auto n = static_cast<py::ssize_t>(at.mass.size());
    const Array result = checked(defined(vectors(at.position)), {n}, name_ + ": defined");
    const auto* first = std::find(result.data(), result.data() + n, 0.0);
    return first == result.data() + n ? -1 : first - result.data();
  }
  double longest_step(const ForcePoint& from, const Vector& displacement) const override {
    const Acquired lock;
    const py::object fraction = functions_.get("admissible_fraction");
    double longest = std::numeric_limits<double>::infinity();
    if (fraction.is_none()) return longest;
    const auto n = static_cast<py::ssize_t>(from.mass.size());
    const Array result = checked(fraction(vectors(from.position), vectors(displacement)), {n},
                                 name_ + ": admissible_fraction");
    for (py::ssize_t v = 0; v < n; ++v) {
      if (std::isnan(result.data()[v])) {
        throw InputError(
            fmt::format("{}: admissible_fraction has returned NaN at vertex {}. Where nothing "
                        "limits the way it is infinite.",
                        name_, v));
      }
      longest = std::min(longest, result.data()[v]);
    }
    return longest;
  }
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
  // A copy with a row for each vertex.
  static Array vectors(const Vector& field) {
    return Array({static_cast<py::ssize_t>(field.size() / 3), py::ssize_t{3}}, field.data());
  }
  Vector energies(const ForcePoint& at) const {
    const Array result = call(functions_.get("energy"), at, {}, "energy");
    return Eigen::Map<const Vector>(result.data(), at.mass.size());
  }
  // The result of a function at these positions, one entry of the shape `entry` for each vertex.
  Array call(const py::object& function, const ForcePoint& at,
             const std::vector<py::ssize_t>& entry, const char* what) const {
    const auto n = static_cast<py::ssize_t>(at.mass.size());
    const Array mass(n, at.mass.data());
    std::vector<py::ssize_t> shape{n};
    shape.insert(shape.end(), entry.begin(), entry.end());
    return checked(function(mass, vectors(at.position)), shape, fmt::format("{}: {}", name_, what));
  }

  std::string name_;
  Functions functions_;
};

}  // namespace

CustomMaterial make_material(const std::string& name, double mu, double lambda,
                             const py::object& functions, bool with_places) {
  const LameParameters lame{mu, lambda};
  PythonLaw law(name, lame, functions);
  if (with_places) return {PythonPlacedMaterial(std::move(law)), name, lame};
  CustomMaterial material(PythonMaterial(std::move(law)), name, lame);
  check_derivatives(material, name, std::abs(lambda) + 2.0 * mu);
  return material;
}

void check_placed_material(const CustomMaterial& material, const MechanicalSystem& system,
                           Index region) {
  constexpr std::size_t kMost = 5;
  if (!material.has_places()) return;
  const RestState& rest = system.rest();
  std::vector<Index> elements;
  for (Index e = 0; e < rest.element_count(); ++e) {
    if (system.region(e) == region) elements.push_back(e);
  }
  if (elements.empty()) return;
  const std::size_t count = std::min(kMost, elements.size());
  std::vector<MaterialPlace> places;
  for (std::size_t k = 0; k < count; ++k) {
    const Index e = elements[count == 1 ? 0 : k * (elements.size() - 1) / (count - 1)];
    places.push_back({e, rest.center(e)});
  }
  const LameParameters lame = material.initial_lame();
  const double modulus = std::abs(lame.lambda) + 2.0 * lame.mu;
  for (const MaterialPlace& place : places) {
    check_derivatives(material.at(place), material.name(), modulus);
  }
  // Each of many F must have the values of its own place.
  Matrix3 strained;
  strained << 1.05, 0.02, -0.03, 0.04, 0.96, 0.01, -0.02, 0.03, 1.02;
  const std::vector<Matrix3> f(count, strained);
  std::vector<char> admissible(count, 0);
  std::vector<double> energy(count, 0.0);
  std::vector<Matrix3> stress(count);
  std::vector<Matrix9> stiffness(count);
  material.evaluate({f, admissible, energy, stress, stiffness, places});
  for (std::size_t k = 0; k < count; ++k) {
    const CustomMaterial::AtPlace alone = material.at(places[k]);
    if (admissible[k] == 0) continue;
    const double size = std::max(modulus, stiffness[k].norm());
    const bool is_same = std::abs(energy[k] - alone.energy_density(f[k])) <= 1e-9 * size &&
                         (stress[k] - alone.first_piola(f[k])).norm() <= 1e-9 * size &&
                         (stiffness[k] - alone.stiffness(f[k])).norm() <= 1e-9 * size;
    if (is_same) continue;
    throw InputError(
        fmt::format("{}: the law has other values for many F at once than for each of them alone. "
                    "The first index of the arrays counts the F and their places; look for a sum "
                    "or an index that mixes them.",
                    material.name()));
  }
}

void check_placed_materials(const MechanicalSystem& system) {
  const std::vector<MaterialField>& materials = system.materials();
  for (std::size_t region = 0; region < materials.size(); ++region) {
    const auto* custom = std::get_if<CustomMaterial>(&materials[region].model());
    if (custom != nullptr) {
      check_placed_material(*custom, system, static_cast<Index>(region));
    }
  }
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
