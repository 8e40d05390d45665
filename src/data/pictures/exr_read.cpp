// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include "data/pictures/exr.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& what, const std::string& expected,
                         const std::string& got) {
  fail({.where = path, .what = what, .expected = expected, .got = got, .hint = {}});
}

/// The file's bytes, or its first.
std::vector<char> slurp(const std::string& path, std::size_t first = std::size_t(-1)) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) refuse(path, "cannot be read", "an OpenEXR file", error.message());
  if (size > 2 * kExrMaxBytes)
    refuse(path, "the file is too large", "at most 4 GiB", std::to_string(size) + " bytes");
  std::vector<char> bytes(std::min<std::size_t>(size, first));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), std::streamsize(bytes.size())))
    refuse(path, "cannot be read", "an OpenEXR file", std::strerror(errno));
  return bytes;
}

/// The few numbers of a header that decide how much memory the library will ask for.
struct HeaderFacts {
  std::int64_t width = 0, height = 0;
  std::size_t channels = 0;
  std::vector<std::string> names = {};          ///< of the channels
  std::array<std::int32_t, 4> data{}, shown{};  ///< both windows, x and y of their first and last pixel
};

/// Walks the attributes of the header within the bytes at hand; every length is checked against what is left.
class HeaderWalk {
 public:
  HeaderWalk(const std::string& path, const std::vector<char>& bytes) : path_(path), bytes_(bytes) {}

  HeaderFacts facts() {
    if (bytes_.size() < 8 || number(0) != 20000630)
      refuse(path_, "this is not an OpenEXR file", "the OpenEXR magic number", "something else");
    const std::uint32_t version = number(4);
    if ((version & 0xff) != 2 || (version & 0x1800) != 0)
      refuse(path_, "this kind of OpenEXR file is not supported", "version 2, one part, not deep",
             "version field " + std::to_string(version));
    at_ = 8;
    HeaderFacts facts;
    bool window = false, list = false;
    while (byte(at_) != 0) {
      const std::string_view name = text(), type = text();
      const std::size_t size = number(at_);
      at_ += 4;
      if (size > bytes_.size() - at_) truncated();
      if (name == "dataWindow" && type == "box2i" && size == 16) {
        window = true;
        for (int i = 0; i < 4; ++i) facts.data[std::size_t(i)] = corner(i);
        facts.width = std::int64_t(corner(2)) - corner(0) + 1;
        facts.height = std::int64_t(corner(3)) - corner(1) + 1;
      }
      if (name == "displayWindow" && type == "box2i" && size == 16)
        for (int i = 0; i < 4; ++i) facts.shown[std::size_t(i)] = corner(i);
      if (name == "channels" && type == "chlist") {
        list = true;
        facts.names = channel_names(size);
        facts.channels = facts.names.size();
      }
      if (type == "preview" && (size < 8 || 8 + 4 * std::uint64_t(number(at_)) * number(at_ + 4) != size))
        refuse(path_, "the header is damaged", "a preview picture as large as it says",
               std::to_string(size) + " bytes");
      at_ += size;
    }
    if (!window || !list)
      refuse(path_, "the header is damaged", "'dataWindow' and 'channels'", "not both there");
    return facts;
  }

 private:
  [[noreturn]] void truncated() const {
    refuse(path_, "the header is damaged or cut off", "a complete header",
           "an end after " + std::to_string(bytes_.size()) + " bytes");
  }
  char byte(std::size_t at) const {
    if (at >= bytes_.size()) truncated();
    return bytes_[at];
  }
  std::uint32_t number(std::size_t at) const {
    if (at + 4 > bytes_.size()) truncated();
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | std::uint8_t(bytes_[at + std::size_t(i)]);
    return value;
  }
  std::int32_t corner(int i) const { return std::int32_t(number(at_ + 4 * std::size_t(i))); }
  std::string_view text() {
    const std::size_t begin = at_;
    while (byte(at_) != 0) ++at_;
    return {bytes_.data() + begin, at_++ - begin};
  }
  /// Each entry of a channel list is a name, a zero and 16 bytes; a zero ends the list.
  std::vector<std::string> channel_names(std::size_t size) const {
    std::vector<std::string> names;
    const std::size_t end = at_ + size;
    for (std::size_t i = at_; i < end && bytes_[i] != 0; i += 17) {
      const std::size_t begin = i;
      while (i < end && bytes_[i] != 0) ++i;
      names.emplace_back(bytes_.data() + begin, i - begin);
    }
    return names;
  }

  const std::string& path_;
  const std::vector<char>& bytes_;
  std::size_t at_ = 0;
};

void require_sane(const std::string& path, const HeaderFacts& facts) {
  const auto side = [](std::int64_t v) { return v >= 1 && v <= kExrMaxSide; };
  const std::string got = std::to_string(facts.width) + "x" + std::to_string(facts.height) + ", " +
                          std::to_string(facts.channels) + " channels";
  if (!side(facts.width) || !side(facts.height) || facts.channels < 1 || facts.channels > kExrMaxChannels)
    refuse(path, "the picture's size is out of range",
           "sides of 1 to " + std::to_string(kExrMaxSide) + " pixels, 1 to " +
               std::to_string(kExrMaxChannels) + " channels",
           got);
  if (std::size_t(facts.width) * std::size_t(facts.height) * facts.channels * sizeof(float) > kExrMaxBytes)
    refuse(path, "the picture is too large", "at most 2 GiB of floats", got);
}

class MemoryIn : public Imf::IStream {
 public:
  MemoryIn(const std::string& path, const std::vector<char>& bytes)
      : Imf::IStream(path.c_str()), bytes_(bytes) {}
  bool read(char out[], int n) override {
    if (n < 0 || at_ > bytes_.size() || std::size_t(n) > bytes_.size() - at_)
      throw std::runtime_error("the file ends too early");
    std::memcpy(out, bytes_.data() + at_, std::size_t(n));
    at_ += std::size_t(n);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override { at_ = position; }

 private:
  const std::vector<char>& bytes_;
  std::size_t at_ = 0;
};

/// Position in the customary order, so that "R G B A" and "X Y Z" come as people write them.
std::pair<int, std::string> order(const std::string& letter) {
  static constexpr std::array<const char*, 7> kOrder{"R", "G", "B", "A", "X", "Y", "Z"};
  for (int i = 0; i < int(kOrder.size()); ++i)
    if (letter == kOrder[i]) return {i, letter};
  return {int(kOrder.size()), letter};
}

/// The file's layers, without pixels yet.
std::vector<ExrLayer> empty_layers(const Imf::ChannelList& list, const std::string& path) {
  std::vector<std::string> channels;
  for (auto it = list.begin(); it != list.end(); ++it) {
    channels.emplace_back(it.name());
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
      refuse(path, "channel '" + channels.back() + "' is subsampled", "one value per pixel",
             "every " + std::to_string(it.channel().xSampling) + " by " +
                 std::to_string(it.channel().ySampling));
  }
  std::vector<ExrLayer> layers;
  for (auto& [name, letters] : exr_layers(channels)) layers.push_back({name, {}, letters});
  return layers;
}

std::string channel_name(const ExrLayer& layer, const std::string& letter) {
  return letter.empty() ? layer.name : layer.name.empty() ? letter : layer.name + "." + letter;
}

}  // namespace

std::map<std::string, std::vector<std::string>> exr_layers(const std::vector<std::string>& channels) {
  std::map<std::string, std::vector<std::string>> layers;
  for (const std::string& channel : channels) {
    const std::size_t dot = channel.rfind('.');
    if (dot != std::string::npos)
      layers[channel.substr(0, dot)].push_back(channel.substr(dot + 1));
    else if (order(channel).first < 7)
      layers[""].push_back(channel);
    else
      layers[channel].push_back("");
  }
  for (auto& [name, letters] : layers)
    std::sort(letters.begin(), letters.end(),
              [](const auto& a, const auto& b) { return order(a) < order(b); });
  return layers;
}

ExrHeader read_exr_header(const std::string& path) {
  constexpr std::size_t kHeaderBytes = 1u << 20;
  const std::vector<char> bytes = slurp(path, kHeaderBytes);
  const HeaderFacts facts = HeaderWalk(path, bytes).facts();
  require_sane(path, facts);
  return {int(facts.width), int(facts.height), facts.data == facts.shown, facts.names};
}

std::vector<ExrLayer> read_exr_layers(const std::string& path,
                                      const std::function<void(std::vector<ExrLayer>&)>& choose) {
  const std::vector<char> bytes = slurp(path);
  const HeaderFacts facts = HeaderWalk(path, bytes).facts();
  require_sane(path, facts);
  try {
    MemoryIn memory(path, bytes);
    Imf::InputFile file(memory, 0);
    const Imath::Box2i window = file.header().dataWindow();
    const int width = int(facts.width), height = int(facts.height);
    std::vector<ExrLayer> layers = empty_layers(file.header().channels(), path);
    if (choose) choose(layers);
    Imf::FrameBuffer frame;
    for (ExrLayer& layer : layers) {
      layer.image = Image(width, height, int(layer.channels.size()));
      const std::size_t step = layer.channels.size() * sizeof(float);
      for (std::size_t c = 0; c < layer.channels.size(); ++c)
        frame.insert(channel_name(layer, layer.channels[c]),
                     Imf::Slice::Make(Imf::FLOAT, layer.image.data.data() + c, window, step,
                                      step * std::size_t(width)));
    }
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    return layers;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    refuse(path, "the file is damaged or cut off", "a complete OpenEXR file", error.what());
  }
}

const ExrLayer& find_exr_layer(const std::vector<ExrLayer>& layers, const std::string& name,
                               const std::string& path) {
  std::string known;
  for (const ExrLayer& layer : layers) {
    if (layer.name == name) return layer;
    known += (known.empty() ? "" : ", ") + (layer.name.empty() ? std::string("(unnamed)") : layer.name);
  }
  refuse(path, "there is no layer '" + name + "'", "'" + name + "'", known);
}

}  // namespace splinevox
