# Writes the CTest tests of a GoogleTest program, one for each suite, to FILE. One process for each case would spend
# more time on its start than on most cases.
# Called as: cmake -DPROGRAM=... -DPREFIX=... -DLABELS=... -DFILE=... -P suites.cmake
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE list COMMAND_ERROR_IS_FATAL ANY)
# A suite begins a line: Suite., Instantiation/Suite. or Suite/0. for each type.
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\." suites "\n${list}")
list(TRANSFORM suites REPLACE "[\n.]" "")
list(TRANSFORM suites REPLACE "/[0-9]+$" "")
list(REMOVE_DUPLICATES suites)
# A suite passes although some of its cases are skipped. Only these suites may skip cases: on machines that lack
# something, with sanitizers, or for parameters without such a case.
set(may_skip "^(InstructionSets|Materials/NodalVolumeOf|Probe|.*/StepAllocations|ViewMesh|All/(ForceTerms|ModelAndRule|RestCorner))$")
set(text "")
foreach(suite ${suites})
  string(APPEND text
    "add_test([=[${PREFIX}.${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*:${suite}/*.*]=])\n"
    "set_tests_properties([=[${PREFIX}.${suite}]=] PROPERTIES TIMEOUT 1800 LABELS [=[${LABELS}]=])\n")
  if(NOT suite MATCHES "${may_skip}")
    string(APPEND text
      "set_tests_properties([=[${PREFIX}.${suite}]=] PROPERTIES FAIL_REGULAR_EXPRESSION [=[\\[  SKIPPED \\]]=])\n")
  endif()
endforeach()
file(WRITE ${FILE} "${text}")
