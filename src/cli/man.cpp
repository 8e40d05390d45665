// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "cli/tree.hpp"
#include "run/support.hpp"

namespace splinevox::cli {
namespace {

/// Text as troff takes it literally: no escapes, hyphens that can be copied, no line that looks like a macro.
std::string literal(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (out.empty() || out.back() == '\n')
      if (c == '.' || c == '\'') out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

/// Lines that are to stay lines.
std::string lines(const std::string& text) {
  std::string out;
  for (const std::string& line : run::split_list(text, '\n'))
    out += (out.empty() ? "" : "\n.br\n") + literal(line.substr(line.find_first_not_of(' ')));
  return out;
}

std::string heading(const OptionEntry& o) {
  if (o.positional()) return fmt::format("\\fI{}\\fR", literal(o.value));
  std::string names;
  for (const std::string& n : o.names)
    names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", literal(n));
  return o.value.empty() ? names
                         : fmt::format("{} \\fI{}\\fR{}", names, literal(o.value), o.repeats ? " ..." : "");
}

std::string body(const OptionEntry& o) {
  const std::string text = lines(o.text), facts = o.facts();
  return facts.empty() ? text : fmt::format("{} ({})", text, literal(facts));
}

std::string example_list(const std::vector<Example>& examples) {
  std::string text;
  for (const Example& e : examples)
    text += fmt::format(".TP\n{}\n{}\n", literal(e.words), literal(e.purpose));
  return text;
}

constexpr const char* kEnd = R"(.SH EXIT STATUS
.TP
0
done
.TP
1
something that is not the input failed: a full disk, too little memory, numbers that are not finite
.TP
2
the input is wrong; the message says where, what was expected, what was found and what to try
.TP
130
interrupted; what was done so far is saved
.SH ENVIRONMENT
.TP
.B SPLINEVOX_DATA
folder of data sets for the tests and benchmarks that want real ones
.TP
.B SPLINEVOX_RUN_ID
what the lines of \-\-json have as run_id; not set: a new one for every call
)";

}  // namespace

std::string man_page(const CLI::App& app, const std::string& version) {
  std::string page =
      fmt::format(".TH SPLINEVOX 1 \"\" \"splinevox {}\" \"User Commands\"\n.SH NAME\nsplinevox \\- {}\n",
                  literal(version), literal(app.get_description()));
  page +=
      ".SH SYNOPSIS\n.B splinevox\n.I VERB\n[\\fIARGUMENT\\fR]...\n.br\n.B splinevox\n.I "
      "VERB\n\\fB\\-\\-help\\fR\n";
  page +=
      ".SH DESCRIPTION\nTurns pictures of a moving scene, with cameras and times, into a sparse OpenVDB "
      "volume whose motion is a spline: density, colour, "
      "and per voxel the control points of its curve. It plays at any time, is measured against held\\-out "
      "views, and is exported as an animated VDB sequence with velocities.\n.SH VERBS\n";
  for (const VerbEntry& v : describe(app)) {
    page += fmt::format(".SS {}\n{}\n.PP\n\\fBsplinevox\\fR {}\n", literal(v.name), lines(v.summary),
                        literal(v.synopsis()));
    for (const OptionEntry& o : v.options) page += fmt::format(".TP\n{}\n{}\n", heading(o), body(o));
    if (!v.footer.empty()) page += fmt::format(".PP\n{}\n", lines(v.footer));
    page += ".PP\nExamples:\n" + example_list(v.examples);
  }
  return page + kEnd + ".SH EXAMPLES\nIn order of use:\n" + example_list(order_of_use());
}

}  // namespace splinevox::cli
