#include "drivers/recording/recording_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <system_error>

#include "base/startup_error.h"
#include "base/units.h"
#include "drivers/posix/whole_file.h"
#include "drivers/recording/y4m_file.h"
#include "proto/frames_csv.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// Without frames.csv a gap in the numbers stands for missing pictures, but not for more of them than this: five
/// minutes at kUntimedRate_hz.
constexpr std::uint64_t kMaxMissing = 10'000;
/// Longer ones are a clock that jumped; the limit also keeps the times of endless loops within 64 bits.
constexpr std::chrono::nanoseconds kMaxDuration = std::chrono::hours(24 * 366);

/// R, G, B and alpha of the largest picture, uncompressed, and a quarter for what a file has beside them.
constexpr std::size_t kMaxPicture_bytes = std::size_t{5} * kMaxPictureSide_px * kMaxPictureSide_px;
/// A day of kUntimedRate_hz, in rows of 40 bytes.
constexpr std::size_t kMaxCsv_bytes = std::size_t{128} << 20U;
constexpr unsigned kMebi = 20;  // as a power of two

[[noreturn]] void refuse(const std::string& line) { throw StartupError(ExitStatus::kWorkFailed, line); }

/// Opening a fifo waits for a writer, and what was read of one is gone.
void refuse_pipes(const std::string& path) {
  for (const std::string& file : {path, path + "/frames.csv"})
    if (std::error_code none; fs::is_fifo(file, none))
      throw StartupError(ExitStatus::kWrongUsage, file + ": is a pipe: a recording is read more than once");
}

std::chrono::nanoseconds untimed(std::uint64_t number, double rate_hz) {
  return std::chrono::nanoseconds(std::llround(static_cast<double>(number) * 1e9 / rate_hz));
}

/// Number of a picture's name: only digits, then a known ending. \return -1: not a picture of a recording
std::int64_t picture_number(const fs::path& file) {
  const std::string ending = file.extension().string();
  if (ending != ".png" && ending != ".pgm" && ending != ".ppm" && ending != ".jpg" && ending != ".jpeg") return -1;
  const std::string stem = file.stem().string();
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
  if (error != std::errc{} || end != stem.data() + stem.size() || number > 999'999'999) return -1;
  return number;
}

using Pictures = std::map<std::uint64_t, std::string>;

Pictures list_pictures(const std::string& path, std::size_t& largest_file_bytes) {
  Pictures pictures;
  const fs::path folder = fs::path(path) / "frames";
  if (!fs::is_directory(folder)) refuse(fmt::format("{}: not a recording: there is no folder 'frames' in it", path));
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::int64_t number = picture_number(entry.path());
    if (number < 0 || !entry.is_regular_file()) continue;
    const auto [place, is_new] = pictures.emplace(static_cast<std::uint64_t>(number), entry.path().string());
    if (!is_new)
      refuse(fmt::format("{}: {} has the same number; remove one of them", entry.path().string(), place->second));
    const std::size_t bytes = entry.file_size();
    if (bytes > kMaxPicture_bytes)
      refuse(fmt::format("{}: longer than {} MiB, as no picture is; remove it", entry.path().string(),
                         kMaxPicture_bytes >> kMebi));
    largest_file_bytes = std::max(largest_file_bytes, bytes);
  }
  if (pictures.empty())
    refuse(fmt::format("{}: no picture in it; expected NNNNNN.png, .pgm, .ppm or .jpg", folder.string()));
  return pictures;
}

std::string missing_picture(const std::string& path, std::uint64_t number, const Pictures& pictures) {
  const std::string ending = fs::path(pictures.begin()->second).extension().string();
  return (fs::path(path) / "frames" / fmt::format("{:06}{}", number, ending)).string();
}

void add_timed_frames(const std::string& csv, const Pictures& pictures, RecordingIndex& index) {
  std::error_code none;
  if (fs::file_size(csv, none) > kMaxCsv_bytes && !none)
    refuse(fmt::format("{}: longer than {} MiB; is it the right file?", csv, kMaxCsv_bytes >> kMebi));
  std::ifstream stream(csv, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream) refuse(fmt::format("{}: cannot be read", csv));
  const auto rows = parse_frames_csv(text.view());
  if (!rows) refuse(fmt::format("{}:{}: {}", csv, rows.error().line, rows.error().what));
  if (rows->empty()) refuse(fmt::format("{}: no row; remove the file or list the pictures", csv));
  if (std::chrono::nanoseconds(rows->back().timestamp_ns - rows->front().timestamp_ns) > kMaxDuration)
    refuse(fmt::format("{}:{}: the recording lasts more than a year: timestamp_ns jumped", csv, rows->size() + 1));
  std::size_t found = 0;
  for (const FramesCsvRow& row : *rows) {
    const auto picture = pictures.find(row.frame);
    if (picture != pictures.end()) ++found;
    index.frames.push_back(RecordedFrame{
        row.frame, std::chrono::nanoseconds(row.timestamp_ns), row.pan_deg * kRadPerDeg, row.tilt_deg * kRadPerDeg,
        picture != pictures.end() ? picture->second : missing_picture(index.path, row.frame, pictures), 0, row.zoom});
  }
  if (found == pictures.size()) return;
  for (const Pictures::value_type& picture : pictures)
    if (std::none_of(rows->begin(), rows->end(), [&](const FramesCsvRow& row) { return row.frame == picture.first; }))
      refuse(fmt::format("{}: picture {} is not listed; add its row or remove the picture", csv, picture.second));
}

void add_untimed_frames(const Pictures& pictures, RecordingIndex& index) {
  const std::uint64_t first = pictures.begin()->first;
  const std::uint64_t last = pictures.rbegin()->first;
  if (last - first + 1 - pictures.size() > kMaxMissing)
    refuse(fmt::format("{}/frames: {} pictures numbered from {} to {}; list them in frames.csv", index.path,
                       pictures.size(), first, last));
  for (std::uint64_t number = first; number <= last; ++number) {
    const auto picture = pictures.find(number);
    index.frames.push_back(
        RecordedFrame{number,
                      untimed(number, kUntimedRate_hz),
                      0,
                      0,
                      picture != pictures.end() ? picture->second : missing_picture(index.path, number, pictures),
                      0,
                      {}});
  }
}

/// Of the first picture whose header can be read. Reads whole files: a JPEG's size may stand behind a long comment.
PictureSize first_size(const Pictures& pictures, std::size_t largest_file_bytes) {
  std::vector<std::uint8_t> buffer(largest_file_bytes);
  for (const auto& [number, file] : pictures) {
    const Result<std::size_t> bytes = read_whole_file(file.c_str(), buffer);
    if (!bytes) continue;
    const Result<PictureSize> size = read_picture_size(std::span(buffer).first(*bytes));
    if (size) return *size;
  }
  refuse(fmt::format("{}: not a readable picture, nor is any other in this folder", pictures.begin()->second));
}

void read_folder(RecordingIndex& index) {
  const Pictures pictures = list_pictures(index.path, index.largest_file_bytes);
  const fs::path csv = fs::path(index.path) / "frames.csv";
  if (fs::exists(csv))
    add_timed_frames(csv.string(), pictures, index);
  else
    add_untimed_frames(pictures, index);
  index.size = first_size(pictures, index.largest_file_bytes);
}

/// Walks from frame header to frame header: each may carry parameters, so that their places can't be calculated.
void read_y4m(RecordingIndex& index) {
  std::ifstream stream(index.path, std::ios::binary);
  std::vector<std::uint8_t> start(kMaxY4mHeader_bytes);
  const auto read_at = [&](std::int64_t offset) {
    stream.clear();
    stream.seekg(offset);
    stream.read(reinterpret_cast<char*>(start.data()), static_cast<std::streamsize>(start.size()));
    return std::span<const std::uint8_t>(start).first(
        static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  };
  const Result<Y4mHeader> header = parse_y4m_header(read_at(0));
  if (!header) refuse(fmt::format("{}: {}", index.path, header.error().text));
  index.size = header->size;
  index.y4m_chroma_size = header->chroma_size;
  const double rate_hz = header->rate_hz > 0 ? header->rate_hz : kUntimedRate_hz;
  const auto file_bytes = static_cast<std::int64_t>(fs::file_size(index.path));
  for (auto at = static_cast<std::int64_t>(header->header_bytes); at < file_bytes;) {
    const Result<std::size_t> frame_header_bytes = parse_y4m_frame_header(read_at(at));
    const std::uint64_t number = index.frames.size();
    const std::int64_t offset = frame_header_bytes ? at + static_cast<std::int64_t>(*frame_header_bytes) : -1;
    index.frames.push_back(RecordedFrame{number, untimed(number, rate_hz), 0, 0, {}, offset, {}});
    if (!frame_header_bytes) break;  // where the next one starts is unknown
    at = offset + static_cast<std::int64_t>(header->frame_bytes());
  }
  if (index.frames.empty()) refuse(fmt::format("{}: no frame in it", index.path));
}

}  // namespace

bool RecordingIndex::tells_zoom() const {
  return std::ranges::any_of(frames, [](const RecordedFrame& frame) { return frame.zoom.has_value(); });
}

RecordingIndex read_recording_index(const std::string& path) {
  RecordingIndex index;
  index.path = path;
  refuse_pipes(path);
  try {
    if (!fs::exists(path)) refuse(fmt::format("{}: no such recording", path));
    if (fs::is_directory(path)) {
      read_folder(index);
    } else if (fs::path(path).extension() == ".y4m") {
      index.is_y4m = true;
      read_y4m(index);
    } else {
      refuse(fmt::format("{}: not a recording: a folder with frames/ in it, or a .y4m file", path));
    }
  } catch (const fs::filesystem_error& error) {
    refuse(fmt::format("{}: {}", path, error.code().message()));
  }
  return index;
}

std::string recording_camera_file(const std::string& path) {
  const fs::path place(path);
  return ((fs::is_directory(place) ? place : place.parent_path()) / "camera.yaml").string();
}

}  // namespace ninedot
