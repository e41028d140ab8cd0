#if defined(TETRACTION_MATERIAL_VOLUMETRIC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_VOLUMETRIC_INL_H_
#undef TETRACTION_MATERIAL_VOLUMETRIC_INL_H_
#else
#define TETRACTION_MATERIAL_VOLUMETRIC_INL_H_
#endif

#include "number-inl.h"
#include "tetraction/material/isotropic_material.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// A volumetric part U(J) with its derivatives with respect to ln J, all divided by λ.
template <class N>
struct Volumetric {
  N energy;
  N first;
  N second;

  HWY_INLINE Volumetric(VolumetricPart part, const Invariants<N>& s) {
    if (part == VolumetricPart::kLogarithmic) {
      energy = N(0.5) * (s.log_j * s.log_j);
      first = s.log_j;
      second = N(1.0);
    } else {
      energy = N(0.5) * (s.growth * s.growth);
      first = s.growth * s.j;
      second = (s.growth + s.j) * s.j;  // J (2J − 1)
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
