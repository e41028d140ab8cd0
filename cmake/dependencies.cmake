# Third-party packages, all from Debian 12.
find_package(Eigen3 3.4 REQUIRED CONFIG)
find_package(TBB REQUIRED CONFIG)
find_package(Ceres 2.1 REQUIRED CONFIG COMPONENTS SuiteSparse)
find_package(Spectra REQUIRED CONFIG)
find_package(hwy REQUIRED CONFIG)
find_package(fmt REQUIRED CONFIG)
find_package(nlohmann_json REQUIRED CONFIG)
find_package(tomlplusplus REQUIRED CONFIG)
find_package(CLI11 REQUIRED CONFIG)
find_package(VTK REQUIRED COMPONENTS CommonCore CommonDataModel IOXML IOLegacy FiltersVerdict)

# SuiteSparse of Debian 12 has neither a CMake package nor a pkg-config file.
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
if(NOT TARGET SuiteSparse::cholmod)
  add_library(SuiteSparse::cholmod UNKNOWN IMPORTED)
  set_target_properties(SuiteSparse::cholmod PROPERTIES
    IMPORTED_LOCATION ${CHOLMOD_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${CHOLMOD_INCLUDE_DIR})
endif()
