// The laws of all isotropic materials. Highway includes this file once for each instruction
// set.
#if defined(TETRACTION_MATERIAL_LAWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_LAWS_INL_H_
#undef TETRACTION_MATERIAL_LAWS_INL_H_
#else
#define TETRACTION_MATERIAL_LAWS_INL_H_
#endif

#include "mooney_rivlin-inl.h"
#include "neo_hookean-inl.h"
#include "st_venant_kirchhoff-inl.h"
#include "yeoh-inl.h"

#endif
