// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "view/pack.hpp"
#include "view/taken_from.hpp"

namespace splinevox::run {

/// A true picture and where it was taken from.
struct ViewShot {
  std::string name;
  Camera camera;          ///< of the picture as it is in the page
  double time = 0;        ///< the model's, in [0, 1]
  std::vector<char> png;  ///< the truth over the run's background
};

struct ViewPage {
  std::string name;                     ///< of the run
  std::string about;                    ///< a line beside it: data set, quality
  std::string note;                     ///< what the page says about its contents
  double full_flow = 0.1;               ///< displacement of full colour, scene units
  std::vector<ViewShot> shots;          ///< in the order of time
  std::optional<TakenFrom> taken = {};  ///< absent: one may go anywhere
};

/// The whole page: no network, opens from disk.
std::string view_page(const ViewPage& page, const PackedScene& scene);

/// A file of src/view/assets, as it was when the program was built. @pre it is there.
std::string_view view_asset(std::string_view name);

}  // namespace splinevox::run
