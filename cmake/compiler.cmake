# Compile options shared by every target of the project: link to tetraction_options.
add_library(tetraction_options INTERFACE)
target_compile_options(tetraction_options INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
  # No fused multiply-add where the source has none: results stay the same on every x86-64.
  -ffp-contract=off)
if(TETRACTION_UNITY_BUILD)
  # A source that another one includes is no header: its classes may have members of its own types.
  target_compile_options(tetraction_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
if(TETRACTION_WARNINGS_AS_ERRORS)
  target_compile_options(tetraction_options INTERFACE -Werror)
endif()
if(TETRACTION_NATIVE)
  target_compile_options(tetraction_options INTERFACE -march=native)
endif()
# Optimised a little and with line numbers only, so that a build and all tests take an hour and not a day.
set(sanitizer_options_address -fsanitize=address,undefined -fno-sanitize-recover=undefined)
set(sanitizer_options_thread -fsanitize=thread)
if(TETRACTION_SANITIZE)
  if(NOT DEFINED sanitizer_options_${TETRACTION_SANITIZE})
    message(FATAL_ERROR "TETRACTION_SANITIZE is ${TETRACTION_SANITIZE}; it must be address or thread")
  endif()
  target_compile_options(tetraction_options INTERFACE
    -O1 -g1 -fno-omit-frame-pointer ${sanitizer_options_${TETRACTION_SANITIZE}}
    -Wno-maybe-uninitialized)  # GCC 12 with sanitizers reports its own _mm_undefined_pd()
  target_link_options(tetraction_options INTERFACE ${sanitizer_options_${TETRACTION_SANITIZE}})
endif()
# Release is -O3; assertions stay out of it.
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
