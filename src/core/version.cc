#include "tetraction/core/version.h"

#include <Spectra/Util/Version.h>
#include <ceres/version.h>
#include <cholmod.h>
#include <fmt/format.h>
#include <hwy/highway.h>
#include <tbb/version.h>
#include <Eigen/Core>

namespace tetraction {

std::string version() {
  return TETRACTION_VERSION;
}

std::vector<LibraryVersion> core_library_versions() {
  int cholmod[3] = {0, 0, 0};
  cholmod_version(cholmod);
  return {
      {"Eigen",
       fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"Ceres", CERES_VERSION_STRING},
      {"CHOLMOD", fmt::format("{}.{}.{}", cholmod[0], cholmod[1], cholmod[2])},
      {"Spectra", fmt::format("{}.{}.{}", SPECTRA_MAJOR_VERSION, SPECTRA_MINOR_VERSION,
                              SPECTRA_PATCH_VERSION)},
      {"oneTBB", TBB_VERSION_STRING},
      {"Highway", fmt::format("{}.{}.{}", HWY_MAJOR, HWY_MINOR, HWY_PATCH)},
      {"fmt",
       fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
  };
}

}  // namespace tetraction
