// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace splinevox::fuzz {

std::vector<std::string> dataset_seeds();
std::vector<std::string> png_seeds();
std::vector<std::string> jpeg_seeds();
std::vector<std::string> exr_seeds();
std::vector<std::string> model_seeds();
std::vector<std::string> checkpoint_seeds();
std::vector<std::string> state_seeds();
std::vector<std::string> manifest_seeds();
std::vector<std::string> config_seeds();
std::vector<std::string> camera_seeds();
std::vector<std::string> points_seeds();
std::vector<std::string> splat_seeds();

}  // namespace splinevox::fuzz
