// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <vector>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "run/teller.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::cli {

Action convert_command(CLI::App& verb) {
  struct Options {
    std::string dataset, out;
    std::vector<double> shift;
    double scale = 1;
    DatasetRules rules;
    TalkWords talk;
  };
  auto o = std::make_shared<Options>();
  verb.add_option("DATASET", o->dataset,
                  fmt::format("folder of a data set: {}", fmt::join(dataset_formats(), ", ")))
      ->required();
  heading(verb, "Output");
  verb.add_option("--out", o->out, "folder to write: transforms_{train,val,test}.json and pictures")
      ->required();
  verb.add_option("--shift", o->shift,
                  "X,Y,Z: added to every position, to bring a scene in coordinates of a map near the origin")
      ->delimiter(',')
      ->expected(3)
      ->allow_extra_args(false);
  verb.add_option("--scale", o->scale, "of every position, after --shift: for a unit too large or too small")
      ->capture_default_str();
  add_rules(verb, o->rules);
  add_talk(verb, o->talk);
  return [o] {
    Teller teller(choose_talk(o->talk.quiet, o->talk.json));
    int pictures = 0;
    convert_dataset(o->dataset, o->out,
                    [&](int done, int total) {
                      pictures = total;
                      teller.progress(done, total);
                    },
                    {o->shift.empty() ? Vec3d{} : Vec3d{o->shift[0], o->shift[1], o->shift[2]}, o->scale,
                     o->rules, [&](const std::string& note) { teller.note("note: " + note); }});
    teller.result({{"out", o->out}, {"pictures", pictures}},
                  fmt::format("{}: {} pictures; splinevox info {}", o->out, pictures, o->out));
    return 0;
  };
}

}  // namespace splinevox::cli
