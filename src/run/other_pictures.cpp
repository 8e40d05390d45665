// SPDX-License-Identifier: Apache-2.0
#include "run/other_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <vector>

#include "core/printable.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/pictures/decode.hpp"
#include "data/pictures/picture_header.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

std::vector<std::string> pictures_in(const std::string& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    fail({folder, "there is no such folder", "a folder of pictures, one of each frame", "", ""});
  std::vector<std::string> names = data::files_in(folder);
  std::erase_if(names, [](const std::string& name) {
    return name[0] == '.' || data::kind_of(name) != data::FileKind::picture;
  });
  if (names.empty())
    fail({folder, "there are no pictures in this folder", "PNG, JPEG, OpenEXR or TIFF", "", ""});
  return names;
}

std::vector<std::string> frame_list(const Split& split) {
  std::vector<std::string> names;
  for (const Frame& frame : split.frames) names.push_back(frame.name);
  return names;
}

/// Of each frame its file, by name.
std::vector<std::string> by_name(const std::string& folder, const std::vector<std::string>& files,
                                 const Split& split) {
  const bool as_many = files.size() == split.frames.size();
  const std::string expected =
                        "one picture of each frame, called as the frame is: " + frame_list(split)[0] + ".png",
                    hint = as_many ? "--match order, if they are in the order of the frames" : "";
  std::map<std::string, std::string> left;
  for (const std::string& file : files)
    if (const auto [at, fresh] = left.emplace(fs::path(file).stem().string(), file); !fresh)
      fail({folder, "two pictures are of one frame", "one of each", data::list_of({at->second, file}), ""});
  std::vector<std::string> found, missing, surplus;
  for (const Frame& frame : split.frames) {
    const auto at = left.find(frame.name);
    if (at == left.end()) {
      missing.push_back(frame.name);
      continue;
    }
    found.push_back(at->second);
    left.erase(at);
  }
  for (const auto& [stem, file] : left) surplus.push_back(file);
  if (!missing.empty())
    fail({folder, fmt::format("{} of {} frames have no picture", missing.size(), split.frames.size()),
          expected,
          "none for " + data::list_of(missing) +
              (surplus.empty() ? "" : "; of no frame: " + data::list_of(surplus)),
          hint});
  if (!surplus.empty())
    fail({folder, fmt::format("{} of {} pictures are of no frame", surplus.size(), files.size()), expected,
          data::list_of(surplus), "take them out, or another --split"});
  return found;
}

std::vector<std::string> by_order(const std::string& folder, std::vector<std::string> files,
                                  const Split& split) {
  if (files.size() != split.frames.size())
    fail({folder, "there are not as many pictures as frames",
          fmt::format("{}, one of each frame of the {} split", split.frames.size(), split.name),
          fmt::format("{}: {}", files.size(), data::list_of(files)), ""});
  return files;
}

}  // namespace

OtherPictures::OtherPictures(const std::string& folder, const Split& split, MatchBy by,
                             const std::string& transfer) {
  const std::vector<std::string> files = pictures_in(folder);
  for (const std::string& file :
       by == MatchBy::name ? by_name(folder, files, split) : by_order(folder, files, split)) {
    const Picture& truth = split.frames[plan_.paths.size()].image;
    plan_.paths.push_back(fs::path(folder) / file);
    plan_.where.push_back(printable(plan_.paths.back().string()));
    const data::PictureHeader header = data::read_picture_header(plan_.paths.back(), plan_.where.back());
    const PictureSize wanted{truth.width, truth.height};
    if (header.size != wanted)
      fail({plan_.where.back(), "this picture is not of the size of its frame",
            fmt::format("{}, as {} has", data::size_text(wanted), split.frames[plan_.paths.size() - 1].name),
            data::size_text(header.size), "--downscale K, if it was made of smaller pictures"});
    plan_.turns.push_back(1);
    const bool floats = header.real || header.linear;
    plan_.linear.push_back(floats && (transfer.empty() || transfer == "linear"));
  }
}

Image OtherPictures::read(std::size_t frame, const Vec3& background) const {
  return composite(data::decode_one(plan_, frame).picture, background);
}

}  // namespace splinevox::run
