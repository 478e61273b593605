# SPDX-License-Identifier: Apache-2.0
# Header-only libraries: the system's headers where they are, else the very same Debian package,
# pinned by its hash and unpacked into the build folder. So `pip install .` needs no more than a
# compiler and Eigen.
#
# Targets: lodestar_tomlplusplus, lodestar_cli11, lodestar_spdlog (with fmt).

option(LODESTAR_FETCH_HEADERS "Download the header packages even where the system has them" OFF)

set(LODESTAR_DEBIAN_POOL "http://deb.debian.org/debian/pool/main"
    CACHE STRING "Where Debian packages of headers are downloaded from")

# lodestar_fetch_debian(<out: include folder> <package> <file under pool/main> <sha256>)
function(lodestar_fetch_debian result package file sha256)
  set(folder "${PROJECT_BINARY_DIR}/headers")
  set(archive "${folder}/${package}.deb")
  if(EXISTS "${archive}")
    file(SHA256 "${archive}" found)
  endif()
  if(NOT "${found}" STREQUAL "${sha256}")
    message(STATUS "Downloading ${LODESTAR_DEBIAN_POOL}/${file}")
    file(DOWNLOAD "${LODESTAR_DEBIAN_POOL}/${file}" "${archive}" TIMEOUT 60 STATUS status)
    file(SHA256 "${archive}" found)
  endif()
  if(NOT "${found}" STREQUAL "${sha256}")
    file(REMOVE "${archive}")
    message(FATAL_ERROR "${package}: not installed, and not downloaded from ${LODESTAR_DEBIAN_POOL} "
                        "(${status}); run: apt install ${package}")
  endif()
  # A .deb is an `ar` archive that holds the files in data.tar.xz; CMake reads both.
  file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${folder}/${package}")
  file(ARCHIVE_EXTRACT INPUT "${folder}/${package}/data.tar.xz" DESTINATION "${folder}/${package}")
  set(${result} "${folder}/${package}/usr/include" PARENT_SCOPE)
endfunction()

# lodestar_header_package(<target> <header that shows it is there> <package> <file> <sha256>)
function(lodestar_header_package target header package file sha256)
  if(NOT TARGET ${target})
    add_library(${target} INTERFACE)
  endif()
  if(NOT LODESTAR_FETCH_HEADERS)
    find_path(LODESTAR_INCLUDE_${package} "${header}")
    mark_as_advanced(LODESTAR_INCLUDE_${package})
    set(include "${LODESTAR_INCLUDE_${package}}")
  endif()
  if(NOT include)
    lodestar_fetch_debian(include ${package} ${file} ${sha256})
  endif()
  target_include_directories(${target} SYSTEM INTERFACE "${include}")
endfunction()

lodestar_header_package(lodestar_tomlplusplus toml++/toml.h libtomlplusplus-dev
  t/tomlplusplus/libtomlplusplus-dev_3.3.0+ds-1_amd64.deb
  2779cce0001466dcf60eb6262ff68a888d49f9e30aee80c499d1d4f6f9f6e12e)
lodestar_header_package(lodestar_cli11 CLI/CLI.hpp libcli11-dev
  c/cli11/libcli11-dev_2.1.2+ds-1_all.deb
  f1f6ee9ec053e0e0bcec47345e241b6a8ee006321248b4329e9ce88d2b4b64a8)
lodestar_header_package(lodestar_spdlog spdlog/spdlog.h libspdlog-dev
  s/spdlog/libspdlog-dev_1.10.0+ds-0.4_amd64.deb
  4e19d647fe9bc9ec6a1fae81be00a69b1796b41660e8a7a4cf567264b463dcfb)
lodestar_header_package(lodestar_spdlog fmt/core.h libfmt-dev
  f/fmtlib/libfmt-dev_9.1.0+ds1-2_amd64.deb
  c8fa00dd0269e6eda9fd06668df3d720de4b5a1f647dcd3c6e0ba63f0cbf2150)
target_compile_definitions(lodestar_spdlog INTERFACE FMT_HEADER_ONLY SPDLOG_FMT_EXTERNAL)
find_package(Threads REQUIRED)
target_link_libraries(lodestar_spdlog INTERFACE Threads::Threads)
