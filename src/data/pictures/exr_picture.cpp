// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "data/pictures/exr.hpp"
#include "data/pictures/premultiply.hpp"
#include "data/pictures/real_read.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

using Letters = std::set<std::string>;

bool has_rgb(const Letters& letters) {
  return letters.contains("R") && letters.contains("G") && letters.contains("B");
}

/// Y beside X is no brightness but a direction or a place. Z alone beside it is depth.
bool has_colours(const Letters& letters) {
  return has_rgb(letters) || (letters.contains("Y") && !letters.contains("X"));
}

/// The layer to read.
std::string choose_layer(const std::map<std::string, Letters>& layers, const std::string& asked,
                         const std::string& where) {
  std::vector<std::string> good, combined;
  std::string known;
  for (const auto& [name, letters] : layers) {
    if (!has_colours(letters)) continue;
    if (name == asked) return name;
    good.push_back(name);
    if (name.ends_with("Combined")) combined.push_back(name);
    known += (known.empty() ? "" : ", ") + name;
  }
  if (!asked.empty())
    fail({where, "there is no layer of colours named '" + asked + "'", "--layer with one that is there",
          known.empty() ? "none" : known, ""});
  if (good.empty())
    fail({where, "the OpenEXR file holds no colours", "channels R, G and B, or Y", "none of them", ""});
  if (good.size() == 1) return good[0];
  if (combined.size() == 1) return combined[0];
  fail({where, "several layers hold colours", "one of them, by --layer NAME", known, ""});
}

}  // namespace

PictureHeader exr_picture_header(const std::filesystem::path& path, const std::string& where,
                                 const std::string& layer) {
  const ExrHeader header = called(where, nullptr, [&] { return read_exr_header(path.string()); });
  std::map<std::string, Letters> layers;
  for (const auto& [name, letters] : exr_layers(header.channels))
    layers[name] = Letters(letters.begin(), letters.end());
  const Letters& letters = layers.at(choose_layer(layers, layer, where));
  if (!header.whole)
    fail({where, "the picture is cut out of its display window, or larger",
          "pixels of the whole display window", "another data window",
          "oiiotool a.exr --fullpixels -o b.exr, or --crop to the display window"});
  PictureHeader out;
  out.size = {header.width, header.height};
  out.alpha = letters.contains("A");
  out.deep = out.real = out.linear = true;
  return out;
}

Image read_exr_picture(const std::filesystem::path& path, const std::string& where,
                       const std::string& layer) {
  return called(where, nullptr, [&] {
    const std::vector<ExrLayer> read = read_exr_layers(path.string(), [&](std::vector<ExrLayer>& all) {
      std::map<std::string, Letters> layers;
      for (const ExrLayer& l : all) layers[l.name] = Letters(l.channels.begin(), l.channels.end());
      const std::string chosen = choose_layer(layers, layer, where);
      std::erase_if(all, [&](const ExrLayer& l) { return l.name != chosen; });
    });
    const ExrLayer& from = read.at(0);
    const auto place = [&](const char* letter) {
      return int(std::find(from.channels.begin(), from.channels.end(), letter) - from.channels.begin());
    };
    const int count = from.image.channels;
    const bool grey = !has_rgb(Letters(from.channels.begin(), from.channels.end()));
    const int colours[3] = {place(grey ? "Y" : "R"), place(grey ? "Y" : "G"), place(grey ? "Y" : "B")};
    const int alpha = place("A");
    Image out(from.image.width, from.image.height, 4);
    for (std::size_t i = 0; i < out.pixels(); ++i) {
      const float* stored = from.image.data.data() + i * std::size_t(count);
      for (std::size_t c = 0; c < 3; ++c) out.data[4 * i + c] = stored[colours[c]];
      out.data[4 * i + 3] = alpha < count ? stored[alpha] : 1;
    }
    divide_by_alpha(out);
    return out;
  });
}

}  // namespace splinevox::data
