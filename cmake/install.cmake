# cmake --install, the CMake package, the pkg-config file and the Debian packages (cpack -G DEB).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/tetraction)
set_target_properties(tetraction_core PROPERTIES EXPORT_NAME core)
install(TARGETS tetraction_core EXPORT tetraction-core
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT development)
install(EXPORT tetraction-core NAMESPACE tetraction:: DESTINATION ${package_folder}
  COMPONENT development)
install(DIRECTORY include/tetraction DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT development FILES_MATCHING PATTERN "*.h")

configure_package_config_file(cmake/tetraction-config.cmake.in
  ${PROJECT_BINARY_DIR}/tetraction-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tetraction-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tetraction-config.cmake
  ${PROJECT_BINARY_DIR}/tetraction-config-version.cmake
  cmake/core_dependencies.cmake cmake/io_dependencies.cmake
  DESTINATION ${package_folder} COMPONENT development)
# Relative, so that an installation can be moved and --prefix may differ from that of the configuration.
file(RELATIVE_PATH pkgconfig_to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/tetraction.pc.in ${PROJECT_BINARY_DIR}/tetraction.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/tetraction.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

if(TETRACTION_BUILD_IO)
  set_target_properties(tetraction_io PROPERTIES EXPORT_NAME io)
  set_target_properties(tetraction PROPERTIES EXPORT_NAME program)
  install(TARGETS tetraction_io EXPORT tetraction-io
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT development)
  install(EXPORT tetraction-io NAMESPACE tetraction:: DESTINATION ${package_folder}
    COMPONENT development)
  install(TARGETS tetraction EXPORT tetraction-program
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  install(EXPORT tetraction-program NAMESPACE tetraction:: DESTINATION ${package_folder}
    COMPONENT development)

  # Manual pages and the completion of bash, from the definitions of the command line.
  set(documents ${PROJECT_BINARY_DIR}/command_line)
  add_custom_command(OUTPUT ${documents}/man1/tetraction.1 ${documents}/tetraction.bash
    COMMAND ${CMAKE_COMMAND} -E make_directory ${documents}/man1
    COMMAND tetraction document-command-line man ${documents}/man1
    COMMAND tetraction document-command-line bash ${documents}/tetraction.bash
    DEPENDS tetraction VERBATIM)
  add_custom_target(command_line_documents ALL DEPENDS ${documents}/man1/tetraction.1)
  install(DIRECTORY ${documents}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program
    FILES_MATCHING PATTERN "*.1")
  install(FILES ${documents}/tetraction.bash RENAME tetraction
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)

  # The scenes name meshes as ../../data/NAME.
  install(DIRECTORY docs data DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
  install(DIRECTORY examples/scenes DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT program)
  install(FILES README.md LICENSE CHANGELOG.md CONTRIBUTING.md CITATION.cff
    DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
  if(TETRACTION_HAS_VIEWER)
    install(TARGETS tetraction_window RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
    install(FILES packaging/tetraction.desktop
      DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT program)
    install(FILES packaging/tetraction.svg
      DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT program)
  endif()
endif()

# The engine of MPI runs beside the program, which calls it.
if(TETRACTION_HAS_PETSC)
  install(TARGETS tetraction_parallel RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT parallel)
endif()

if(TETRACTION_HAS_PYTHON)
  set(python_folder lib/python3/dist-packages/tetraction)  # Debian's own
  install(TARGETS tetraction_python LIBRARY DESTINATION ${python_folder} COMPONENT python)
  install(DIRECTORY ${TETRACTION_PYTHON_FOLDER}/tetraction/ DESTINATION ${python_folder} COMPONENT python
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
endif()

# Packages: the program, the library with its headers, and the Python package where it was built.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tetraction)
set(CPACK_PACKAGE_VENDOR Tetraction)
set(CPACK_PACKAGE_CONTACT "The Tetraction developers <tetraction@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL program development)
if(TETRACTION_HAS_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TETRACTION_HAS_PETSC)
  list(APPEND CPACK_COMPONENTS_ALL parallel)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME tetraction)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS libopenblas0-pthread)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "python3-matplotlib, libgl1-mesa-dri, fonts-dejavu-core")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libtetraction-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libeigen3-dev, libsuitesparse-dev, libopenblas-dev, libceres-dev, libspectra-dev, libtbb-dev, libhwy-dev, libfmt-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS
  "libvtk9-dev, libtomlplusplus-dev, nlohmann-json3-dev, libmuparser-dev, zlib1g-dev")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tetraction)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
# The extension module is of one version of Python.
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS 
  "python3 (>= ${TETRACTION_PYTHON_VERSION}), python3 (<< ${TETRACTION_NEXT_PYTHON_VERSION}), python3-numpy, libopenblas0-pthread")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-matplotlib, python3-vtk9")
set(CPACK_DEBIAN_PARALLEL_PACKAGE_NAME tetraction-petsc)
set(CPACK_DEBIAN_PARALLEL_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PARALLEL_PACKAGE_DEPENDS "tetraction, openmpi-bin")
set(CPACK_COMPONENT_PARALLEL_DESCRIPTION
  "The engine with which Tetraction runs a scene in several processes (PETSc, MPI).")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "Simulates hyperelastic solids on tetrahedral meshes with variational integrators and reports a complete balance of energy and momentum.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "The library of Tetraction: headers, static libraries, CMake package and pkg-config file.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python package of Tetraction, with NumPy arrays that are views of the running state.")
include(CPack)
