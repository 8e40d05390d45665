// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/picture_cache.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/handle.hpp"
#include "core/hash.hpp"
#include "core/mapped_file.hpp"
#include "core/own_folder.hpp"
#include "core/printable.hpp"
#include "core/system.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kPage = 4096;  ///< pictures begin at a multiple of it
constexpr std::uint64_t kFormat = 1;
constexpr std::uint64_t kAverages = 2;  ///< grows when --downscale makes other pixels of the same files
constexpr char kMark[8] = {'S', 'V', 'O', 'X', 'P', 'I', 'C', 'S'};

/// Of a picture, in the table behind all pictures.
struct CachedPicture {
  std::uint64_t offset, hash;
  std::int32_t width, height;
  std::uint8_t channels, bytes, invisible, black, half, odd, unused[2];
};
/// The end of the file.
struct CacheEnd {
  char mark[8];
  std::uint64_t format, key, count, table, hash;  ///< hash: of the table and the other fields
};
static_assert(sizeof(CachedPicture) == 32 && sizeof(CacheEnd) == 48);

std::uint64_t hash_of(const std::vector<CachedPicture>& table, CacheEnd foot) {
  foot.hash = 0;
  Hash64 hash;
  hash.add(table.data(), table.size() * sizeof(CachedPicture));
  hash.add(&foot, sizeof foot);
  return hash.value();
}

template <class T>
std::string_view bytes_of(const T* first, std::size_t count) {
  return {reinterpret_cast<const char*>(first), count * sizeof(T)};
}

/// The right to make a cache, where the file system has locks. What a process that was killed left half
/// written goes.
class MakerLock {
 public:
  explicit MakerLock(const std::string& path) : path_(path + ".lock") {
    file_ = std::make_unique<Handle>(path_, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK);
    held_ = file_->ok() && retried([&] { return ::flock(file_->get(), LOCK_EX); }) == 0;
    if (!held_) return;
    const fs::path place(path);
    const std::string start = place.filename().string() + ".";
    std::error_code ignored;
    for (const std::string& name : names_in_folder(place.parent_path().string()))
      if (name.starts_with(start) && name.ends_with(".tmp")) fs::remove(place.parent_path() / name, ignored);
  }
  MakerLock(const MakerLock&) = delete;
  MakerLock& operator=(const MakerLock&) = delete;
  ~MakerLock() {
    if (held_) ::unlink(path_.c_str());  // whoever waits for it finds the cache made
  }

 private:
  std::string path_;
  std::unique_ptr<Handle> file_;
  bool held_ = false;
};

double gigabytes(double bytes) { return bytes / 1e9; }

/// Full disks are found before any picture is decoded, as far as they can be.
void check_room(const PictureCache& cache, const PicturePlan& plan) {
  const double needed =
      memory_for(plan, 1).kept + double(kPage + sizeof(CachedPicture)) * double(plan.sizes.size());
  std::error_code unknown;
  const fs::space_info space = fs::space(fs::path(cache.path).parent_path(), unknown);
  if (unknown || double(space.available) >= needed) return;
  fail_output({cache.path, "the pictures do not fit into memory, and there is no room for them on this disk",
               fmt::format("{:.1f} GB", gigabytes(needed)),
               fmt::format("{:.1f} GB", gigabytes(double(space.available))),
               fmt::format("--cache with a folder on a larger disk, more --memory, or --downscale {}",
                           2 * plan.downscale)});
}

void write_cache(const PictureCache& cache, const PicturePlan& plan) {
  FileWriter file(cache.path, std::uint64_t(memory_for(plan, 1).kept));
  std::uint64_t size = 0;
  const auto add = [&](std::string_view bytes) {
    file.add(bytes);
    size += bytes.size();
    file.add(std::string((kPage - size % kPage) % kPage, '\0'));
    size = (size + kPage - 1) / kPage * kPage;
  };
  add(std::string_view(cache.about).substr(0, kPage));
  std::vector<CachedPicture> table(plan.paths.size());
  decode(plan, [&](std::size_t i, Picture&& p, const PictureFacts& facts) {
    const Picture::Layout layout = p.layout();
    table[i] = {size,        facts.hash,  p.width,   p.height, layout.channels, layout.bytes, facts.invisible,
                facts.black, layout.half, facts.odd, {}};
    add(bytes_of(p.values(), layout.size(p.pixels())));
  });
  CacheEnd foot{{}, kFormat, cache.key, table.size(), size, 0};
  std::memcpy(foot.mark, kMark, sizeof kMark);
  foot.hash = hash_of(table, foot);
  file.add(bytes_of(table.data(), table.size()));
  file.add(bytes_of(&foot, 1));
  file.commit();
}

/// Whether an entry is one of the picture that the plan expects.
bool fits(const CachedPicture& e, const PictureSize& size, int downscale, std::uint64_t end) {
  const Picture::Layout layout{e.channels, e.bytes, e.half != 0};
  if (e.width != size.width / downscale || e.height != size.height / downscale) return false;
  if ((e.channels != 3 && e.channels != 4) || (e.bytes != 1 && e.bytes != 2) || (e.half != 0 && e.bytes != 2))
    return false;
  const std::uint64_t bytes = layout.size(std::size_t(e.width) * std::size_t(e.height));
  return e.offset % kPage == 0 && e.offset <= end && bytes <= end - e.offset;
}

}  // namespace

std::string cache_folder(const std::string& asked) {
  if (!asked.empty()) return asked;
  const auto variable = [](const char* name) {
    const char* text = std::getenv(name);
    return std::string(text ? text : "");
  };
  if (const std::string base = variable("XDG_CACHE_HOME"); base.starts_with("/")) return base + "/splinevox";
  if (const std::string home = variable("HOME"); home.starts_with("/")) return home + "/.cache/splinevox";
  fail({"--cache", "the pictures do not fit into memory, and there is no folder to keep them in",
        "--cache DIR, or HOME in the environment", "neither", ""});
}

PictureCache cache_of(const std::string& folder, const std::string& dataset, const std::string& split,
                      const PicturePlan& plan) {
  constexpr std::size_t kLongest = 80;
  const std::string source = fs::canonical(dataset).string();
  std::string name = fs::path(source).filename().string().substr(0, kLongest);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  PictureCache out;
  out.path = fmt::format("{}/{}-{}{}-{:016x}.pictures", folder, name, split,
                         plan.downscale > 1 ? fmt::format("-{}", plan.downscale) : "", hash64(source));
  out.about = fmt::format(
      "splinevox pictures {}\nDecoded pictures of {}, {}, downscale {}. May be deleted at any time.\n",
      kFormat, all_printable(source), split, plan.downscale);
  Hash64 key;
  const auto add = [&](auto value) { key.add(&value, sizeof value); };
  const auto add_file = [&](const fs::path& path) {
    struct stat info {};
    ::stat(path.c_str(), &info);  // that of a file that is gone is told by who decodes it
    key.add(path.string() + '\0');
    add(std::int64_t(info.st_size));
    add(std::int64_t(changed_at(info).tv_sec));
    add(std::int64_t(changed_at(info).tv_nsec));
  };
  const bool masked = plan.masks.use.what == MaskUse::What::subject;
  if (masked || plan.masks.use.of_alpha) key.add(plan.masks.use.text);
  add(std::int64_t(plan.downscale));
  if (plan.downscale > 1) add(kAverages);
  key.add(plan.layer);
  for (std::size_t i = 0; i < plan.paths.size(); ++i) {
    add_file(plan.paths[i]);
    if (masked) add_file(plan.masks.files[i]);
    add(std::int64_t(plan.film_frame[i]));
    add(std::int64_t(plan.turns[i]));
    add(std::int64_t(plan.linear[i]));
  }
  out.key = key.value();
  return out;
}

std::optional<StoredPictures> open_cache(const PictureCache& cache, const PicturePlan& plan,
                                         std::string& why) {
  const std::shared_ptr<const MappedFile> file = MappedFile::open(cache.path);
  if (!file) return {};
  const std::span<const std::uint8_t> all = file->bytes();
  const auto refuse = [&](const char* reason) {
    why = reason;
    return std::nullopt;
  };
  CacheEnd foot;
  if (all.size() < sizeof foot) return refuse("damaged");
  std::memcpy(&foot, all.data() + all.size() - sizeof foot, sizeof foot);
  if (std::memcmp(foot.mark, kMark, sizeof kMark) != 0) return refuse("damaged");
  if (foot.format != kFormat) return refuse("of another version");
  const std::uint64_t behind = all.size() - sizeof foot;
  if (foot.table > behind || (behind - foot.table) / sizeof(CachedPicture) != foot.count ||
      (behind - foot.table) % sizeof(CachedPicture) != 0)
    return refuse("damaged");
  std::vector<CachedPicture> table(foot.count);
  std::memcpy(table.data(), all.data() + foot.table, behind - foot.table);
  if (hash_of(table, foot) != foot.hash) return refuse("damaged");
  if (foot.key != cache.key || table.size() != plan.sizes.size()) return refuse("of other pictures");
  StoredPictures out;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const CachedPicture& e = table[i];
    if (!fits(e, plan.sizes[i], plan.downscale, foot.table)) return refuse("damaged");
    const Picture::Layout layout{e.channels, e.bytes, e.half != 0};
    out.pictures.emplace_back(e.width, e.height, layout,
                              std::shared_ptr<const std::uint8_t[]>(file, all.data() + e.offset));
    out.facts.push_back({e.hash, e.channels == 4, e.invisible != 0, e.black != 0, e.odd != 0});
  }
  // To look at every picture would read the whole file.
  for (const std::size_t i : {std::size_t(0), table.size() / 2, table.size() - 1}) {
    const ReadAll all_of(out.pictures[i]);
    if (facts_of(out.pictures[i]).hash != table[i].hash) return refuse("damaged");
  }
  return out;
}

StoredPictures through_cache(const PictureCache& cache, const PicturePlan& plan,
                             std::vector<std::string>& notes) {
  std::string why;
  if (auto found = open_cache(cache, plan, why)) return std::move(*found);
  const std::string folder = fs::path(cache.path).parent_path().string();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    fail_output({folder, "there is no such folder, and it cannot be made", "a folder that may be written to",
                 error.message(), "--cache with another folder"});
  const MakerLock lock(cache.path);
  if (auto found = open_cache(cache, plan, why)) return std::move(*found);
  if (!why.empty()) notes.push_back(fmt::format("{} is {}: made anew", all_printable(cache.path), why));
  check_room(cache, plan);
  try {
    write_cache(cache, plan);
  } catch (const Error& e) {
    if (e.fault != Fault::output) throw;
    Problem problem = e.problem;
    problem.hint = "--cache with a folder on a disk with room, more --memory, or a larger --downscale";
    fail_output(problem);
  }
  why.clear();
  if (auto made = open_cache(cache, plan, why)) return std::move(*made);
  fail_output({cache.path, "the pictures were written, and cannot be read again",
               "the file as it was written", why.empty() ? "no file" : why, "--cache with another folder"});
}

}  // namespace splinevox::data
