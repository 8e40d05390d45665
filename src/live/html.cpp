// SPDX-License-Identifier: Apache-2.0
#include "live/html.hpp"

#include "report/chart.hpp"
#include "view/page.hpp"

namespace splinevox::run {

std::string live_html(const std::string& name) {
  const std::string charts =
      line_chart({"PSNR", "seconds", "dB"}, {{"training rays", 0, Series::Mark::line, {}},
                                             {"held-out view", 1, Series::Mark::dots, {}}}) +
      line_chart({"Loss", "seconds", "of a ray", true}, {{"loss", 2, Series::Mark::line, {}}});
  std::string beside(live_asset("live.html"));
  const std::string mark = "<!--charts-->";
  beside.replace(beside.find(mark), mark.size(), charts);
  return viewer_page({.title = name,
                      .about = "training",
                      .style = std::string(live_asset("live.css")),
                      .beside = beside,
                      .data = chart_scripts(),
                      .scripts = std::string(live_asset("live.js")),
                      .body_class = "live"});
}

}  // namespace splinevox::run
