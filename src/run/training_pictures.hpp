// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/data/scene.hpp"

/// Which pictures a run was trained on: kTrainingPictures in its folder. A data set that names no splits is
/// divided anew whenever it is read, and a picture that is missing then moves others to another split.
namespace splinevox::run {

/// The text of that file: Frame::source of each picture, a line each.
std::string training_pictures_text(const Split& train);

/// To be called with a split other than train, before it is measured as held out. Where it has pictures that
/// the run was trained on, `data` gets a note if the data set's own lists have them for both; otherwise
/// throws Error (input). Runs without the file, of older versions, pass with a note.
/// @param run  its folder. @param load  how `data` was read: one split
void check_held_out(const std::string& run, const LoadOptions& load, Dataset& data);

}  // namespace splinevox::run
