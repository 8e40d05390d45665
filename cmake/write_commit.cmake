# cmake -DSOURCE=FOLDER -DOUT=FILE -P write_commit.cmake: the commit of a source tree as a C string, empty
# where the tree is not git's own. The file is left alone where it says so already.
set(commit "")
execute_process(COMMAND git -C ${SOURCE} rev-parse --show-toplevel OUTPUT_VARIABLE top ERROR_QUIET
                OUTPUT_STRIP_TRAILING_WHITESPACE)
get_filename_component(own "${SOURCE}" REALPATH)
if(top STREQUAL own)
  execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --exclude=* --abbrev=10
                  OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
endif()
set(text "\"${commit}\"\n")
set(was "")
if(EXISTS ${OUT})
  file(READ ${OUT} was)
endif()
if(NOT text STREQUAL was)
  file(WRITE ${OUT} "${text}")
endif()
