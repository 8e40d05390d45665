// SPDX-License-Identifier: Apache-2.0
#include "io/export/blender_script.hpp"

#include <algorithm>

#include "io/model/exact_text.hpp"

namespace splinevox {
namespace {

/// Gives a variable of the script's head another value: what stands after `name = ` up to a comment or the
/// end of the line.
void assign(std::string& script, const std::string& name, const std::string& value) {
  const std::size_t at = script.find("\n" + name + " = ") + name.size() + 4;
  const std::size_t end = std::min(script.find("  #", at), script.find('\n', at));
  script.replace(at, end - at, value);
}

std::string python(bool v) { return v ? "True" : "False"; }

}  // namespace

std::string blender_script(const BlenderSequence& s) {
  std::string script(host_script("load_in_blender.py"));
  script.erase(0, script.find('\n') + 1);  // the licence of the source; the copy is the user's
  const std::string example = "--frame 1";
  script.replace(script.find(example), example.size(), "--frame " + std::to_string(s.first));
  std::string prefixes = "(";
  for (const std::string& prefix : s.prefixes) prefixes += "\"" + prefix + "\", ";
  prefixes += ")";
  std::string background = "(";
  for (int c = 0; c < 3; ++c) background += exact_text<float>({s.background[c]}) + (c < 2 ? ", " : ")");
  assign(script, "FIRST, LAST", std::to_string(s.first) + ", " + std::to_string(s.last));
  assign(script, "FPS", exact_text<double>({s.fps}));
  assign(script, "VELOCITY", python(s.velocity));
  assign(script, "LINEAR", python(s.linear));
  assign(script, "PREFIXES", prefixes);
  assign(script, "SH_ORDER", std::to_string(s.sh_order));
  assign(script, "BACKGROUND", background);
  return script;
}

}  // namespace splinevox
