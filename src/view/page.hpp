// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "run/first_sight.hpp"
#include "run/true_shots.hpp"
#include "view/pack.hpp"
#include "view/taken_from.hpp"

namespace splinevox::run {

struct ViewPage {
  std::string name;                     ///< of the run
  std::string about;                    ///< a line beside it: data set, quality
  std::string model = {};               ///< what tells model.vdb from others, see model_mark
  std::string note;                     ///< what the page says about its contents
  double full_flow = 0.1;               ///< displacement of full colour, scene units
  std::string split;                    ///< whose pictures the shots are
  std::vector<TrueShot> shots;          ///< in the order of time
  std::optional<TakenFrom> taken = {};  ///< absent: one may go anywhere
  std::optional<FirstSight> start = {};
};

/// True pictures for a page. They stay clear where they are, unless the model learned what is behind.
std::vector<TrueShot> page_shots(const Split& split, const VoxelModel& model, int count, int size);

/// The whole page: no network, opens from disk.
std::string view_page(const ViewPage& page, const PackedScene& scene);

/// What the viewer is told of a page: all but the model's bytes (docs/formats.md, "The page of view").
Json view_header(const ViewPage& page, const PackedScene& scene);

/// The viewer in a page, and what else is on it. HTML but for the names.
struct ViewerParts {
  std::string title;              ///< text; the heading too
  std::string about;              ///< text
  std::string model = {};         ///< text
  std::vector<char> poster = {};  ///< PNG file that is shown until there is a picture; empty: none
  std::string style = {};         ///< behind the viewer's own
  std::string beside = {};        ///< elements behind the panel
  std::string data = {};          ///< elements behind the shaders
  std::string scripts = {};       ///< behind the viewer's own: what makes its App
  std::string body_class = {};    ///< of the body, besides its own
};
std::string viewer_page(const ViewerParts& parts);

/// A file of src/view/assets, as it was when the program was built. @pre it is there.
std::string_view view_asset(std::string_view name);

}  // namespace splinevox::run
