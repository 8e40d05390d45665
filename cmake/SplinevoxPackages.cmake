# Debian packages: `cpack` in a build folder (./dev package). One for users, one with the shared library,
# one to build against it, one for Python.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR splinevox)
set(CPACK_PACKAGE_CONTACT "the splinevox authors <splinevox@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program library development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME splinevox)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS ffmpeg)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS colmap)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION
"Turns pictures of a moving scene, with cameras and times, into an OpenVDB
volume that plays at any time. Needs a processor with x86-64-v3 (AVX2).")

set(abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libsplinevox${abi})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "The shared library that programs built with libsplinevox-dev need.")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libsplinevox-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libsplinevox${abi} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Headers, CMake package and pkg-config file.")

set(packages "program:splinevox" "library:libsplinevox${abi}" "development:libsplinevox-dev")
if(SPLINEVOX_PYTHON)
  list(APPEND packages "python:python3-splinevox")
endif()
foreach(package IN LISTS packages)
  string(REGEX MATCH "(.*):(.*)" _ ${package})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE
    DESTINATION ${CMAKE_INSTALL_DOCDIR}/../${CMAKE_MATCH_2} RENAME copyright COMPONENT ${CMAKE_MATCH_1})
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

if(SPLINEVOX_PYTHON)
  find_package(Python COMPONENTS Interpreter)
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-splinevox)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(python_now ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR})
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= ${python_now}), python3 (<< ${Python_VERSION_MAJOR}.${next_python}~), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Train, render, measure and track from Python, with numpy arrays.")
endif()

# What a package holds must run elsewhere and hang together; a build for this machine alone must not become
# one by accident.
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/SplinevoxPackageCheck.cmake @ONLY CONTENT [[
cmake_minimum_required(VERSION 3.25)
if("@SPLINEVOX_NATIVE@" OR NOT "@SPLINEVOX_SHARED@" OR NOT "@SPLINEVOX_SANITIZE@" STREQUAL "")
  message(FATAL_ERROR "this build is not for packages: it has SPLINEVOX_NATIVE=@SPLINEVOX_NATIVE@ "
                      "SPLINEVOX_SHARED=@SPLINEVOX_SHARED@ SPLINEVOX_SANITIZE='@SPLINEVOX_SANITIZE@'; "
                      "the preset `package` (./dev package) sets what they need")
endif()
]])
set(CPACK_INSTALL_SCRIPTS ${PROJECT_BINARY_DIR}/SplinevoxPackageCheck.cmake)
include(CPack)
