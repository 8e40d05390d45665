// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfFramesPerSecond.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfRational.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>

#include "core/half.hpp"
#include "data/pictures/encode.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

/// OpenEXR output into memory, so that only write_file ever meets a disk.
class MemoryOut : public Imf::OStream {
 public:
  MemoryOut() : Imf::OStream("memory") {}
  void write(const char bytes[], int n) override {
    if (at_ + std::size_t(n) > data.size()) data.resize(at_ + std::size_t(n));
    std::memcpy(data.data() + at_, bytes, std::size_t(n));
    at_ += std::size_t(n);
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }
  std::vector<char> data;

 private:
  std::size_t at_ = 0;
};

std::vector<std::string> channel_names(const ExrLayer& layer) {
  std::vector<std::string> letters = layer.channels;
  if (letters.empty() && layer.image.channels > 1)
    for (const char* letter : {"R", "G", "B", "A"}) letters.push_back(letter);
  if (letters.empty()) letters.push_back("");
  if (layer.channels.empty() && layer.image.channels <= int(letters.size()))
    letters.resize(std::size_t(std::max(layer.image.channels, 0)));
  for (std::string& letter : letters)
    letter = letter.empty() ? layer.name : layer.name.empty() ? letter : layer.name + "." + letter;
  return letters;
}

void require_layers(const std::string& where, const std::vector<ExrLayer>& layers) {
  std::set<std::string> seen;
  const auto refuse = [&](const std::string& layer, const std::string& expected, const std::string& got) {
    fail_output({.where = where + ", layer '" + layer + "'",
                 .what = "these layers cannot be stored as OpenEXR",
                 .expected = expected,
                 .got = got,
                 .hint = {}});
  };
  if (layers.empty()) refuse("", "at least one layer", "none");
  const Image& first = layers.front().image;
  for (const ExrLayer& layer : layers) {
    const Image& image = layer.image;
    const std::string shape = std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
                              std::to_string(image.channels) + " channels";
    if (image.width < 1 || image.height < 1 || image.width > kExrMaxSide || image.height > kExrMaxSide ||
        image.data.size() != image.pixels() * std::size_t(std::max(image.channels, 0)))
      refuse(layer.name, "sides of 1 to " + std::to_string(kExrMaxSide) + " pixels", shape);
    if (image.width != first.width || image.height != first.height)
      refuse(
          layer.name,
          "the size of the first layer, " + std::to_string(first.width) + "x" + std::to_string(first.height),
          shape);
    const std::vector<std::string> names = channel_names(layer);
    if (int(names.size()) != image.channels)
      refuse(layer.name, "one channel name per channel", std::to_string(names.size()) + " names, " + shape);
    for (const std::string& name : names)
      if (name.empty() || !seen.insert(name).second)
        refuse(layer.name, "distinct channel names", "'" + name + "'");
  }
}

std::vector<half> as_half(const Image& image) {
  std::vector<half> out;
  out.reserve(image.data.size());
  for (const float v : image.data) out.emplace_back(std::clamp(v, -kLargestHalf, kLargestHalf));
  return out;
}

/// From the world to x right, y up, z into the picture, of row vectors.
Imath::M44f world_to_camera(const Camera& camera) {
  const Vec3d axes[3] = {camera.axes[0], camera.axes[1], -1.0 * camera.axes[2]};
  Imath::M44f m;
  for (int k = 0; k < 3; ++k) {
    for (int a = 0; a < 3; ++a) m[a][k] = float(axes[k][a]);
    m[3][k] = float(-dot(camera.position, axes[k]));
  }
  return m;
}

/// From there to the picture, 0 to 1 from its upper left; z from 0 to 1 between planes that are near and far.
Imath::M44f camera_to_picture(const Camera& camera) {
  constexpr double kNear = 0.01, kFar = 10000;
  Imath::M44f m(0.0f);
  m[0][0] = float(camera.fx / camera.width);
  m[1][1] = float(-camera.fy / camera.height);
  m[2][0] = float(camera.cx / camera.width);
  m[2][1] = float(camera.cy / camera.height);
  m[2][2] = float(kFar / (kFar - kNear));
  m[2][3] = 1;
  m[3][2] = float(-kFar * kNear / (kFar - kNear));
  return m;
}

void add_notes(Imf::Header& header, const ExrNotes& notes) {
  if (notes.camera) {
    const Imath::M44f to_camera = world_to_camera(*notes.camera);
    Imf::addWorldToCamera(header, to_camera);
    Imf::addWorldToNDC(header, to_camera * camera_to_picture(*notes.camera));
  }
  if (notes.fps > 0) Imf::addFramesPerSecond(header, Imf::guessExactFps(notes.fps));
  if (notes.frame) header.insert("imageCounter", Imf::IntAttribute(*notes.frame));
  if (notes.time) header.insert("modelTime", Imf::FloatAttribute(float(*notes.time)));
  for (const auto& [name, text] : notes.texts) header.insert(name, Imf::StringAttribute(text));
  if (notes.color_space.empty()) return;
  header.insert("colorInteropID", Imf::StringAttribute(notes.color_space));
  Imf::addChromaticities(header, Imf::Chromaticities());
}

}  // namespace

std::vector<char> encode_exr_for(const std::string& where, const std::vector<ExrLayer>& layers,
                                 const ExrNotes& notes) {
  require_layers(where, layers);
  const int width = layers.front().image.width, height = layers.front().image.height;
  try {
    Imf::Header header(width, height);
    header.compression() = Imf::ZIP_COMPRESSION;
    add_notes(header, notes);
    Imf::FrameBuffer frame;
    std::vector<std::vector<half>> halves;
    for (const ExrLayer& layer : layers) {
      const std::vector<std::string> names = channel_names(layer);
      halves.push_back(layer.half ? as_half(layer.image) : std::vector<half>());
      const Imf::PixelType type = layer.half ? Imf::HALF : Imf::FLOAT;
      const std::size_t bytes = layer.half ? sizeof(half) : sizeof(float);
      const char* first = layer.half ? reinterpret_cast<const char*>(halves.back().data())
                                     : reinterpret_cast<const char*>(layer.image.data.data());
      const std::size_t step = std::size_t(layer.image.channels) * bytes;
      for (std::size_t c = 0; c < names.size(); ++c) {
        header.channels().insert(names[c], Imf::Channel(type));
        frame.insert(names[c],
                     Imf::Slice(type, const_cast<char*>(first + c * bytes), step, step * std::size_t(width)));
      }
    }
    MemoryOut memory;
    {
      Imf::OutputFile file(memory, header, 0);
      file.setFrameBuffer(frame);
      file.writePixels(height);
    }
    return std::move(memory.data);
  } catch (const std::exception& error) {
    fail_output(
        {.where = where, .what = "OpenEXR encoding failed", .expected = {}, .got = error.what(), .hint = {}});
  }
}

}  // namespace splinevox
