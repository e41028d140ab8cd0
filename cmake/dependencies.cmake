# Third-party packages, all from Debian 12.
macro(tetraction_require)
  find_package(${ARGV} REQUIRED)
endmacro()
include(${CMAKE_CURRENT_LIST_DIR}/core_dependencies.cmake)
find_package(nlohmann_json REQUIRED CONFIG)  # headers, which an installed library does not need

# What tetraction::io, the program and the viewer need beyond that.
set(TETRACTION_HAS_VIEWER FALSE)
set(TETRACTION_HAS_PETSC FALSE)
if(NOT TETRACTION_BUILD_IO)
  return()
endif()
# These are the viewer's, which is built where Qt 5 and VTK's module for it are installed.
set(viewer_vtk_components
  CommonTransforms ImagingCore FiltersGeometry FiltersSources InteractionStyle InteractionWidgets
  RenderingCore RenderingOpenGL2 RenderingAnnotation RenderingFreeType RenderingContext2D
  RenderingContextOpenGL2 ChartsCore ViewsContext2D IOExport GUISupportQt)
include(${CMAKE_CURRENT_LIST_DIR}/io_dependencies.cmake)
find_package(CLI11 REQUIRED CONFIG)
find_package(Qt5 5.15 QUIET COMPONENTS Widgets OPTIONAL_COMPONENTS Test)
# VTK names its Qt module also where only the other headers are installed.
find_path(VTK_QT_INCLUDE_DIR QVTKOpenGLNativeWidget.h PATHS ${VTK_PREFIX_PATH}
  PATH_SUFFIXES vtk-${VTK_MAJOR_VERSION}.${VTK_MINOR_VERSION})
if(Qt5_FOUND AND VTK_QT_INCLUDE_DIR AND TARGET VTK::GUISupportQt)
  set(TETRACTION_HAS_VIEWER TRUE)
else()
  message(STATUS "The viewer is skipped: qtbase5-dev or libvtk9-qt-dev is not installed")
endif()
# The engine for runs in several processes is built where PETSc and MPI are installed.
if(TETRACTION_BUILD_PETSC)
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(PETSC QUIET IMPORTED_TARGET PETSc>=3.18)
    find_package(MPI QUIET COMPONENTS C)
  endif()
  if(PETSC_FOUND AND MPI_C_FOUND)
    set(TETRACTION_HAS_PETSC TRUE)
    find_library(SCOTCH_LIBRARY scotch)
    find_path(SCOTCH_INCLUDE_DIR scotch.h PATH_SUFFIXES scotch)
  else()
    message(STATUS "The engine of MPI runs is skipped: petsc-dev or libopenmpi-dev is not installed")
  endif()
endif()
