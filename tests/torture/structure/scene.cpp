// SPDX-License-Identifier: Apache-2.0
#include "torture/structure/case.hpp"

namespace splinevox::torture::structure {
namespace {

enum class Kind { still_rig, moving_camera, moving_rig, photographs, still_camera };

/// When the moments are: even, every so often, or with gaps.
std::vector<int> draw_ticks(Draw& draw, int moments) {
  const std::size_t kind = draw.below(5);
  const int step = kind == 3 ? draw.between(2, 10) : 1;
  std::vector<int> ticks;
  int tick = 0;
  for (int m = 0; m < moments; ++m) {
    ticks.push_back(tick);
    tick += kind == 4 ? draw.between(1, 3) : step;
  }
  return ticks;
}

}  // namespace

void draw_scene(Case& c) {
  Draw& draw = c.draw;
  const auto kind = Kind(draw.below(5));
  c.still = kind == Kind::still_rig || kind == Kind::still_camera;
  c.cameras = 1;
  c.moments = 1;
  switch (kind) {
    case Kind::still_rig:
    case Kind::moving_rig:
      c.cameras = draw.between(2, 6);
      c.moments = draw.between(3, 12);
      break;
    case Kind::moving_camera:
    case Kind::still_camera:
      c.moments = draw.between(6, 24);
      break;
    case Kind::photographs:
      c.cameras = draw.between(5, 24);
      break;
  }
  constexpr const char* kNames[] = {"still rig", "moving camera", "moving rig", "photographs",
                                    "still camera"};
  c.drawn.emplace_back(kNames[int(kind)]);
  const std::vector<int> ticks = draw_ticks(draw, c.moments);
  const bool lenses = draw.once_in(4), uneven = draw.once_in(4);
  for (int camera = 0; camera < c.cameras; ++camera)
    for (int moment = 0; moment < c.moments; ++moment) {
      Shot s{camera, moment, double(ticks[std::size_t(moment)]), {}, {}, {}};
      s.seen.to_world = test::orbit_matrix(0.37 * camera + (c.still ? 0 : 0.011 * moment));
      if (lenses) s.seen.lens.fx += 0.5 * camera;
      s.seen.lens.fy = s.seen.lens.fx + (uneven ? 0.5 : 0);
      c.shots.push_back(s);
    }
}

Case make_case(std::uint64_t seed, std::uint64_t index, const std::string& folder) {
  Case c(seed, index);
  c.folder = folder;
  draw_scene(c);
  const std::size_t layout = c.draw.below(100);
  c.layout = layout < 26   ? "D-NeRF"
             : layout < 50 ? "nerfstudio"
             : layout < 53 ? "NeRFlow"
             : layout < 65 ? "COLMAP text"
             : layout < 72 ? "COLMAP binary"
             : layout < 80 ? "LLFF"
             : layout < 85 ? "NR-NeRF"
             : layout < 91 ? "Nerfies"
                           : "DyNeRF folders";
  if (c.draw.once_in(150) && can_film()) c.layout = "DyNeRF films";
  if (c.layout.starts_with("DyNeRF") && !c.still) {  // rows are of cameras that stand still
    c.layout = c.draw.once_in(2) ? "D-NeRF" : "COLMAP text";
  }
  c.drawn.insert(c.drawn.begin(), c.layout);
  c.listed = c.layout == "D-NeRF" || c.layout == "nerfstudio" || c.layout.starts_with("COLMAP");
  if (c.draw.once_in(10) && !c.layout.ends_with("films")) {
    c.turn = c.draw.one_of({3, 6, 8});
    c.drawn.push_back("EXIF " + std::to_string(c.turn));
  }
  if (c.layout.starts_with("DyNeRF"))
    draw_rig_names(c, c.layout.ends_with("films"));
  else
    draw_names(c, !c.listed);
  if (c.layout.starts_with("DyNeRF"))
    write_rig(c);
  else if (c.layout.starts_with("COLMAP"))
    write_colmap(c);
  else if (c.layout == "Nerfies")
    write_nerfies(c);
  else if (c.layout == "LLFF" || c.layout == "NR-NeRF")
    write_rows(c);
  else
    write_transforms(c);
  add_clutter(c);
  return c;
}

}  // namespace splinevox::torture::structure
