# A build whose compiler may assume that there is no NaN, or may reorder sums, is refused when it is
# configured, however it was told to.
file(REMOVE_RECURSE ${WORK})
foreach(case IN ITEMS
        "CMAKE_CXX_FLAGS=-ffast-math" "CMAKE_CXX_FLAGS_RELEASE=-O3 -Ofast"
        "CMAKE_CXX_FLAGS=-O2 -fassociative-math" "CMAKE_CXX_FLAGS=-ffinite-math-only"
        "CMAKE_CUDA_FLAGS=--use_fast_math")
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${ROOT} -B ${WORK} -DCMAKE_BUILD_TYPE=Release
                          -DCMAKE_CXX_COMPILER=${COMPILER} "-D${case}"
                  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE message)
  if(NOT failed)
    message(SEND_ERROR "${case}: configured")
  elseif(NOT message MATCHES "splinevox refuses -ffast-math")
    message(SEND_ERROR "${case}: failed, but for another reason:\n${message}")
  endif()
  file(REMOVE_RECURSE ${WORK})
endforeach()
