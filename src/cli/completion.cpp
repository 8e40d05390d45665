// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "cli/tree.hpp"
#include "core/nearest.hpp"
#include "core/shell_word.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::cli {
namespace {

using Out = std::back_insert_iterator<std::string>;

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// With a backslash before each of some characters.
std::string escaped(const std::string& text, const std::string& special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != special.npos) out += '\\';
    out += c;
  }
  return out;
}

std::string bash(const std::vector<VerbEntry>& verbs) {
  std::string text =
      "# bash completion of splinevox, made by `splinevox completion bash`\n_splinevox() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]} "
      "words=\n  COMPREPLY=()\n";
  const Out out(text);
  fmt::format_to(out, "  if ((COMP_CWORD == 1)); then\n    words='");
  for (const VerbEntry& v : verbs) fmt::format_to(out, "{} ", v.name);
  fmt::format_to(out, "--help --version'\n  else\n    case $verb,$before in\n");
  for (const VerbEntry& v : verbs)
    for (const OptionEntry& o : v.options) {
      if (o.value.empty() || o.positional()) continue;
      std::vector<std::string> patterns;
      for (const std::string& n : o.names) patterns.push_back(v.name + "," + n);
      if (o.choices.empty())
        fmt::format_to(out, "      {}) return ;;\n",
                       fmt::join(patterns, "|"));  // a file, or nothing anyone could know
      else
        fmt::format_to(out, "      {}) words='{}' ;;\n", fmt::join(patterns, "|"), fmt::join(o.choices, " "));
    }
  fmt::format_to(out, "      *) case $verb in\n");
  for (const VerbEntry& v : verbs) {
    std::vector<std::string> options, others;
    for (const OptionEntry& o : v.options)
      std::copy((o.positional() ? o.choices : o.names).begin(), (o.positional() ? o.choices : o.names).end(),
                std::back_inserter(o.positional() ? others : options));
    fmt::format_to(out, "        {}) if [[ $word == -* ]]; then words='{}'; else words='{}'; fi ;;\n", v.name,
                   fmt::join(options, " "), fmt::join(others, " "));
  }
  text +=
      "      esac ;;\n    esac\n  fi\n  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n}\ncomplete -o "
      "default -F _splinevox splinevox\n";
  return text;
}

std::string zsh(const std::vector<VerbEntry>& verbs) {
  std::string text =
      "#compdef splinevox\n# zsh completion of splinevox, made by `splinevox completion zsh`\n_splinevox() "
      "{\n  if ((CURRENT == 2)); then\n    local -a verbs=(\n";
  const Out out(text);
  for (const VerbEntry& v : verbs) fmt::format_to(out, "      {}\n", shell_quoted(v.name + ":" + v.summary));
  text +=
      "      '--help:the options of splinevox'\n      '--version:the version'\n    )\n    _describe -t "
      "commands verb verbs\n    return\n  fi\n"
      "  local verb=$words[2]\n  shift words\n  ((CURRENT--))\n  case $verb in\n";
  for (const VerbEntry& v : verbs) {
    fmt::format_to(out, "    {}) _arguments -s", v.name);
    int place = 0;
    for (const OptionEntry& o : v.options) {
      const std::string values =
          o.choices.empty() ? "_files" : fmt::format("({})", fmt::join(o.choices, " "));
      const std::string value = o.value.empty() ? "" : fmt::format(":{}:{}", escaped(o.value, ":\\"), values);
      if (o.positional())
        fmt::format_to(out, " \\\n      {}",
                       shell_quoted((o.repeats ? "*" : std::to_string(++place)) + value));
      for (const std::string& n : o.names)
        fmt::format_to(out, " \\\n      {}",
                       shell_quoted(fmt::format("{}{}[{}]{}", o.repeats ? "*" : "", n,
                                                escaped(first_line(o.text), "[]\\"), value)));
    }
    text += " ;;\n";
  }
  text +=
      "  esac\n}\nif [[ $funcstack[1] == _splinevox ]]; then _splinevox \"$@\"; else compdef _splinevox "
      "splinevox; fi\n";
  return text;
}

std::string fish(const std::vector<VerbEntry>& verbs) {
  std::string text = "# fish completion of splinevox, made by `splinevox completion fish`\n";
  const Out out(text);
  const auto quote = [](const std::string& t) { return "'" + escaped(t, "'\\") + "'"; };
  fmt::format_to(out,
                 "complete -c splinevox -n __fish_use_subcommand -l help -d 'the options of "
                 "splinevox'\ncomplete -c splinevox -n __fish_use_subcommand -l version -d 'the version'\n");
  for (const VerbEntry& v : verbs) {
    fmt::format_to(out, "complete -c splinevox -n __fish_use_subcommand -f -a {} -d {}\n", v.name,
                   quote(v.summary));
    for (const OptionEntry& o : v.options) {
      std::string line = fmt::format("complete -c splinevox -n '__fish_seen_subcommand_from {}'", v.name);
      if (o.positional() && o.choices.empty()) continue;
      for (const std::string& n : o.names) line += n[1] == '-' ? " -l " + n.substr(2) : " -s " + n.substr(1);
      if (!o.choices.empty())
        line += fmt::format(" {} -a {}", o.positional() ? "-f" : "-x",
                            quote(fmt::format("{}", fmt::join(o.choices, " "))));
      else if (!o.value.empty())
        line += " -r";
      fmt::format_to(out, "{} -d {}\n", line, quote(first_line(o.text)));
    }
  }
  return text;
}

}  // namespace

const std::vector<std::string>& completion_shells() {
  static const std::vector<std::string> shells = {"bash", "zsh", "fish"};
  return shells;
}

std::string completion(const CLI::App& app, const std::string& shell) {
  const std::vector<VerbEntry> verbs = describe(app);
  if (shell == "bash") return bash(verbs);
  if (shell == "zsh") return zsh(verbs);
  if (shell == "fish") return fish(verbs);
  fail({"completion", fmt::format("there is no completion for '{}'", shell),
        fmt::format("one of {}", fmt::join(completion_shells(), ", ")), shell,
        nearest(shell, completion_shells())});
}

}  // namespace splinevox::cli
