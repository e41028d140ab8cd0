#include "tangent_kernels.h"

#include <type_traits>
#include <variant>

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/tangent_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "tangent_kernels-inl.h"

// A material with Ψ = 0. Its state has the metric terms only, to which viscosity is added.
#ifndef TETRACTION_FEM_NO_STIFFNESS
#define TETRACTION_FEM_NO_STIFFNESS
namespace tetraction {
struct NoStiffness {
  template <class T>
  struct Parameters {};
  static Parameters<double> parameters() { return {}; }
  static constexpr bool kDefinedForAnyJacobian = true;
};
}  // namespace tetraction
#endif

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

template <>
struct Law<NoStiffness> {
  template <class P, class Real>
  static HWY_INLINE auto first_derivatives(const P&, const StrainMeasures<Real>&) {
    return FirstDerivatives{Real(0.0), Real(0.0), Zero()};
  }
  template <class P, class Real>
  static HWY_INLINE Real spherical(const P&, const StrainMeasures<Real>&) {
    return Real(0.0);
  }
  template <class P, class Real>
  static HWY_INLINE auto second_derivatives(const P&, const StrainMeasures<Real>&) {
    return SecondDerivatives{Real(0.0), Zero(), Zero(), Zero(), Zero(), Zero()};
  }
};

// Calls body(constant) with the form as a compile-time constant. The form must be that of one of the
// laws, with or without viscosity.
template <class Body, class... M>
HWY_INLINE void with_form_of_one(TangentForm form, const Body& body, const std::variant<M...>*) {
  const auto try_one = [&]<TangentForm kForm>(std::integral_constant<TangentForm, kForm> constant)
                           HWY_ATTR {
                             if (form != kForm) return false;
                             body(constant);
                             return true;
                           };
  constexpr TangentForm kMetric = TangentForm::kMetric;
  static_cast<void>(
      (... || (try_one(std::integral_constant<TangentForm, form_of<M>()>()) ||
               try_one(std::integral_constant<TangentForm, form_of<M>() | kMetric>()))));
}
template <class Body>
HWY_INLINE void with_form(TangentForm form, const Body& body) {
  with_form_of_one(form, body, static_cast<const IsotropicModel*>(nullptr));
}

template <class T>
void prepare_form(const BatchView& batches, const IsotropicModel& model, TangentForm form,
                  const double* positions, T* state) {
  std::visit(
      [&]<class M>(const M& material) HWY_ATTR {
        constexpr TangentForm kAlone = form_of<M>();
        constexpr TangentForm kViscous = kAlone | TangentForm::kMetric;
        with_parameters(batches, material, [&](const auto& parameters) HWY_ATTR {
          if (form == kAlone) {
            prepare<kAlone>(batches, parameters, positions, state);
          } else {
            prepare<kViscous>(batches, parameters, positions, state);
          }
        });
      },
      model);
}
void prepare_empty(const BatchView& batches, const double* positions, double* state) {
  prepare<TangentForm::kMetric>(batches, UniformParameters<NoStiffness>(NoStiffness()), positions,
                                state);
}

template <class T>
void apply_form(const BatchView& batches, TangentForm form, const T* state, const T* x, T* result) {
  with_form(form, [&](auto constant) HWY_ATTR { apply<constant()>(batches, state, x, result); });
}

template <class T>
void diagonal_form(const BatchView& batches, TangentForm form, const T* state, T* diagonal,
                   T* off_diagonal) {
  with_form(form, [&](auto constant) HWY_ATTR {
    diagonal_blocks<constant()>(batches, state, diagonal, off_diagonal);
  });
}

void stiffness_form(TangentForm form, const double* state, double* matrices) {
  with_form(form, [&](auto constant) HWY_ATTR { stiffness<constant()>(state, matrices); });
}

// Highway's dispatch needs functions that are not overloaded.
void prepare_float(const BatchView& b, const IsotropicModel& m, TangentForm f, const double* q,
                   float* s) {
  prepare_form(b, m, f, q, s);
}
void prepare_double(const BatchView& b, const IsotropicModel& m, TangentForm f, const double* q,
                    double* s) {
  prepare_form(b, m, f, q, s);
}
void apply_float(const BatchView& b, TangentForm f, const float* s, const float* x, float* y) {
  apply_form(b, f, s, x, y);
}
void apply_double(const BatchView& b, TangentForm f, const double* s, const double* x, double* y) {
  apply_form(b, f, s, x, y);
}
void diagonal_float(const BatchView& b, TangentForm f, const float* s, float* on, float* off) {
  diagonal_form(b, f, s, on, off);
}
void diagonal_double(const BatchView& b, TangentForm f, const double* s, double* on, double* off) {
  diagonal_form(b, f, s, on, off);
}
bool safe_float(const BatchView& b, TangentForm f, const float* s, const float* x) {
  return is_safe(b, f, s, x);
}
bool safe_double(const BatchView& b, TangentForm f, const double* s, const double* x) {
  return is_safe(b, f, s, x);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

TangentForm tangent_form(const IsotropicModel& material, bool viscous) {
  const TangentForm form =
      std::visit([]<class M>(const M&) { return HWY_NAMESPACE::form_of<M>(); }, material);
  return viscous ? form | TangentForm::kMetric : form;
}

HWY_EXPORT(prepare_float);
HWY_EXPORT(prepare_double);
HWY_EXPORT(prepare_empty);
HWY_EXPORT(apply_float);
HWY_EXPORT(apply_double);
HWY_EXPORT(diagonal_float);
HWY_EXPORT(diagonal_double);
HWY_EXPORT(stiffness_form);
HWY_EXPORT(safe_float);
HWY_EXPORT(safe_double);

void prepare_tangent(const BatchView& batches, const IsotropicModel& material, TangentForm form,
                     const double* positions, float* state) {
  HWY_DYNAMIC_DISPATCH(prepare_float)(batches, material, form, positions, state);
}
void prepare_tangent(const BatchView& batches, const IsotropicModel& material, TangentForm form,
                     const double* positions, double* state) {
  HWY_DYNAMIC_DISPATCH(prepare_double)(batches, material, form, positions, state);
}
void prepare_empty_tangent(const BatchView& batches, const double* positions, double* state) {
  HWY_DYNAMIC_DISPATCH(prepare_empty)(batches, positions, state);
}
void apply_tangent(const BatchView& batches, TangentForm form, const float* state, const float* x,
                   float* result) {
  HWY_DYNAMIC_DISPATCH(apply_float)(batches, form, state, x, result);
}
void apply_tangent(const BatchView& batches, TangentForm form, const double* state, const double* x,
                   double* result) {
  HWY_DYNAMIC_DISPATCH(apply_double)(batches, form, state, x, result);
}
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const float* state,
                          float* diagonal, float* off_diagonal) {
  HWY_DYNAMIC_DISPATCH(diagonal_float)(batches, form, state, diagonal, off_diagonal);
}
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const double* state,
                          double* diagonal, double* off_diagonal) {
  HWY_DYNAMIC_DISPATCH(diagonal_double)(batches, form, state, diagonal, off_diagonal);
}
void tangent_stiffness(TangentForm form, const double* state, double* matrices) {
  HWY_DYNAMIC_DISPATCH(stiffness_form)(form, state, matrices);
}
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const float* state,
                          const float* x) {
  return HWY_DYNAMIC_DISPATCH(safe_float)(batches, form, state, x);
}
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const double* state,
                          const double* x) {
  return HWY_DYNAMIC_DISPATCH(safe_double)(batches, form, state, x);
}

}  // namespace tetraction
#endif
