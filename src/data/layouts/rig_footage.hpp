// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// What a camera of a rig took.
struct Footage {
  std::string camera;                 ///< the folder's name, or the film's without ending
  std::string film;                   ///< its path in the data set; empty: pictures
  std::vector<std::string> pictures;  ///< paths in the data set, in the order in which people count
};

/// What cameras' pictures are called, without their folders and sorted by characters, if most names are used
/// by several cameras; else empty.
std::vector<std::string> shared_names(const std::vector<Footage>& footage);

/// Whether a folder of pictures is no camera's but what other layouts and programs leave.
bool is_no_camera(const std::string& name);

/// The pictures of a camera's folder, as paths in the data set: in itself or in its images. Masks among them
/// are left out.
std::vector<std::string> pictures_of_camera(const std::filesystem::path& folder,
                                            const std::filesystem::path& camera);

/// A frame per picture of a film. Times are its time stamps, in frames of `rate` a second.
/// @param camera  pose, lens and name  @param rate  0: becomes this film's own
/// @param notes   gets what is odd about it, of films of one kind once
/// @return how many pictures the film has. Throws Error (Fault::input).
int add_film(const std::filesystem::path& folder, const RawFrame& camera, const std::string& film,
             double& rate, std::vector<RawFrame>& frames, std::vector<std::string>& notes);

/// A frame per picture of a folder; their times are not known yet.
void add_pictures(const RawFrame& camera, const std::vector<std::string>& pictures,
                  std::vector<RawFrame>& frames);

/// Films that begin at the same time and are not of one length: a note; empty if they are.
std::string note_on_lengths(int fewest, int most);

/// All cameras' pictures of one kind and at one place in the data set (folders in it, in images ..., films in
/// videos ...): those at the place that has most of the named cameras, folders before films. None if no place
/// has two of them.
/// @param cameras  names of those that have a pose
/// @param least    pictures that a folder must have to be a camera's: a pose's own picture lies in one, too
std::vector<Footage> find_footage(const std::filesystem::path& folder,
                                  const std::vector<std::string>& cameras, std::size_t least = 1);

/// Every frame of `scene` is a camera that stands still, and has its name: it becomes one frame for every
/// picture that the camera took, with its mask where there is one (mask/NAME/0007.png, masks, seg, schp ...).
/// Where cameras give their pictures the same names, every camera is asked for all of them, so that a missing
/// one is counted.
///
/// A camera without pictures, and pictures without a camera, become frames with a fault, for leave_out. Films
/// that differ in length by more than a tenth are refused, and so are different numbers of pictures with
/// names of their own. Throws Error (Fault::input).
void take_footage(const std::filesystem::path& folder, const std::vector<Footage>& footage, RawScene& scene);

}  // namespace splinevox::data
