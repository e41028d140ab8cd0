# What tetraction::core needs. The build of the project and the installed package both include this file, after they
# have defined tetraction_require(), which finds a package.
tetraction_require(Eigen3 3.4 CONFIG)
tetraction_require(TBB CONFIG)
tetraction_require(Ceres 2.1 CONFIG COMPONENTS SuiteSparse)
tetraction_require(Spectra CONFIG)
tetraction_require(hwy CONFIG)
tetraction_require(fmt CONFIG)

# SuiteSparse of Debian 12 has neither a CMake package nor a pkg-config file.
if(NOT TARGET SuiteSparse::cholmod)
  find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
  find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
  mark_as_advanced(CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR)
  add_library(SuiteSparse::cholmod UNKNOWN IMPORTED)
  set_target_properties(SuiteSparse::cholmod PROPERTIES
    IMPORTED_LOCATION ${CHOLMOD_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${CHOLMOD_INCLUDE_DIR})
endif()
