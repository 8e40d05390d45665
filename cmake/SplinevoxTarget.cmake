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
  if(SPLINEVOX_NATIVE)
    target_compile_options(${name} PRIVATE -march=native)
  else()
    target_compile_options(${name} PRIVATE -march=x86-64-v3)
  endif()
  if(SPLINEVOX_SANITIZE)
    target_compile_options(${name} PRIVATE -fsanitize=${SPLINEVOX_SANITIZE} -fno-omit-frame-pointer -g)
    target_link_options(${name} PUBLIC -fsanitize=${SPLINEVOX_SANITIZE})
  endif()
endfunction()

if(CMAKE_CXX_FLAGS MATCHES "-ffast-math|-ffinite-math-only|-Ofast")
  message(FATAL_ERROR "splinevox refuses -ffast-math: non-finite values could no longer be found "
                      "(CMAKE_CXX_FLAGS is '${CMAKE_CXX_FLAGS}')")
endif()
