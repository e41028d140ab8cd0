# Compile options shared by every target of the project: link to tetraction_options.
add_library(tetraction_options INTERFACE)
target_compile_options(tetraction_options INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
  # No fused multiply-add where the source has none: results stay the same on every x86-64.
  -ffp-contract=off)
if(TETRACTION_WARNINGS_AS_ERRORS)
  target_compile_options(tetraction_options INTERFACE -Werror)
endif()
if(TETRACTION_NATIVE)
  target_compile_options(tetraction_options INTERFACE -march=native)
endif()
if(TETRACTION_SANITIZE)
  target_compile_options(tetraction_options INTERFACE
    -O1 -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(tetraction_options INTERFACE -fsanitize=address,undefined)
endif()
# Release is -O3; assertions stay out of it.
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
