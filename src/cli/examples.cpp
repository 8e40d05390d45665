// SPDX-License-Identifier: Apache-2.0
#include <map>

#include "cli/tree.hpp"

namespace splinevox::cli {

const std::vector<Example>& order_of_use() {
  static const std::vector<Example> order = {
      {"splinevox synth dancer --out scene", "a scene to try; `capture` makes one of your own films"},
      {"splinevox info scene", "is everything there, and is anything odd?"},
      {"splinevox train scene --out run", "minutes on a CPU"},
      {"splinevox eval run", "how good is it in pictures that it has not seen?"},
      {"splinevox export run --out vdb --frames 1-48", "for Blender; --profile names other programs"},
      {"splinevox render run --out film --format mp4", "a film"},
      {"splinevox view run --out page.html", "a page on which to look at it from anywhere"},
  };
  return order;
}

std::vector<Example> examples_of(const std::string& verb) {
  static const std::map<std::string, std::vector<Example>> all = {
      {"synth",
       {{"splinevox synth dancer --out scene --frames 100 --size 400",
         "a figure that dances, seen all around"},
        {"splinevox synth smoke --out rig --cameras 8 --frames 40",
         "smoke before eight cameras that stand still"}}},
      {"capture",
       {{"splinevox capture film.mp4 --out scene --frames 150", "a film of one camera that moves"},
        {"splinevox capture cam1.mp4 cam2.mp4 cam3.mp4 --out studio --from 2 --to 8",
         "six seconds of three cameras that stand still"}}},
      {"convert",
       {{"splinevox convert capture --out scene",
         "transforms_train.json and so on, which many programs read"},
        {"splinevox convert site --out scene --shift -431200,-5411800,0 --scale 0.1",
         "from the coordinates of a map to near the origin, a tenth as large"}}},
      {"info",
       {{"splinevox info scene --pixels", "what is odd about a data set, its pictures included"},
        {"splinevox info run --json", "a run as JSON, for a script"}}},
      {"train",
       {{"splinevox train scene --out run --preset fast --max-time 300", "five minutes, loading included"},
        {"splinevox train scene --out run --resume --max-time 900", "a longer budget for the same run"},
        {"splinevox train scene --out run --downscale 2 --set motion.points=12 --live",
         "half the pictures' size, one setting, and a page to watch"}}},
      {"sweep",
       {{"splinevox sweep seeds.toml --out sweep --jobs 2",
         "two trainings at a time, and a table at the end"},
        {"splinevox sweep seeds.toml --out sweep --list", "only the list and the script for Slurm"}}},
      {"edit",
       {{"splinevox edit run --out slow --speed 0.5", "half as fast: the first half of the motion"},
        {"splinevox edit run --out part --clusters auto --cluster moving --hide", "without all that moves"}}},
      {"eval",
       {{"splinevox eval run --images pictures", "figures, and each picture beside its truth"},
        {"splinevox eval run --split val --json", "figures of another split, for a script"}}},
      {"report",
       {{"splinevox report run --out report.html", "one run"},
        {"splinevox report run1 run2 --out compared.html --views 12", "two runs side by side"}}},
      {"verify",
       {{"splinevox verify run", "a run after it was copied"},
        {"splinevox verify vdb --json", "an export, for a script"}}},
      {"export",
       {{"splinevox export run --out vdb --profile blender --frames 1-48",
         "then: blender -P vdb/load_in_blender.py"},
        {"splinevox export run --out shot --frames 1050-1099 --at 1001 --seconds 4",
         "fifty frames of a shot whose motion begins at frame 1001"}}},
      {"render",
       {{"splinevox render run --out film --camera orbit --times 0:1:120 --format mp4",
         "once around in 120 pictures"},
        {"splinevox render run --out comp --format exr --layers RGBA,Z --frames 1-48", "for compositing"}}},
      {"view",
       {{"splinevox view run --out page.html", "one file that a browser opens"},
        {"splinevox view run --out small.html --max-mb 5 --views 0", "a small one, without true pictures"}}},
      {"track",
       {{"splinevox track run --points points.csv --to 0.25,0.5,1 --out tracks.csv",
         "points of time 0 at three later times"},
        {"splinevox track run --points p.csv --from 0.5 --to canonical --out p.json",
         "where points of time 0.5 lie in canonical space"}}},
      {"import",
       {{"splinevox import capture.ply --out vdb --profile blender", "one file of splats as a volume"},
        {"splinevox import splats --out vdb --fps 30 --voxel-size 0.01", "a folder of them as a sequence"}}},
      {"man", {{"splinevox man | man -l -", "to read it"}, {"splinevox man > splinevox.1", "to install it"}}},
      {"completion",
       {{"splinevox completion bash > ~/.splinevox.bash", "for bash: `source` it in ~/.bashrc"},
        {"splinevox completion fish > ~/.config/fish/completions/splinevox.fish", "for fish"}}},
  };
  const auto found = all.find(verb);
  return found == all.end() ? std::vector<Example>{} : found->second;
}

}  // namespace splinevox::cli
