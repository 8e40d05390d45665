# What `cmake --install` puts where, for programs (COMPONENT program), the shared library (library) and
# those who build against it (development).
include(CMakePackageConfigHelpers)
set(layers core math data field render backend train io run)

# The library as others link it, splinevox::splinevox: one shared library, or the layers' archives.
if(SPLINEVOX_SHARED)
  list(TRANSFORM layers PREPEND splinevox_ OUTPUT_VARIABLE archives)
  list(TRANSFORM archives REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
  add_library(splinevox_library SHARED ${objects})
  # For what they link: of theirs nothing is missing.
  target_link_libraries(splinevox_library PRIVATE ${archives})
  set_target_properties(splinevox_library PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME splinevox
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  splinevox_target(splinevox_library)
  set(exported splinevox_library)
else()
  add_library(splinevox_library INTERFACE)
  target_link_libraries(splinevox_library INTERFACE splinevox_run)
  set(exported splinevox_library)
  foreach(layer IN LISTS layers)
    set_target_properties(splinevox_${layer} PROPERTIES EXPORT_NAME ${layer})
    list(APPEND exported splinevox_${layer})
  endforeach()
endif()
set_target_properties(splinevox_library PROPERTIES EXPORT_NAME splinevox)
install(TARGETS ${exported} EXPORT splinevox
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/splinevox ${PROJECT_BINARY_DIR}/include/splinevox
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.hpp")

set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/splinevox)
configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/splinevoxConfig.cmake.in ${PROJECT_BINARY_DIR}/splinevoxConfig.cmake
  INSTALL_DESTINATION ${config_folder})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/splinevoxConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/splinevoxConfig.cmake ${PROJECT_BINARY_DIR}/splinevoxConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/SplinevoxOpenVDB.cmake
  DESTINATION ${config_folder} COMPONENT development)
install(EXPORT splinevox FILE splinevoxTargets.cmake NAMESPACE splinevox::
  DESTINATION ${config_folder} COMPONENT development)

# For those who build without CMake. Libraries without a .pc of their own stand under Libs.
if(SPLINEVOX_SHARED)
  set(pc_libraries "-lsplinevox")
  set(pc_requires "")
else()
  list(REVERSE layers)
  list(TRANSFORM layers PREPEND -lsplinevox_)
  list(JOIN layers " " pc_libraries)
  string(APPEND pc_libraries " -lopenvdb")
  if(SPLINEVOX_CUDA_FOUND)
    string(APPEND pc_libraries " ${CUDA_cudart_static_LIBRARY} -ldl -lrt")
  endif()
  set(pc_requires "OpenEXR libpng libjpeg zlib fmt tbb")
endif()
file(RELATIVE_PATH pc_up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${PROJECT_SOURCE_DIR}/cmake/splinevox.pc.in ${PROJECT_BINARY_DIR}/splinevox.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/splinevox.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

# The manual and the completions are the command line's own description of itself.
install(TARGETS splinevox COMPONENT program)
set(described "")
foreach(entry
        "man:man/man1/splinevox.1"
        "completion bash:bash-completion/completions/splinevox"
        "completion zsh:zsh/vendor-completions/_splinevox"
        "completion fish:fish/vendor_completions.d/splinevox.fish")
  string(REGEX MATCH "^([^:]+):((.+)/([^/]+))$" _ "${entry}")
  string(REPLACE " " ";" words "${CMAKE_MATCH_1}")
  set(file ${PROJECT_BINARY_DIR}/share/${CMAKE_MATCH_2})
  add_custom_command(OUTPUT ${file}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/share/${CMAKE_MATCH_3}
    COMMAND splinevox ${words} > ${file} DEPENDS splinevox VERBATIM)
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${CMAKE_MATCH_3} COMPONENT program)
  list(APPEND described ${file})
endforeach()
add_custom_target(splinevox_described ALL DEPENDS ${described})
