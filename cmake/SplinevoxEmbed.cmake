# splinevox_embed(target header function file...): the files become part of the target, byte for byte.
# `header` declares
#   std::string_view function(std::string_view name);
# which finds a file's text by its name; empty: there is no such file. A changed file configures anew. The
# texts are raw strings: g++ and clang take them at any length, where the standard promises 65,536 bytes.
function(splinevox_embed target header function)
  set(embed_header ${header})
  set(embed_function ${function})
  set(embed_table "")
  foreach(file IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    get_filename_component(name ${file} NAME)
    file(READ ${file} text)
    string(FIND "${text}" ")embed\"" end)
    if(NOT end EQUAL -1)
      message(FATAL_ERROR "${file} holds )embed\", which would end the raw string it is to be embedded in; "
                          "spell it in another way")
    endif()
    string(APPEND embed_table "  if (name == \"${name}\") return R\"embed(${text})embed\"sv;\n")
  endforeach()
  file(CONFIGURE OUTPUT ${target}_embedded.cpp @ONLY CONTENT [[
#include "@embed_header@"
std::string_view @embed_function@(std::string_view name) {
  using namespace std::string_view_literals;
@embed_table@  return {};
}
]])
  target_sources(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/${target}_embedded.cpp)
endfunction()
