// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "run/support.hpp"

namespace splinevox::run {

/// One view as the page shows it.
struct ReportView {
  std::string name;  ///< with its split
  double time = 0, psnr = 0, ssim = 0;
  std::vector<char> truth, render, error, flow,
      rigidity;  ///< PNG files; the last two empty where the model has none
};

/// What a page knows about one run.
struct ReportRun {
  std::string name;
  std::vector<std::pair<std::string, std::string>> facts = {};  ///< where the run is from: what, and the text
  std::vector<std::pair<std::string, std::string>> links = {};  ///< files beside the page: text, and address
  Json metrics;                                                 ///< metrics.json
  std::vector<Json> lines;                                      ///< metrics.jsonl
  Json effects;                                                 ///< effects.json, null if there is none
  std::string config;                                           ///< config.toml
  std::string version = {};                                     ///< of its splinevox; "": unknown
  std::string model_file;                                       ///< its name in the run
  double model_bytes = 0;
  std::vector<ReportView> views;  ///< worst first
  std::string views_note;         ///< why there are none, or which they are
};

/// The whole page: no network, opens from disk.
std::string report_page(const std::vector<ReportRun>& runs);

/// A file that the page is made of, as it was when the program was built. @pre it is there.
std::string_view report_asset(std::string_view name);

}  // namespace splinevox::run
