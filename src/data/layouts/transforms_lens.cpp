// SPDX-License-Identifier: Apache-2.0
// Lenses as transforms files give them: fields of their own, or a 3 x 3 matrix.
#include <algorithm>
#include <cmath>

#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {

using nlohmann::json;

namespace {

/// Whether 'camera_model' (nerfstudio) or 'is_fisheye' (instant-ngp) says fisheye; nothing if neither is
/// there.
std::optional<bool> read_fisheye(const json& object, const std::string& where) {
  for (const char* other : {"latlong", "equirectangular", "ftheta_p0", "ftheta_p1"})
    if (const auto field = object.find(other);
        field != object.end() &&
        (field->is_boolean() ? field->get<bool>() : field->is_number() && *field != 0))
      fail({where, std::string("'") + other + "' is of a camera that is not supported",
            "a pinhole or fisheye lens", shown(*field), "cut the pictures into pinhole views first"});
  if (const auto flag = object.find("is_fisheye");
      flag != object.end() && flag->is_boolean() && flag->get<bool>())
    return true;
  const auto model = object.find("camera_model");
  if (model == object.end()) return {};
  for (const char* known :
       {"OPENCV_FISHEYE", "FISHEYE", "SIMPLE_FISHEYE", "RADIAL_FISHEYE", "SIMPLE_RADIAL_FISHEYE"})
    if (*model == known) return true;
  for (const char* known : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"})
    if (*model == known) return false;
  fail({where, "'camera_model' is not supported",
        "OPENCV, OPENCV_FISHEYE, FISHEYE, PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL or RADIAL", shown(*model),
        *model == "EQUIRECTANGULAR"
            ? "a picture of all directions is no camera's: cut it into pinhole views with poses of their own "
              "(ns-process-data images --camera-type equirectangular --images-per-equirect 8)"
            : "undistort the pictures first (colmap image_undistorter)"});
}

/// The numbers of a matrix, by rows: nested arrays, or one array.
std::vector<double> flat_numbers(const json& value) {
  if (value.is_number()) return {value.get<double>()};
  std::vector<double> numbers;
  if (value.is_array() && value.size() <= 16)
    for (const json& element : value)
      for (const double number : flat_numbers(element)) numbers.push_back(number);
  return numbers;
}

/// The lens in a matrix [fx, skew, cx; 0, fy, cy; 0, 0, 1] or a list of fx, fy, cx, cy.
void take_matrix(const json& value, const std::string& field, Lens& lens, const std::string& where) {
  const std::vector<double> n = flat_numbers(value);
  const auto all = [&](std::initializer_list<std::size_t> zeros) {
    return std::all_of(zeros.begin(), zeros.end(), [&](std::size_t i) { return n[i] == 0; });
  };
  const bool square = n.size() == 9 && all({3, 6, 7}) && n[8] == 1;
  if (!square && n.size() != 4)
    fail({where, "'" + field + "' is no matrix of a lens", "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
          shown(value), "give fl_x, fl_y, cx and cy"});
  const std::size_t fy = square ? 4 : 1, cx = 2, cy = square ? 5 : 3;
  if (square && std::abs(n[1]) > 1e-6 * std::abs(n[0]))
    fail({where, "'" + field + "' has skew", "0 in its first row", number(n[1]),
          "undistort the pictures first"});
  if (n[cx] <= 1 && n[cy] <= 1 && n[0] < 10)
    fail({where, "'" + field + "' is not in pixels", "the focal length and the centre in pixels",
          "fx " + number(n[0]) + ", centre " + number(n[cx]) + ", " + number(n[cy]),
          "multiply its first row by the picture's width, its second by the height"});
  lens.fl_x = n[0];
  lens.fl_y = n[fy];
  lens.cx = n[cx];
  lens.cy = n[cy];
}

}  // namespace

Lens read_lens(const json& object, const std::string& where) {
  const auto get = [&](const char* field) { return number_field(object, field, where); };
  Lens lens{get("camera_angle_x"),
            get("camera_angle_y"),
            get("fl_x"),
            get("fl_y"),
            get("cx"),
            get("cy"),
            get("w"),
            get("h"),
            get("k1"),
            get("k2"),
            get("k3"),
            get("k4"),
            get("p1"),
            get("p2"),
            read_fisheye(object, where)};
  if (const std::string field = lens_matrix_field(object); !lens.fl_x && !field.empty())
    take_matrix(object[field], field, lens, where);
  return lens;
}

std::string lens_matrix_field(const json& object) {
  for (const char* field : kLensMatrixFields)
    if (const auto found = object.find(field); found != object.end() && found->is_array()) return field;
  return {};
}

}  // namespace splinevox::data
