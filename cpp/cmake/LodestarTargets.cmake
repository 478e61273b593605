# SPDX-License-Identifier: Apache-2.0
# Helpers by which each folder declares its library or test program in one line.

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
# The same source gives the same bits: the compiler fuses no multiplication with an addition of its own
# accord.
add_compile_options(-ffp-contract=off)
# AVX2 and FMA (x86-64 processors since 2013-15) make a frame a third faster. Results differ in the last
# bits from those of a build without.
option(LODESTAR_AVX2 "Use AVX2 and FMA where the building machine has them" ON)
if(LODESTAR_AVX2 AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND NOT CMAKE_CROSSCOMPILING)
  include(CheckCXXSourceRuns)
  check_cxx_source_runs("
    int main() {
      return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") ? 0 : 1;
    }" LODESTAR_MACHINE_HAS_AVX2)
  if(LODESTAR_MACHINE_HAS_AVX2)
    add_compile_options(-mavx2 -mfma)
  endif()
endif()
if(LODESTAR_SANITIZE)
  add_compile_options(-fsanitize=${LODESTAR_SANITIZE} -fno-sanitize-recover=all
                      -fno-omit-frame-pointer -g)
  add_link_options(-fsanitize=${LODESTAR_SANITIZE})
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)

function(lodestar_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Werror -Wconversion)
endfunction()

function(lodestar_add_folder folder)
  if(EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/${folder}/CMakeLists.txt")
    add_subdirectory(${folder})
  endif()
endfunction()

# lodestar_library(<folder> [SOURCES a.cpp ...] [DEPENDS folder ... | imported::target ...])
function(lodestar_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  if(ARG_SOURCES)
    add_library(lodestar_${name} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    lodestar_warnings(lodestar_${name})
  else()
    add_library(lodestar_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_include_directories(lodestar_${name} ${scope} "${PROJECT_SOURCE_DIR}/cpp")
  target_link_libraries(lodestar_${name} ${scope} Eigen3::Eigen)
  foreach(dependency ${ARG_DEPENDS})
    if(dependency MATCHES "::")
      target_link_libraries(lodestar_${name} ${scope} ${dependency})
    else()
      target_link_libraries(lodestar_${name} ${scope} lodestar_${dependency})
    endif()
  endforeach()
endfunction()

# lodestar_test(<folder> SOURCES a_test.cpp ... [DEPENDS folder ...]): program tests/test_<folder>
function(lodestar_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(test_${name} ${ARG_SOURCES})
  lodestar_warnings(test_${name})
  target_link_libraries(test_${name} PRIVATE GTest::gtest_main)
  foreach(dependency ${ARG_DEPENDS})
    if(dependency MATCHES "::")
      target_link_libraries(test_${name} PRIVATE ${dependency})
    else()
      target_link_libraries(test_${name} PRIVATE lodestar_${dependency})
    endif()
  endforeach()
  set_target_properties(test_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
endfunction()
