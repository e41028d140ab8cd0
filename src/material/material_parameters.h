// Checks of material parameters.
#pragma once

namespace tetraction {

/// Throws InputError unless μ > 0, λ > −2μ/3 and both are finite.
void check_lame(const char* material, double mu, double lambda);

}  // namespace tetraction
