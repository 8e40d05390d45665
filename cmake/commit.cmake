# Writes OUT, a source that names the commit of the tree SOURCE; "" where there is none. An unchanged file is
# left alone.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit "")
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[
#include "cli/command.hpp"

namespace splinevox::cli {
const char* program_commit() { return "@commit@"; }
}  // namespace splinevox::cli
]])
