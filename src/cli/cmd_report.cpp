// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "report/write_report.hpp"
#include "run/support.hpp"
#include "run/teller.hpp"

namespace splinevox::cli {
namespace {

struct ReportVerb : ReportRequest {
  int threads = 0;
  TalkWords talk;
};

int report(const ReportVerb& o) {
  const std::size_t bytes = write_report(o);
  Teller(choose_talk(o.talk.quiet, o.talk.json))
      .result({{"out", o.out}, {"runs", o.runs}, {"bytes", bytes}}, o.out);
  return 0;
}

}  // namespace

Action report_command(CLI::App& verb) {
  auto o = std::make_shared<ReportVerb>();
  verb.add_option("RUN", o->runs, "one or more runs")->required();
  heading(verb, "Page");
  verb.add_option("--out", o->out, "the page, one self-contained HTML file")->required();
  verb.add_option("--data", o->data, "the data set, if it is no longer where the run found it");
  verb.add_option("--views", o->views, "test pictures per run")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  return [o] { return with_threads(o->threads, [&] { return report(*o); }); };
}

}  // namespace splinevox::cli
