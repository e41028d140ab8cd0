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
template <class Real>
struct Volumetric {
  Real energy;
  Real first_derivative;
  Real second_derivative;

  HWY_INLINE Volumetric(VolumetricPart part, const Invariants<Real>& s) {
    if (part == VolumetricPart::kLogarithmic) {
      energy = Real(0.5) * (s.log_j * s.log_j);
      first_derivative = s.log_j;
      second_derivative = Real(1.0);
    } else {
      energy = Real(0.5) * (s.volume_change * s.volume_change);
      first_derivative = s.volume_change * s.j;
      second_derivative = (s.volume_change + s.j) * s.j;  // J (2J − 1)
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
