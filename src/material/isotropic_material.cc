#include "core/simd_targets.h"
#include "isotropic_material-inl.h"
#include "laws/laws-inl.h"

namespace tetraction {

template class IsotropicMaterial<StVenantKirchhoff>;
template class IsotropicMaterial<NeoHookean>;
template class IsotropicMaterial<MooneyRivlin>;
template class IsotropicMaterial<Yeoh>;

}  // namespace tetraction
