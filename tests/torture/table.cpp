// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "torture/trial.hpp"

namespace splinevox::torture {

std::string table(const std::vector<Line>& lines, const Options& o, const std::string& machine) {
  std::string text = fmt::format(
      "`./dev torture --seconds {:.0f}`; seed {}; {}\n\n| trial | of | cases | crashes | hangs over 2 s | "
      "lost or "
      "wrong | seconds | |\n| --- | --- | ---: | ---: | ---: | ---: | ---: | --- |\n",
      o.seconds, o.seed, machine);
  Line all;
  for (const Line& l : lines) {
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {:.1f} | {} |\n", l.trial, l.what, l.tried,
                        l.crashes, l.hangs, l.lost, l.seconds, l.note);
    all.tried += l.tried;
    all.crashes += l.crashes;
    all.hangs += l.hangs;
    all.lost += l.lost;
    all.seconds += l.seconds;
  }
  return text + fmt::format("| **all** | | {} | **{}** | **{}** | **{}** | {:.1f} | |\n", all.tried,
                            all.crashes, all.hangs, all.lost, all.seconds);
}

}  // namespace splinevox::torture
