#include "tests/bench/trust/photographs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>

#include "drivers/picture/picture_file.h"

namespace ninedot::bench {
namespace {

struct Scale {
  const char* name;
  int factor;
  int most_windows;
};
constexpr std::array<Scale, 3> kScales{{{"full", 1, 44}, {"half", 2, 12}, {"quarter", 4, 4}}};
constexpr const Scale& kInRoom = kScales[1];  // whose windows are looked at in a room as well
constexpr const char* kInRoomName = "photographs, half scale, in a room";
constexpr double kFlat_lsb = 4;        // standard deviation of the grey levels, below: there is nothing to see
constexpr int kSmallestSide_px = 120;  // of a picture in a window: less is an icon
constexpr std::uint8_t kWhite = 255;

test::Picture read_photograph(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<std::uint8_t> file{std::istreambuf_iterator<char>(stream), {}};
  const auto size = read_picture_size(file);
  if (!size) return {};
  test::Picture picture{size->width_px, size->height_px, {}};
  picture.pixels.resize(size->pixel_count());
  PictureDecoder decoder(*size);
  if (!decoder.decode(file, picture.pixels)) return {};
  return picture;
}

test::Picture averaged(const test::Picture& picture, int factor) {
  test::Picture small{picture.width_px / factor, picture.height_px / factor, {}};
  small.pixels.reserve(static_cast<std::size_t>(small.width_px) * static_cast<std::size_t>(small.height_px));
  const ImageView view = picture.view();
  for (int y = 0; y < small.height_px; ++y)
    for (int x = 0; x < small.width_px; ++x) {
      int sum = factor * factor / 2;
      for (int j = 0; j < factor; ++j)
        for (int i = 0; i < factor; ++i) sum += view.at(factor * x + i, factor * y + j);
      small.pixels.push_back(static_cast<std::uint8_t>(sum / (factor * factor)));
    }
  return small;
}

test::Picture window_of(const test::Picture& picture, int left, int top) {
  const test::Lens lens = trust_lens();
  test::Picture window{lens.width_px, lens.height_px, {}};
  window.pixels.reserve(static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px));
  const ImageView view = picture.view();
  for (int y = top; y < top + lens.height_px; ++y)
    for (int x = left; x < left + lens.width_px; ++x) {
      const bool inside = x >= 0 && y >= 0 && x < picture.width_px && y < picture.height_px;
      window.pixels.push_back(inside ? view.at(x, y) : kWhite);
    }
  return window;
}

bool is_flat(const test::Picture& picture) {
  double sum = 0, squares = 0;
  for (const std::uint8_t level : picture.pixels) sum += level, squares += level * level;
  const double count = static_cast<double>(picture.pixels.size());
  return squares / count - (sum / count) * (sum / count) < kFlat_lsb * kFlat_lsb;
}

// Windows along one side, a quarter of each in common at most.
int windows_along(int side_px, int window_px) {
  return side_px < window_px ? 1 : 1 + static_cast<int>((side_px - window_px) / (0.75 * window_px));
}

int place_along(int index, int count, int side_px, int window_px) {
  return count > 1 ? (side_px - window_px) * index / (count - 1) : (side_px - window_px) / 2;
}

void cut(const test::Picture& picture, const Scale& scale, const std::string& name, const Taker& take) {
  const test::Lens lens = trust_lens();
  if (picture.width_px < kSmallestSide_px || picture.height_px < kSmallestSide_px) return;
  int columns = windows_along(picture.width_px, lens.width_px), rows = windows_along(picture.height_px, lens.height_px);
  while (columns * rows > scale.most_windows) --(columns >= rows ? columns : rows);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const int left = place_along(column, columns, picture.width_px, lens.width_px);
      const int top = place_along(row, rows, picture.height_px, lens.height_px);
      Shot shot;
      shot.picture = window_of(picture, left, top);
      if (is_flat(shot.picture)) continue;
      Strip strip{fmt::format("photographs, {} scale", scale.name),
                  fmt::format("{}@{}x{}+{}+{}", name, picture.width_px, picture.height_px, left, top),
                  {}};
      if (&scale == &kInRoom) take({kInRoomName, strip.name, seen_three_times(shot), true});
      strip.shots.push_back(std::move(shot));
      take(std::move(strip));
    }
}

void cut_all(const std::filesystem::path& path, const Taker& take) {
  const test::Picture picture = read_photograph(path);
  if (picture.pixels.empty()) {
    fmt::print(stderr, "trust: cannot read {}: left out\n", path.string());
    return;
  }
  for (const Scale& scale : kScales)
    cut(scale.factor == 1 ? picture : averaged(picture, scale.factor), scale, path.stem().string(), take);
}

}  // namespace

Half half_of(std::string_view file_name) {
  std::string_view stem = file_name.substr(0, file_name.rfind('.'));
  for (const std::string_view twin : {"-d", "-l", "_dark", "_light", "-dark", "-light", "_small", "_flip"})
    if (stem.ends_with(twin)) stem.remove_suffix(twin.size());
  stem = stem.substr(0, stem.find_last_not_of("0123456789x_-") + 1);  // sizes, and numbers of a series
  std::uint32_t hash = 2166136261U;                                   // FNV-1a
  for (const char c : stem) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return ((hash >> 16U) & 1U) != 0 ? Half::kHeld : Half::kTune;
}

std::vector<Kind> photograph_kinds() {
  std::vector<Kind> kinds;
  for (const Scale& scale : kScales) kinds.push_back({"Photographs", fmt::format("photographs, {} scale", scale.name)});
  kinds.push_back({"Photographs", kInRoomName});
  return kinds;
}

std::vector<Job> photograph_jobs(const std::filesystem::path& folder, Half half) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name.ends_with(".part") || (half != Half::kBoth && half_of(name) != half)) continue;
      files.push_back(entry.path());
    }
  std::sort(files.begin(), files.end());
  std::vector<Job> jobs;
  for (const auto& path : files) jobs.emplace_back([path](const Taker& take) { cut_all(path, take); });
  return jobs;
}

}  // namespace ninedot::bench
