// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "data/layouts.hpp"
#include "splinevox/core/image.hpp"
#include "torture/draw.hpp"

/// Data sets whose truth is known, written in every layout with the structure of strangers' files: what the
/// loader makes of them is compared with the truth.
namespace splinevox::torture::structure {

/// One picture and what must be known of it. Its number is in its pixels.
struct Shot {
  int camera = 0, moment = 0;
  double time = 0;        ///< in the data's own unit
  test::TrueCamera seen;  ///< the lens for the picture as it is to be seen
  std::string path;       ///< within the set, with its ending
  std::string split;      ///< "train" or "test" where the data says so
  bool there = true;      ///< false: nothing in the set gives it both a picture and a camera
};

/// A data set.
struct Case {
  Case(std::uint64_t seed, std::uint64_t index) : draw(seed, index) {}
  Draw draw;
  std::string folder;
  std::string layout;
  std::vector<std::string> drawn;  ///< what was drawn, for the report
  std::vector<Shot> shots;
  int cameras = 1, moments = 1;
  bool still = false;      ///< whether cameras keep their places
  bool listed = false;     ///< whether the layout lists its pictures by paths
  bool broken = false;     ///< something in it may be refused
  int turn = 1;            ///< EXIF's orientation of the pictures
  bool as_stored = false;  ///< whether cameras are for pictures that are not turned
};

/// Cameras and moments, without names.
void draw_scene(Case& c);
/// Names for all pictures: shots' paths. @param flat  no folders.
void draw_names(Case& c, bool flat);
/// Names of the cameras' folders, and of pictures in them.
void draw_rig_names(Case& c, bool films);

/// Writers of one layout each, pictures included.
/// @{
void write_transforms(Case& c);  ///< D-NeRF, nerfstudio, NeRFlow
void write_colmap(Case& c);
void write_rows(Case& c);  ///< LLFF, NR-NeRF
void write_nerfies(Case& c);
void write_rig(Case& c);  ///< DyNeRF, folders and films
/// @}

/// The cameras are for the pictures as they are stored, not upright.
void take_as_stored(Case& c);
/// Which of the data's own splits each picture is in. The first and the last moment train.
void draw_splits(Case& c);
/// times.txt, or not.
void draw_times_file(Case& c);
/// Chooses so many of 0 .. n-1.
std::vector<std::size_t> some_of(Draw& draw, std::size_t count, std::size_t n);

/// Puts the picture of a shot where its path says, as a link to one that is made once.
void place_picture(const Case& c, std::size_t shot);
/// Whether there is an ffmpeg.
bool can_film();
/// A film of all moments of a camera. @param every  frames left out between two, from 1.
void place_film(const Case& c, int camera, const std::string& path, int every);
/// A picture that is no shot: a mask, a depth map.
void place_other(const Case& c, const std::string& path);
/// The shot that a decoded picture shows, or -1. @param upright  whether it is the right way up
int shot_in(const Picture& picture, bool& upright);
/// Removes the pictures that were made once.
void remove_pool();

/// What lies beside the pictures, and what is missing.
void add_clutter(Case& c);

enum class Outcome { right, right_noted, refused, asked, unneeded, wrong_noted, silent };
constexpr int kOutcomes = 7;
/// Loads the set and compares. @param words  what was found
Outcome check(const Case& c, std::string& words);

/// Writes case `index` into a folder that is empty.
Case make_case(std::uint64_t seed, std::uint64_t index, const std::string& folder);

}  // namespace splinevox::torture::structure
