// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "run/support.hpp"
#include "run/teller.hpp"
#include "view/write_view.hpp"

namespace splinevox::cli {
namespace {

struct ViewVerb : ViewRequest {
  int threads = 0;
  TalkWords talk;
};

int view(const ViewVerb& o) {
  const Teller teller(choose_talk(o.talk.quiet, o.talk.json));
  const WrittenView page = write_view(o);
  for (const std::string& lack : page.lacks) teller.warn(lack);
  teller.result(
      {{"out", o.out}, {"bytes", page.bytes}, {"quality", page.note}, {"true_pictures", page.true_pictures}},
      fmt::format("{:.2f} MB of at most {:g}: {}; {} true pictures\n{}", double(page.bytes) * 1e-6, o.max_mb,
                  page.note, page.true_pictures, o.out));
  return 0;
}

}  // namespace

Action view_command(CLI::App& verb) {
  auto o = std::make_shared<ViewVerb>();
  verb.add_option("RUN", o->run, "the run to look at")->required();
  heading(verb, "Page");
  verb.add_option("--out", o->out, "the page, one self-contained HTML file")->required();
  verb.add_option("--max-mb", o->max_mb,
                  "largest page, MB: numbers are rounded more, then voxels made larger, until it fits")
      ->check(decimals_in(run::kLeastMb, run::kMostMb))
      ->capture_default_str();
  heading(verb, kData);
  verb.add_option("--views", o->views, "true pictures to compare with")
      ->check(CLI::Range(0, run::kMostTrueViews))
      ->capture_default_str();
  verb.add_option("--view-size", o->view_size, "their longest side at most, pixels")
      ->check(CLI::Range(run::kLeastViewSize, run::kMostViewSize))
      ->capture_default_str();
  verb.add_option("--split", o->split, "where they are from: train, val or test")
      ->check(CLI::IsMember({"train", "val", "test"}))
      ->capture_default_str();
  verb.add_option("--data", o->data, "the data set, if it is no longer where the run found it");
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  return [o] { return with_threads(o->threads, [&] { return view(*o); }); };
}

}  // namespace splinevox::cli
