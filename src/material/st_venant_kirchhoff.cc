#include "material_parameters.h"
#include "tetraction/material/material.h"

namespace tetraction {

StVenantKirchhoff::StVenantKirchhoff(double mu, double lambda) : parameters_{mu, lambda} {
  check_lame(kName, mu, lambda);
}

}  // namespace tetraction
