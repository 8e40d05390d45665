// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/film_read.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "core/child.hpp"
#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

/// A call of ffmpeg's programs on a stranger's file: containers that hold their film themselves, no network.
/// A playlist in place of a film could name any file of the machine.
ChildWords words_of(const char* program, std::vector<std::string> arguments, const std::string& where) {
  std::vector<std::string> words{program,
                                 "-v",
                                 "error",
                                 "-protocol_whitelist",
                                 "file",
                                 "-format_whitelist",
                                 "mov,matroska,avi,mpegts,mpeg,h264,hevc,ivf,ogg,flv,asf,mxf,m4v,mpegvideo"};
  words.insert(words.end(), std::make_move_iterator(arguments.begin()),
               std::make_move_iterator(arguments.end()));
  return {std::move(words), where, "films are read with it", "apt-get install ffmpeg"};
}

/// What ffprobe prints of a film's stream and its packets.
struct ProbeText {
  int width = 0, height = 0;
  int rotation = 0;  ///< degrees, anticlockwise
  std::string transfer;
  double pixel_aspect = 1;
  bool interlaced = false;
  std::vector<double> stamps;       ///< of packets that are shown; seconds
  std::optional<double> first_key;  ///< of the first picture that needs no other, shown or not
  std::size_t without = 0;          ///< packets that are shown and have no time stamp
};

/// Lines such as "packet|pts_time=0.033333|flags=K__" and "stream|width=64|height=48|side_data|rotation=-90".
/// Side data may stand on a line of its own. Newer programs call it "side_datum/display_matrix:rotation=-90".
void read_line(std::string_view line, ProbeText& text) {
  const auto value_of = [&](std::string_view key) -> std::string_view {
    const std::size_t at = line.find(key);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = line.substr(at + key.size());
    return rest.substr(0, rest.find('|'));
  };
  const auto number_of = [&](std::string_view key, auto& value) {
    const std::string_view digits = value_of(key);
    return std::from_chars(digits.data(), digits.data() + digits.size(), value).ec == std::errc();
  };
  if (line.starts_with("stream|")) {
    number_of("|width=", text.width);
    number_of("|height=", text.height);
    text.transfer = value_of("|color_transfer=");
    double across = 0, down = 0;  // "4:3"; "0:1" or "N/A" where nobody says it
    const std::string_view aspect = value_of("|sample_aspect_ratio=");
    const std::size_t colon = std::min(aspect.find(':'), aspect.size());
    std::from_chars(aspect.data(), aspect.data() + colon, across);
    if (colon < aspect.size())
      std::from_chars(aspect.data() + colon + 1, aspect.data() + aspect.size(), down);
    if (across > 0 && down > 0) text.pixel_aspect = across / down;
    const std::string_view order = value_of("|field_order=");
    text.interlaced = order == "tt" || order == "bb" || order == "tb" || order == "bt";
  }
  if (!line.starts_with("packet|")) {
    for (const char* key : {"|rotation=", ":rotation="}) number_of(key, text.rotation);
    return;
  }
  const std::string_view flags = value_of("|flags=");
  const bool hidden = flags.find('D') != flags.npos;  // decoded for others, never shown
  double stamp = 0;
  if (!number_of("|pts_time=", stamp)) {
    text.without += !hidden;
    return;
  }
  if (!text.first_key && flags.find('K') != flags.npos) text.first_key = stamp;
  if (!hidden) text.stamps.push_back(stamp);
}

/// Seconds from the first frame on, put onto an even rate where they lie close to one.
std::vector<double> even_times(std::vector<double> stamps) {
  constexpr double kOff = 0.05;  // of a frame
  std::sort(stamps.begin(), stamps.end());
  const double first = stamps.front();
  for (double& s : stamps) s -= first;
  if (stamps.size() < 2) return stamps;
  std::vector<double> gaps;
  for (std::size_t i = 1; i < stamps.size(); ++i) gaps.push_back(stamps[i] - stamps[i - 1]);
  std::nth_element(gaps.begin(), gaps.begin() + std::ptrdiff_t(gaps.size() / 2), gaps.end());
  double gap = gaps[gaps.size() / 2];
  if (!(gap > 0)) return stamps;
  gap = stamps.back() / std::max(1.0, std::round(stamps.back() / gap));  // over all of the film it is finer
  const double rate = std::round(1000 / gap) / 1000;
  if (std::abs(rate * stamps.back() - std::round(stamps.back() / gap)) < kOff) gap = 1 / rate;
  const auto even = [&](double s) { return std::abs(s / gap - std::round(s / gap)) < kOff; };
  if (!std::all_of(stamps.begin(), stamps.end(), even)) return stamps;
  for (double& s : stamps) s = std::round(s / gap) * gap;
  return stamps;
}

/// FilmFacts::rotation. At other angles than quarters ffmpeg keeps the picture's size: they count as none.
int clockwise(int anticlockwise) {
  const int degrees = (360 - anticlockwise % 360) % 360;
  return degrees % 90 == 0 ? degrees : 0;
}

/// How a film is to be decoded.
struct FilmOrder {
  const std::filesystem::path& path;
  PictureSize size;      ///< of the frames that ffmpeg gives out
  bool upright;          ///< turned as a player turns them, else as stored
  std::string filters;   ///< for ffmpeg; may be empty
  int frames;            ///< that must be there
  std::string if_short;  ///< what to do where they are not
};

ChildWords ffmpeg_words(const FilmOrder& film, const std::vector<std::string>& output,
                        const std::string& where) {
  std::vector<std::string> words;
  if (!film.upright) words.emplace_back("-noautorotate");
  words.insert(words.end(), {"-i", "file:" + film.path.string(), "-map", "0:v:0"});
  if (!film.filters.empty()) words.insert(words.end(), {"-vf", film.filters});
  words.insert(words.end(), {"-pix_fmt", "rgb24", "-fps_mode", "passthrough"});
  words.insert(words.end(), output.begin(), output.end());
  return words_of("ffmpeg", std::move(words), where);
}

/// The last lines that ffmpeg prints of a film of which it gives out no frame; empty if there are none.
std::string complaint(const FilmOrder& film, const std::string& where) {
  constexpr std::size_t kLines = 3;
  constexpr std::chrono::seconds kPatience{10};
  ChildWords words = ffmpeg_words(film, {"-frames:v", "1", "-f", "null", "-"}, where);
  words.errors = true;
  Child ffmpeg(words);
  const auto end = std::chrono::steady_clock::now() + kPatience;
  std::vector<std::string> lines;
  for (std::string line; ffmpeg.read_line(line, [&] { return std::chrono::steady_clock::now() > end; });) {
    if (!line.empty()) lines.push_back(printable(line));
    if (lines.size() > kLines) lines.erase(lines.begin());
  }
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "; ") + line;
  return text;
}

/// Hands over the frames from the first on, [height * width * 3], until `take` wants no more.
void each_frame(const FilmOrder& film, const std::function<bool(int, std::span<const std::uint8_t>)>& take,
                const std::string& where) {
  Child ffmpeg(ffmpeg_words(film, {"-f", "rawvideo", "-"}, where));
  std::vector<std::uint8_t> rgb(std::size_t(film.size.width) * std::size_t(film.size.height) * 3);
  for (int i = 0;; ++i) {
    if (!ffmpeg.read(reinterpret_cast<char*>(rgb.data()), rgb.size())) {
      const bool refused = !ffmpeg.finish() && i == 0;
      if (const std::string said = refused ? complaint(film, where) : ""; !said.empty())
        fail({where, "ffmpeg cannot decode the film", "ffmpeg 5.1 or later, and a whole film", said,
              "ffmpeg -version says which one there is; else copy the file again"});
      fail({where, "the film ends early", std::to_string(film.frames) + " frames",
            std::to_string(i) + " that ffmpeg could decode", film.if_short});
    }
    if (!take(i, rgb)) return;
  }
}

}  // namespace

FilmFacts film_facts(const std::filesystem::path& path, const std::string& where) {
  constexpr std::size_t kMostFrames = 10'000'000, kLongestLine = 10'000;
  read_bytes(path, where, UINTMAX_MAX, 64);  // there is such a file, and it is no pointer of Git LFS
  // AVI and MPEG streams keep the time stamps of some pictures alone.
  Child probe(words_of("ffprobe",
                       {"-fflags", "+genpts", "-select_streams", "v:0", "-show_entries",
                        "stream=width,height,sample_aspect_ratio,field_order,color_transfer:"
                        "stream_side_data=rotation:packet=pts_time,flags",
                        "-of", "compact", "file:" + path.string()},
                       where));
  ProbeText text;
  std::string line;
  for (char c; probe.read(&c, 1) && text.stamps.size() < kMostFrames;) {
    if (c != '\n') {
      if (line.size() < kLongestLine) line += c;
      continue;
    }
    read_line(line, text);
    line.clear();
  }
  const bool ended_well = probe.finish();
  // A film that was cut without encoding it anew may begin with pictures that need others which are gone.
  if (text.first_key) std::erase_if(text.stamps, [&](double s) { return s < *text.first_key; });
  if (text.stamps.empty())  // raw streams have no time stamps: their frames follow each other evenly
    for (std::size_t i = 0; i < text.without; ++i) text.stamps.push_back(double(i));
  if (!ended_well || text.width < 1 || text.height < 1 || text.stamps.empty())
    fail({where, "this is no film that ffprobe can read", "a video stream with at least one frame", "none",
          "copy the file again"});
  if (text.width > 65536 || text.height > 65536 || double(text.width) * text.height > double(1 << 28))
    fail({where, "the film's size is out of range", "1 to 65536 pixels a side and at most 2^28 in all",
          std::to_string(text.width) + " x " + std::to_string(text.height), ""});
  std::vector<double> times = even_times(std::move(text.stamps));
  const double rate = times.back() > 0 ? double(times.size() - 1) / times.back() : 1;
  return {text.width,    text.height,       rate,           std::move(times), clockwise(text.rotation),
          text.transfer, text.pixel_aspect, text.interlaced};
}

std::vector<std::string> oddities_of(const FilmFacts& film) {
  std::vector<std::string> out;
  if (film.interlaced)
    out.push_back(
        "an interlaced film: each picture holds two moments, in every other row. For one each: "
        "ffmpeg -i FILM -vf bwdif -c:v libx264 -crf 16 NEW.mp4");
  if (film.transfer == "smpte2084" || film.transfer == "arib-std-b67")
    out.push_back(std::string("an HDR film (") + (film.transfer == "smpte2084" ? "PQ" : "HLG") +
                  "); its values are taken as they are, and look pale. For the colours of a screen: "
                  "ffmpeg -i FILM -vf zscale=t=linear:npl=100,tonemap=hable,zscale=p=bt709:t=bt709:m=bt709,"
                  "format=yuv420p SDR.mp4");
  return out;
}

void read_film(const std::filesystem::path& path, const PictureSize& size, bool upright,
               const std::vector<int>& wanted, const std::function<void(std::size_t, Image16&&)>& take,
               const std::string& where) {
  if (wanted.empty()) return;
  std::size_t next = 0;
  const auto pick = [&](int i, std::span<const std::uint8_t> rgb) {
    if (i != wanted[next]) return true;
    Image16 image{size.width, size.height, {}};
    image.rgba.resize(image.pixels() * 4, 65535);
    for (std::size_t p = 0; p < image.pixels(); ++p)
      for (std::size_t c = 0; c < 3; ++c) image.rgba[4 * p + c] = std::uint16_t(257 * rgb[3 * p + c]);
    take(next++, std::move(image));
    return next < wanted.size();
  };
  each_frame({path, size, upright, "", wanted.back() + 1,
              "copy the file again, or encode it anew: ffmpeg -i FILM -c:v libx264 -crf 16 NEW.mp4"},
             pick, where);
}

void read_film_scaled(const std::filesystem::path& path, const PictureSize& size, int frames,
                      const std::function<bool(int, std::span<const std::uint8_t>)>& take,
                      const std::string& where) {
  const std::string scale =
      "scale=" + std::to_string(size.width) + ":" + std::to_string(size.height) + ":flags=area";
  each_frame(
      {path, size, true, scale, frames, "copy the file again, or cut it with --to"},
      [&](int i, std::span<const std::uint8_t> rgb) { return take(i, rgb) && i + 1 < frames; }, where);
}

}  // namespace splinevox::data
