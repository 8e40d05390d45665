# SPLINEVOX_CUDA: AUTO compiles the CUDA kernels where nvcc and a device are and says what it did; ON wants
# them, device or not; OFF does not look. The program runs the same without a device: the runtime is linked
# statically and finds the driver when it is asked to.
set(SPLINEVOX_CUDA "AUTO" CACHE STRING
    "Compile the CUDA kernels: AUTO (where nvcc and a device are), ON or OFF")
set(SPLINEVOX_CUDA_ARCHITECTURES "80-real;90" CACHE STRING
    "Devices to compile for: 75-real to 120-real; the last one without -real is also for newer devices")
set(SPLINEVOX_CUDA_FOUND OFF)

# A driver leaves one of these.
find_program(SPLINEVOX_NVIDIA_SMI nvidia-smi)
set(cuda_device OFF)
if(SPLINEVOX_NVIDIA_SMI OR EXISTS /dev/nvidia0 OR EXISTS /proc/driver/nvidia)
  set(cuda_device ON)
endif()

if(SPLINEVOX_CUDA STREQUAL "AUTO" AND NOT cuda_device)
  message(STATUS "CUDA: no device here, so no CUDA kernels; -DSPLINEVOX_CUDA=ON compiles them all the same")
elseif(SPLINEVOX_CUDA)
  get_filename_component(cuda_hint "$ENV{CUDACXX}" DIRECTORY)
  find_program(SPLINEVOX_NVCC nvcc HINTS "${cuda_hint}" PATHS /usr/local/cuda/bin)
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
