# OpenVDB::openvdb. OpenVDB brings a find module with it instead of a config file. Where that lies depends
# on who packed it: Debian, Fedora, conda and Homebrew each have a place of their own. Where none is, the
# header and the library are looked for. Also installed, for those who link the static library.
string(REPLACE ":" ";" openvdb_prefixes "$ENV{CMAKE_PREFIX_PATH}:$ENV{CONDA_PREFIX}:$ENV{HOMEBREW_PREFIX}")
list(PREPEND openvdb_prefixes ${CMAKE_PREFIX_PATH})
list(APPEND openvdb_prefixes ${CMAKE_SYSTEM_PREFIX_PATH})
find_path(SPLINEVOX_OPENVDB_MODULE FindOpenVDB.cmake
  PATHS ${openvdb_prefixes} NO_DEFAULT_PATH
  PATH_SUFFIXES lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB lib64/cmake/OpenVDB lib/cmake/OpenVDB)
mark_as_advanced(SPLINEVOX_OPENVDB_MODULE)
if(SPLINEVOX_OPENVDB_MODULE)
  list(APPEND CMAKE_MODULE_PATH ${SPLINEVOX_OPENVDB_MODULE})
  find_package(OpenVDB REQUIRED)
else()
  find_path(SPLINEVOX_OPENVDB_INCLUDE openvdb/openvdb.h
    HINTS ${openvdb_prefixes} PATH_SUFFIXES include REQUIRED)
  find_library(SPLINEVOX_OPENVDB_LIBRARY openvdb
    HINTS ${openvdb_prefixes} PATH_SUFFIXES lib lib64 REQUIRED)
  if(NOT TARGET OpenVDB::openvdb)
    add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
    set_target_properties(OpenVDB::openvdb PROPERTIES
      IMPORTED_LOCATION ${SPLINEVOX_OPENVDB_LIBRARY}
      INTERFACE_INCLUDE_DIRECTORIES ${SPLINEVOX_OPENVDB_INCLUDE}
      INTERFACE_LINK_LIBRARIES "TBB::tbb;Imath::Imath")
  endif()
endif()
