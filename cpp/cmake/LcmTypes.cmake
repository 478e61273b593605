# SPDX-License-Identifier: Apache-2.0
# LCM itself and the message types generated from lcm_types/*.lcm.
#
# Targets: lodestar_lcm       the LCM library
#          lodestar_messages  generated C++ types: #include <lodestar/body_rates_t.hpp>
# The Python package of the types is written to <build>/python/lodestar/messages and installed with
# the wheel as lodestar.messages; so are the .lcm files, from which `lodestar spy` makes its jar.

# Where LCM's wheel lives, and the way there from the folder of installed programs.
execute_process(
  COMMAND "${Python_EXECUTABLE}" -c [[
import importlib.util, os, pathlib, sysconfig
print(os.path.relpath(sysconfig.get_path("platlib"), sysconfig.get_path("scripts")))
print(pathlib.Path(importlib.util.find_spec("lcm").origin).parents[1])]]
  RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
if(failed)
  message(FATAL_ERROR "${Python_EXECUTABLE} has no LCM; run: "
                      "${Python_EXECUTABLE} -m pip install lcm==1.5.3")
endif()
string(REPLACE "\n" ";" output "${output}")
list(GET output 0 LODESTAR_PLATLIB_FROM_SCRIPTS)
list(GET output 1 lcm_site)
# The generator comes with the wheel, which the Python side needs in any case.
set(lcm_gen "${lcm_site}/bin/lcm-gen")

add_library(lodestar_lcm INTERFACE)
if(LODESTAR_SYSTEM_LCM)
  find_path(LODESTAR_LCM_INCLUDE lcm/lcm.h REQUIRED)
  find_library(LODESTAR_LCM_LIBRARY lcm REQUIRED)
  message(WARNING "Using the system's liblcm (${LODESTAR_LCM_LIBRARY}). Before 1.5.3 (Debian 12 has "
                  "1.3.1) two forged fragments crash any receiver: the sum of a fragment's offset "
                  "and length may wrap around. Use it only on a bus that nobody else can send to.")
  target_include_directories(lodestar_lcm SYSTEM INTERFACE "${LODESTAR_LCM_INCLUDE}")
  target_link_libraries(lodestar_lcm INTERFACE "${LODESTAR_LCM_LIBRARY}")
  set(LODESTAR_INSTALL_RPATH "")
else()
  find_package(lcm 1.5.3 CONFIG REQUIRED PATHS "${lcm_site}/lib/lcm/cmake" NO_DEFAULT_PATH)
  target_link_libraries(lodestar_lcm INTERFACE lcm)  # shared: the static one wants GLib's headers
  set(LODESTAR_INSTALL_RPATH "$ORIGIN/${LODESTAR_PLATLIB_FROM_SCRIPTS}/lib")
endif()

file(GLOB lcm_files CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/lcm_types/*.lcm")
set(cpp_folder "${PROJECT_BINARY_DIR}/lcm_cpp")
set(python_folder "${PROJECT_BINARY_DIR}/python/lodestar/messages")
foreach(file ${lcm_files})
  get_filename_component(type "${file}" NAME_WE)
  list(APPEND cpp_headers "${cpp_folder}/lodestar/${type}.hpp")
  list(APPEND python_modules "${python_folder}/${type}.py")
endforeach()

add_custom_command(
  OUTPUT ${cpp_headers}
  COMMAND "${lcm_gen}" --cpp --cpp-hpath "${cpp_folder}" ${lcm_files}
  DEPENDS ${lcm_files} "${lcm_gen}"
  COMMENT "Generating C++ message types" VERBATIM)
# lcm-gen names the folder after the LCM package; here that name is taken by the Python package.
add_custom_command(
  OUTPUT ${python_modules} "${python_folder}/__init__.py"
  COMMAND "${CMAKE_COMMAND}" -E rm -rf "${PROJECT_BINARY_DIR}/lcm_python" "${python_folder}"
  COMMAND "${lcm_gen}" --python --ppath "${PROJECT_BINARY_DIR}/lcm_python" ${lcm_files}
  COMMAND "${CMAKE_COMMAND}" -E copy_directory "${PROJECT_BINARY_DIR}/lcm_python/lodestar"
          "${python_folder}"
  DEPENDS ${lcm_files} "${lcm_gen}"
  COMMENT "Generating Python message types" VERBATIM)

add_custom_target(lodestar_generate_cpp DEPENDS ${cpp_headers})
add_custom_target(lodestar_generate_python ALL DEPENDS ${python_modules})
add_library(lodestar_messages INTERFACE)
add_dependencies(lodestar_messages lodestar_generate_cpp)
target_include_directories(lodestar_messages SYSTEM INTERFACE "${cpp_folder}")
target_link_libraries(lodestar_messages INTERFACE lodestar_lcm)
# LCM's coder reads and writes doubles through pointers to int64_t; without this the optimiser may
# drop what it decoded.
target_compile_options(lodestar_messages INTERFACE -fno-strict-aliasing)

if(SKBUILD)
  install(DIRECTORY "${python_folder}" DESTINATION lodestar)
  install(FILES ${lcm_files} DESTINATION lodestar/lcm_types)
endif()
