# Configures tests/consumer and compiles its file, without VTK, X11, Qt, Python and what else the
# core does not need. Builds no library: that takes minutes.
file(REMOVE_RECURSE ${FOLDER})
set(absent)
foreach(package VTK X11 OpenGL Qt5 Python Python3 MPI tomlplusplus CLI11 GTest)
  list(APPEND absent -DCMAKE_DISABLE_FIND_PACKAGE_${package}=TRUE)
endforeach()
execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=CMAKE_BUILD_TYPE --unset=CXXFLAGS
  ${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${FOLDER} -DTETRACTION=${TETRACTION} ${absent}
  OUTPUT_VARIABLE told COMMAND_ERROR_IS_FATAL ANY)
if(NOT told MATCHES "sets it to Release")
  message(FATAL_ERROR "it is not said that the build type was set:\n${told}")
endif()
execute_process(
  COMMAND ${CMAKE_COMMAND} --build ${FOLDER} --target CMakeFiles/my_program.dir/main.cc.o
  COMMAND_ERROR_IS_FATAL ANY)
