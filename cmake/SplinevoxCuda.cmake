# SPLINEVOX_CUDA: AUTO compiles the CUDA kernels where nvcc is and says what it did; ON wants them; OFF does
# not look. The program runs the same without a device: the runtime is linked statically and finds the driver
# when it is asked to.
set(SPLINEVOX_CUDA "AUTO" CACHE STRING "Compile the CUDA kernels: AUTO (where nvcc is), ON or OFF")
set(SPLINEVOX_CUDA_ARCHITECTURES "80-real;90" CACHE STRING
    "Devices to compile for: 75-real to 120-real; the last one without -real is also for newer devices")
set(SPLINEVOX_CUDA_FOUND OFF)
if(NOT SPLINEVOX_CUDA STREQUAL "OFF")
  find_program(SPLINEVOX_NVCC nvcc HINTS ENV CUDACXX PATHS /usr/local/cuda/bin)
  if(SPLINEVOX_NVCC)
    set(CMAKE_CUDA_COMPILER ${SPLINEVOX_NVCC})
    set(CMAKE_CUDA_ARCHITECTURES ${SPLINEVOX_CUDA_ARCHITECTURES})
    enable_language(CUDA)
    find_package(CUDAToolkit REQUIRED)
    set(SPLINEVOX_CUDA_FOUND ON)
    message(STATUS
      "CUDA: kernels for ${SPLINEVOX_CUDA_ARCHITECTURES}, by ${SPLINEVOX_NVCC} ${CUDAToolkit_VERSION}")
  elseif(SPLINEVOX_CUDA STREQUAL "AUTO")
    message(STATUS "CUDA: no nvcc here, so no CUDA kernels; everything else is built and tested")
  else()
    message(FATAL_ERROR "SPLINEVOX_CUDA=ON, but there is no nvcc on the path or in /usr/local/cuda/bin; "
                        "set CUDACXX, or leave it at AUTO")
  endif()
endif()
