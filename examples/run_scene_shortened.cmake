# Checks a shipped scene and runs its first few steps; fails unless the results are there.
file(READ ${SCENE} text)
string(REGEX MATCH "\nstep *= *([0-9.e+-]+)" ignored "${text}")
if(CMAKE_MATCH_1)
  set(step ${CMAKE_MATCH_1})
else()
  set(step 1e-4)  # "auto": any short time
endif()
# CMake has no real numbers: awk works out five steps.
execute_process(COMMAND awk "BEGIN { printf \"%.10g\", 5 * ${step} }" OUTPUT_VARIABLE end)
execute_process(COMMAND ${PROGRAM} check ${SCENE} RESULT_VARIABLE code OUTPUT_QUIET)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "tetraction check ${SCENE} gave ${code}")
endif()
execute_process(COMMAND ${PROGRAM} run ${SCENE} --out ${OUT} --set time.end=${end}
  RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "tetraction run ${SCENE} gave ${code}")
endif()
foreach(file history.csv frames.pvd final.vtu summary.json)
  if(NOT EXISTS ${OUT}/${file})
    message(FATAL_ERROR "${OUT}/${file} was not written")
  endif()
endforeach()
