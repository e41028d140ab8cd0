#include "tetraction/material/material_field.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Whether two materials differ in nothing but their parameters.
template <class M>
bool is_same_law(const M& a, const IsotropicModel& b) {
  const M* other = std::get_if<M>(&b);
  if constexpr (M::kHasVolumetricPart) {
    return other != nullptr && other->volumetric() == a.volumetric();
  } else if constexpr (requires { a.term_count(); }) {
    return other != nullptr && other->term_count() == a.term_count();
  } else {
    return other != nullptr;
  }
}

void extend(LameRange& range, const LameParameters& lame) {
  range.least.mu = std::min(range.least.mu, lame.mu);
  range.least.lambda = std::min(range.least.lambda, lame.lambda);
  range.most.mu = std::max(range.most.mu, lame.mu);
  range.most.lambda = std::max(range.most.lambda, lame.lambda);
  const double modulus = lame.lambda + 2.0 * lame.mu;
  range.least_modulus = std::min(range.least_modulus, modulus);
  range.most_modulus = std::max(range.most_modulus, modulus);
  range.most_ratio = std::max(range.most_ratio, 0.5 * lame.lambda / (lame.lambda + lame.mu));
}

LameRange range_of(const LameParameters& lame) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  LameRange range{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}, kInfinity, -kInfinity, -1.0};
  extend(range, lame);
  return range;
}

}  // namespace

MaterialField::MaterialField(MaterialModel model, std::shared_ptr<const Matrix> parameters)
    : model_(std::move(model)),
      parameters_(std::move(parameters)),
      range_(range_of(initial_lame(model_))) {
  if (!parameters_) return;
  range_ = range_of(initial_lame(at(0)));
  for (Index e = 1; e < parameters_->cols(); ++e) extend(range_, initial_lame(at(e)));
}

MaterialField::MaterialField(const std::vector<IsotropicModel>& elements)
    : MaterialField([&] {
        if (elements.empty()) throw InputError("A material field needs at least one element.");
        return std::visit(
            [&]<class M>(const M& first) {
              const Index count = static_cast<Index>(elements.size());
              auto parameters = std::make_shared<Matrix>(number_count<M>(), count);
              for (Index e = 0; e < count; ++e) {
                const IsotropicModel& element = elements[static_cast<std::size_t>(e)];
                if (!is_same_law(first, element)) {
                  throw InputError(
                      "All elements of a material field must have the same law and the same "
                      "volumetric part; for different ones give the elements regions of their "
                      "own.");
                }
                const auto values = std::get<M>(element).parameter_values();
                parameters->col(e) =
                    Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
              }
              const Vector mean = parameters->rowwise().mean();
              return MaterialField(MaterialModel(with_parameters(first, mean.data())),
                                   std::move(parameters));
            },
            elements.front());
      }()) {}

MaterialModel MaterialField::at(Index e) const {
  return std::visit(
      [&](const auto& m) {
        return with_element(m, e, [](const auto& own) { return MaterialModel(own); });
      },
      model_);
}

}  // namespace tetraction
