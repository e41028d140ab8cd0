# Third-party packages, all from Debian 12. These are what the library tetraction::core needs.
find_package(Eigen3 3.4 REQUIRED CONFIG)
find_package(TBB REQUIRED CONFIG)
find_package(Ceres 2.1 REQUIRED CONFIG COMPONENTS SuiteSparse)
find_package(Spectra REQUIRED CONFIG)
find_package(hwy REQUIRED CONFIG)
find_package(fmt REQUIRED CONFIG)

# SuiteSparse of Debian 12 has neither a CMake package nor a pkg-config file.
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
if(NOT TARGET SuiteSparse::cholmod)
  add_library(SuiteSparse::cholmod UNKNOWN IMPORTED)
  set_target_properties(SuiteSparse::cholmod PROPERTIES
    IMPORTED_LOCATION ${CHOLMOD_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${CHOLMOD_INCLUDE_DIR})
endif()

# What tetraction::io, the program and the viewer need beyond that.
set(TETRACTION_HAS_VIEWER FALSE)
if(NOT TETRACTION_BUILD_IO)
  return()
endif()
find_package(nlohmann_json REQUIRED CONFIG)
find_package(tomlplusplus REQUIRED CONFIG)
find_package(CLI11 REQUIRED CONFIG)
find_package(ZLIB REQUIRED)
# muParser of Debian 12 has no CMake package.
find_library(MUPARSER_LIBRARY muparser REQUIRED)
find_path(MUPARSER_INCLUDE_DIR muParser.h REQUIRED)
if(NOT TARGET muparser::muparser)
  add_library(muparser::muparser UNKNOWN IMPORTED)
  set_target_properties(muparser::muparser PROPERTIES
    IMPORTED_LOCATION ${MUPARSER_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${MUPARSER_INCLUDE_DIR})
endif()
# The second list is the viewer's, which is built where Qt 5 and VTK's module for it are installed.
set(viewer_vtk_components
  CommonTransforms ImagingCore FiltersCore FiltersGeometry FiltersSources InteractionStyle InteractionWidgets
  RenderingCore RenderingOpenGL2 RenderingAnnotation RenderingFreeType RenderingContext2D
  RenderingContextOpenGL2 ChartsCore ViewsContext2D IOExport GUISupportQt)
find_package(VTK REQUIRED COMPONENTS CommonCore CommonDataModel IOXML IOLegacy FiltersVerdict
  OPTIONAL_COMPONENTS ${viewer_vtk_components})
find_package(Qt5 5.15 QUIET COMPONENTS Widgets OPTIONAL_COMPONENTS Test)
# VTK names its Qt module also where only the other headers are installed.
find_path(VTK_QT_INCLUDE_DIR QVTKOpenGLNativeWidget.h PATHS ${VTK_PREFIX_PATH}
  PATH_SUFFIXES vtk-${VTK_MAJOR_VERSION}.${VTK_MINOR_VERSION})
if(Qt5_FOUND AND VTK_QT_INCLUDE_DIR AND TARGET VTK::GUISupportQt)
  set(TETRACTION_HAS_VIEWER TRUE)
else()
  message(STATUS "The viewer is skipped: qtbase5-dev or libvtk9-qt-dev is not installed")
endif()
