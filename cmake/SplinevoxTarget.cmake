# Which instructions. Only x86 has a level beyond what every processor of its kind has.
include(CheckCXXCompilerFlag)
set(splinevox_march "")
if(SPLINEVOX_NATIVE AND NOT CMAKE_CROSSCOMPILING)
  check_cxx_compiler_flag(-march=native splinevox_knows_native)
endif()
if(SPLINEVOX_NATIVE AND splinevox_knows_native)
  set(splinevox_march -march=native)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  set(splinevox_march -march=x86-64-v3)
endif()

# splinevox_target(name): what every target of the project shares.
function(splinevox_target name)
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(${name} PRIVATE -Wall -Wextra -Wshadow -Wno-psabi)
  # Neither changes a value: they only let sqrt and selects become vector code.
  target_compile_options(${name} PRIVATE -fno-math-errno -fno-trapping-math)
  target_compile_options(${name} PRIVATE ${splinevox_march})
  # Of a long file g++ would spend a tenth of the time on collecting garbage.
  target_compile_options(${name} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>")
  if(SPLINEVOX_SANITIZE)
    # Undefined behaviour ends the program: a report that only prints would pass every test.
    target_compile_options(${name} PRIVATE
      -fsanitize=${SPLINEVOX_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g)
    target_link_options(${name} PUBLIC -fsanitize=${SPLINEVOX_SANITIZE})
  endif()
endfunction()

# splinevox_unity(target [QUICK] folder...): the target's sources of these folders ("." is its own) are
# compiled as one file, because most of the compiler's work is headers that each would read and instantiate
# again. Names in their unnamed namespaces must then differ. Not for folders that are all arithmetic: with
# more of it in sight the compiler may fuse other products and sums. QUICK: at -O1, for what reads and writes
# text and waits for disks, and compiles in two thirds of the time.
function(splinevox_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 unity QUICK "" "")
  set(folders ${unity_UNPARSED_ARGUMENTS})
  get_target_property(sources ${target} SOURCES)
  string(MAKE_C_IDENTIFIER "${folders}" group)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH folder)
    if(folder STREQUAL "" OR IS_ABSOLUTE "${folder}")
      set(folder .)
    endif()
    if(folder IN_LIST folders)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP unity${group})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  if(unity_QUICK)  # where g++ 12 takes its own undefined vectors of AVX-512 for forgotten ones
    set_source_files_properties(
      ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/Unity/unity_unity${group}_cxx.cxx
      PROPERTIES COMPILE_OPTIONS "-O1;-Wno-maybe-uninitialized")
  endif()
endfunction()

# Sums in another order and a compiler that may assume there is no NaN: bits would no longer be the same,
# and a step that went wrong no longer seen. By name, for what has no macro; and by the compiler's own word,
# whichever way it was told.
string(TOUPPER "${CMAKE_BUILD_TYPE}" splinevox_config)
set(splinevox_flags "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${splinevox_config}}")
string(APPEND splinevox_flags " ${CMAKE_CUDA_FLAGS} ${CMAKE_CUDA_FLAGS_${splinevox_config}}")
set(CMAKE_TRY_COMPILE_CONFIGURATION "${CMAKE_BUILD_TYPE}")
include(CheckCXXSourceCompiles)
unset(splinevox_exact_math CACHE)
check_cxx_source_compiles("
#if (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(__FAST_MATH__)
#error finite math only
#endif
int main() {}" splinevox_exact_math)
unset(CMAKE_TRY_COMPILE_CONFIGURATION)
set(splinevox_inexact -ffast-math use_fast_math -ffinite-math-only -Ofast -funsafe-math-optimizations
  -fassociative-math -freciprocal-math)
list(JOIN splinevox_inexact "|" splinevox_inexact)
if(NOT splinevox_exact_math OR splinevox_flags MATCHES "${splinevox_inexact}")
  message(FATAL_ERROR "splinevox refuses -ffast-math and its parts: non-finite values could no longer be "
                      "found, and sums would change with the compiler (the flags are '${splinevox_flags}')")
endif()
