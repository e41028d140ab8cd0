// The parameters of a law in the loops over elements: the same for all elements, or different in
// every lane. Highway includes this file once for each instruction set.
#if defined(TETRACTION_FEM_ELEMENT_PARAMETERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_ELEMENT_PARAMETERS_INL_H_
#undef TETRACTION_FEM_ELEMENT_PARAMETERS_INL_H_
#else
#define TETRACTION_FEM_ELEMENT_PARAMETERS_INL_H_
#endif

#include <cstddef>
#include <utility>

#include "element_kernels.h"
#include "material/laws/laws-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Parameters that are the same for all elements. The compiler keeps them in registers.
template <class M>
class UniformParameters {
 public:
  using Material = M;
  explicit UniformParameters(const M& material) : values_(material.parameters()) {}

  template <class Tag>
  HWY_INLINE const auto& load(Tag, size_t, size_t) const {
    return values_;
  }

 private:
  typename M::template Parameters<double> values_;
};

/// Parameters that every element has of its own (BatchView::parameters). A choice of the volumetric
/// part and the number of terms are those of the material.
template <class M>
class ElementParameters {
 public:
  using Material = M;
  ElementParameters(const M& material, const double* values)
      : choices_(material.parameters()), values_(values) {}

  /// The parameters of the elements in the lanes from `lane` on of a batch.
  template <class Tag>
  HWY_INLINE auto load(Tag tag, size_t batch, size_t lane) const {
    const double* HWY_RESTRICT from = values_ + batch * kCount * kBatchLanes + lane;
    return load_all(tag, from, std::make_index_sequence<kCount>());
  }

 private:
  static constexpr size_t kCount = number_count<M>();

  template <class Tag, size_t... i>
  HWY_INLINE auto load_all(Tag tag, const double* HWY_RESTRICT from,
                           std::index_sequence<i...>) const {
    using Real = Number<Tag>;
    if constexpr (M::kHasVolumetricPart) {
      return typename M::template Parameters<Real>{Real(hn::Load(tag, from + i * kBatchLanes))...,
                                                   choices_.volumetric};
    } else if constexpr (requires { choices_.terms; }) {
      return typename M::template Parameters<Real>{Real(hn::Load(tag, from + i * kBatchLanes))...,
                                                   choices_.terms};
    } else {
      return typename M::template Parameters<Real>{Real(hn::Load(tag, from + i * kBatchLanes))...};
    }
  }

  typename M::template Parameters<double> choices_;
  const double* values_;
};

/// Returns body(parameters) with the parameters of the elements in the batches.
template <class M, class Body>
HWY_INLINE auto with_parameters(const BatchView& batches, const M& material, const Body& body) {
  if (batches.parameters == nullptr) return body(UniformParameters<M>(material));
  return body(ElementParameters<M>(material, batches.parameters));
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
