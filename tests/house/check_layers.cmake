# cmake -DROOT=<repository> -P check_layers.cmake : which layer may include which, and how long a file may be.
cmake_minimum_required(VERSION 3.25)
set(core_sees    core)
set(math_sees    core math)
set(data_sees    core math data)
set(field_sees   core math field)
set(render_sees  core math field render)
set(backend_sees core math field render backend)
set(train_sees   core math data field render backend train)
set(io_sees      core math field render io)
set(run_sees     core math data field render backend train io run)
set(view_sees    core math field render io run view)
set(report_sees  core data run report)
set(live_sees    core math data field render backend train io run view report live)
set(cli_sees     core math data field render backend train io run view report live cli)
set(python_sees  core math data field render backend train io run view report python)
set(limit 400)

# What is in <> of an include, and the files that may have it.
set(libraries
    "openvdb|nanovdb@^(src|include/splinevox)/io/" "cuda|cub|thrust|nccl@\\.(cu|cuh)$"
    "Eigen@/math/nearest_point.hpp|/data/(camera_check|layouts/axes).cpp"
    "CLI@/cli/" "mpi@/cli/join_ranks.cpp" "httplib@/live/server.cpp"
    "tbb/parallel@/core/(parallel|in_order).cpp"
    "toml@/train/config/(toml_library|config_text).cpp|/run/(run_folder|sweep/sweep).cpp")

file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/include/splinevox/*.hpp ${ROOT}/src/*.hpp ${ROOT}/src/*.cpp
     ${ROOT}/src/*.cu ${ROOT}/src/*.cuh)
foreach(file IN LISTS files)
  string(REGEX REPLACE "^(include/splinevox|src)/([a-z]+)/.*" "\\2" layer ${file})
  if(NOT DEFINED ${layer}_sees)
    message(SEND_ERROR "${file}: there is no layer '${layer}'")
    continue()
  endif()
  file(STRINGS ${ROOT}/${file} includes REGEX "^#include \"(splinevox/)?[a-z]+/")
  foreach(line IN LISTS includes)
    string(REGEX REPLACE "^#include \"(splinevox/)?([a-z]+)/.*" "\\2" target ${line})
    if(NOT target IN_LIST ${layer}_sees)
      message(SEND_ERROR "${file}: layer '${layer}' may not include '${target}'")
    endif()
  endforeach()
  # nvcc does not take OpenVDB's headers; the others are known in one place each (docs/architecture.md).
  file(STRINGS ${ROOT}/${file} foreign REGEX "^#include <")
  foreach(line IN LISTS foreign)
    foreach(library IN LISTS libraries)
      string(REGEX REPLACE "@.*" "" include ${library})
      string(REGEX REPLACE ".*@" "" known_by ${library})
      if(line MATCHES "^#include <(${include})[/_.a-z+]" AND NOT file MATCHES "${known_by}")
        message(SEND_ERROR "${file}: may not know this library (${line}); see docs/architecture.md")
      endif()
    endforeach()
  endforeach()
endforeach()

file(GLOB_RECURSE all RELATIVE ${ROOT} ${ROOT}/include/*.hpp ${ROOT}/src/* ${ROOT}/tests/* ${ROOT}/bench/*
     ${ROOT}/data_scripts/* ${ROOT}/cmake/*)
foreach(file IN LISTS all)
  if(NOT file MATCHES "\\.(hpp|cpp|cu|cuh|cmake|py|sh|html|js|css)$")
    continue()
  endif()
  file(READ ${ROOT}/${file} text)
  string(REGEX REPLACE "[^\n]+" "" newlines "${text}")
  string(LENGTH "${newlines}" count)
  if(count GREATER ${limit})
    message(SEND_ERROR "${file}: ${count} lines; the house limit is ${limit}. Split it.")
  endif()
endforeach()
