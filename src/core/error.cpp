// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/error.hpp"

#include <utility>

#include "core/printable.hpp"

namespace splinevox {
namespace {

/// Texts of a problem may come out of files: none of them can begin a line or move the cursor. Appends,
/// because g++ 12 sees an overlap in ": " + text that is not there.
std::string message(const Problem& p) {
  std::string text = all_printable(p.where);
  text += ": ";
  text += all_printable(p.what);
  const auto add = [&](const char* name, const std::string& field) {
    if (field.empty()) return;
    text += name;
    text += all_printable(field);
  };
  add("\n  expected: ", p.expected);
  add("\n  got:      ", p.got);
  add("\n  try:      ", p.hint);
  return text;
}

}  // namespace

Error::Error(Problem p, Fault f) : std::runtime_error(message(p)), problem(std::move(p)), fault(f) {}

void fail(Problem problem) { throw Error(std::move(problem), Fault::input); }
void fail_output(Problem problem) { throw Error(std::move(problem), Fault::output); }
void fail_memory(Problem problem) { throw Error(std::move(problem), Fault::memory); }

}  // namespace splinevox
