// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/error.hpp"

#include <utility>

namespace splinevox {
namespace {

std::string message(const Problem& p) {
  std::string text = p.where + ": " + p.what;
  if (!p.expected.empty()) text += "\n  expected: " + p.expected;
  if (!p.got.empty()) text += "\n  got:      " + p.got;
  if (!p.hint.empty()) text += "\n  try:      " + p.hint;
  return text;
}

}  // namespace

Error::Error(Problem p, Fault f) : std::runtime_error(message(p)), problem(std::move(p)), fault(f) {}

void fail(Problem problem) { throw Error(std::move(problem), Fault::input); }
void fail_output(Problem problem) { throw Error(std::move(problem), Fault::output); }

}  // namespace splinevox
