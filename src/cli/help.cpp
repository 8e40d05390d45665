// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "cli/options.hpp"
#include "cli/tree.hpp"
#include "run/support.hpp"

namespace splinevox::cli {
namespace {

constexpr std::size_t kColumn = 26;  ///< where texts begin, behind the names

/// Text in lines of at most `width` columns, each behind `indent` of them. Words stay whole. A line of the
/// text begins a new one; what it is indented by, its further lines are too, and twice as far.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::string out;
  for (const std::string& line : run::split_list(text, '\n')) {
    const std::size_t own = std::min(line.find_first_not_of(' '), line.size());
    std::string row(indent + own, ' ');
    bool empty = true;
    std::istringstream words(line);
    for (std::string word; words >> word; empty = false) {
      if (!empty && row.size() + 1 + word.size() > width) {
        out += row + "\n";
        row.assign(indent + 2 * own, ' ');
        empty = true;
      }
      row += (empty ? "" : " ") + word;
    }
    out += row + "\n";
  }
  return out;
}

/// A name and its text beside it, or below where the name is long.
std::string entry(const std::string& name, const std::string& text, std::size_t width) {
  const std::string left = "  " + name, right = wrapped(text, kColumn, width);
  if (left.size() + 2 > kColumn) return left + "\n" + right;
  return left + right.substr(left.size());
}

std::string option(const OptionEntry& o, std::size_t width) {
  const std::string name =
      o.positional()    ? o.value
      : o.value.empty() ? fmt::format("{}", fmt::join(o.names, ", "))
                        : fmt::format("{} {}{}", fmt::join(o.names, ", "), o.value, o.repeats ? " ..." : "");
  const std::string facts = o.facts();
  const bool list = o.text.find('\n') != o.text.npos;  // its last line is an item, not the end of a sentence
  return entry(name, facts.empty() ? o.text : fmt::format("{}{}({})", o.text, list ? "\n" : " ", facts),
               width);
}

/// Under their headings, each where its first entry stands.
template <class Entry, class Print>
std::string grouped(const std::vector<Entry>& entries, const Print& print) {
  std::vector<std::pair<std::string, std::string>> groups;
  for (const Entry& e : entries) {
    auto group =
        std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == e.group; });
    if (group == groups.end()) group = groups.insert(group, {e.group, ""});
    group->second += print(e);
  }
  std::string text;
  for (const auto& [name, body] : groups) text += fmt::format("\n{}\n{}", name, body);
  return text;
}

std::string examples(const char* heading, const std::vector<Example>& list, std::size_t width) {
  std::string text = fmt::format("\n{}\n", heading);
  for (const Example& e : list) text += fmt::format("  {}\n{}", e.words, wrapped(e.purpose, 6, width));
  return text;
}

}  // namespace

std::string help_page(const CLI::App& app, int columns) {
  const auto width = std::size_t(columns);
  return wrapped(app.get_description(), 0, width) +
         "\nUsage: splinevox VERB [ARGUMENT]...\n       splinevox VERB --help      with examples\n"
         "       splinevox --version\n" +
         grouped(describe(app), [&](const VerbEntry& v) { return entry(v.name, v.summary, width); }) +
         examples("In order of use", order_of_use(), width);
}

std::string help_page(const VerbEntry& v, int columns) {
  const auto width = std::size_t(columns);
  std::string text = wrapped(fmt::format("splinevox {}: {}", v.name, v.summary), 0, width);
  text += "\nUsage:\n" + wrapped("splinevox " + v.synopsis(), 2, width);
  std::vector<OptionEntry> named;
  for (const OptionEntry& o : v.options)
    if (!o.positional()) named.push_back(o);
  std::stable_partition(named.begin(), named.end(), [](const OptionEntry& o) { return o.group != kTalk; });
  if (named.size() < v.options.size()) text += "\nArguments\n";
  for (const OptionEntry& o : v.options)
    if (o.positional()) text += option(o, width);
  text += grouped(named, [&](const OptionEntry& o) { return option(o, width); });
  text += examples("Examples", v.examples, width);
  return v.footer.empty() ? text : text + "\n" + wrapped(v.footer, 0, width);
}

}  // namespace splinevox::cli
