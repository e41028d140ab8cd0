# What tetraction::io needs beyond tetraction::core. See core_dependencies.cmake.
tetraction_require(nlohmann_json CONFIG)
tetraction_require(tomlplusplus CONFIG)
tetraction_require(ZLIB)
# muParser of Debian 12 has no CMake package.
if(NOT TARGET muparser::muparser)
  find_library(MUPARSER_LIBRARY muparser REQUIRED)
  find_path(MUPARSER_INCLUDE_DIR muParser.h REQUIRED)
  mark_as_advanced(MUPARSER_LIBRARY MUPARSER_INCLUDE_DIR)
  add_library(muparser::muparser UNKNOWN IMPORTED)
  set_target_properties(muparser::muparser PROPERTIES
    IMPORTED_LOCATION ${MUPARSER_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${MUPARSER_INCLUDE_DIR})
endif()
set(tetraction_io_vtk_components CommonCore CommonDataModel IOXML IOLegacy FiltersCore FiltersVerdict)
tetraction_require(VTK COMPONENTS ${tetraction_io_vtk_components}
                   OPTIONAL_COMPONENTS ${viewer_vtk_components})
