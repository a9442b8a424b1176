#include "pipeline/code_identity.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

/// Logarithm of the odds that what is tracked is another ring, from which on it is named anew: a track that has slid
/// from one sheet to another, or a first look that was wrong. 150 to 1.
constexpr double kIsAnother = 5;
/// Odds from which on a single picture is enough: unrelated rings are at 1e6 and more, noise of small dots below 3.
constexpr double kContradicts = 10;
constexpr double kForget = 0.9, kFrameCounts = 0.25;

/// The coded landmarks, and one that stands for all black-and-white ones, which look alike. Empty: none is coded.
std::vector<std::size_t> told_apart_by_colour(const LandmarkMap& map) {
  std::vector<std::size_t> indices;
  std::optional<std::size_t> black;
  for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
    if (!is_black_and_white(map.landmarks()[i].code)) indices.push_back(i);
    if (is_black_and_white(map.landmarks()[i].code)) black = i;
  }
  if (black && !indices.empty()) indices.push_back(*black);
  return indices;
}

std::vector<MappedLandmark> those(const LandmarkMap& map, std::span<const std::size_t> indices) {
  std::vector<MappedLandmark> landmarks;
  for (const std::size_t i : indices) landmarks.push_back(map.landmarks()[i]);
  return landmarks;
}

}  // namespace

CodeIdentity::CodeIdentity(const LandmarkMap& map)
    : indices_(told_apart_by_colour(map)),
      has_black_(!indices_.empty() && is_black_and_white(map.landmarks()[indices_.back()].code)),
      codes_(those(map, indices_)) {}

void CodeIdentity::look(const ColourReader& reader, const Frame& frame, const CameraFromLandmark& T_camera_landmark,
                        const PictureMotion& motion, const PictureNoise& noise, ShownColours& shown) const noexcept {
  const DotColours now = reader.read(frame.luma, frame.chroma, T_camera_landmark, noise, motion);
  if (!now.has_colour) return;
  const float kept = shown.frames < kMostFrames ? 1.0F : 1.0F - 1.0F / kMostFrames;
  const auto add = [kept](float& sum, float one) { sum = kept * sum + one; };
  for (std::size_t place = 0; place < kRingDotCount; ++place) {
    for (std::size_t ink = 0; ink < kInkCount; ++ink)
      add(shown.sum.log_likelihood[place][ink], now.log_likelihood[place][ink]);
    add(shown.sum.log_colourless[place], now.log_colourless[place]);
  }
  shown.sum.has_colour = true;
  ++shown.frames;
}

std::optional<Identity> CodeIdentity::identify(const ShownColours& shown, double max_odds) const noexcept {
  if (is_colourless()) return Identity{};
  const CodeReading reading = codes_.decode(shown.sum);
  if (!reading.best || !(reading.odds_of_others <= max_odds)) return std::nullopt;
  if (has_black_ && reading.best->landmark + 1 == indices_.size())
    return Identity{std::nullopt, 0, reading.odds_of_others};
  return Identity{indices_[reading.best->landmark], reading.best->turn, reading.odds_of_others};
}

std::optional<Identity> CodeIdentity::confirm(std::size_t expected, const ShownColours& shown,
                                              double max_odds) const noexcept {
  // Beside the place, which is as good as a code: the sheet that the map has there is the likeliest by far.
  constexpr double kSwapped = 1e-3;  // a sheet was put in the place of another, before anything is seen of it
  const double odds = kSwapped * codes_.evidence_against(reader_index(expected), 0, shown.sum);
  if (!(odds <= max_odds)) return std::nullopt;
  return Identity{expected, 0, odds};
}

std::size_t CodeIdentity::reader_index(std::size_t map_index) const noexcept {
  const auto at = std::ranges::find(indices_, map_index);
  EXPECTS(at != indices_.end());
  return static_cast<std::size_t>(at - indices_.begin());
}

bool CodeIdentity::contradicts(std::size_t coded, const ShownColours& shown) const noexcept {
  return shown.sum.has_colour && codes_.evidence_against(reader_index(coded), 0, shown.sum) > kContradicts;
}

bool CodeIdentity::is_still(std::size_t coded, const ColourReader& reader, const Frame& frame,
                            const CameraFromLandmark& T_camera_landmark, const PictureMotion& motion,
                            const PictureNoise& noise, double& doubt) const noexcept {
  const DotColours now = reader.watch(frame.luma, frame.chroma, T_camera_landmark, noise, frame.number, motion);
  // Frames share their errors, so that each counts a quarter; what is sure stays no surer than it began.
  const double said = now.has_colour ? std::log(codes_.evidence_against(reader_index(coded), 0, now)) : 0;
  doubt = std::max(kForget * doubt + kFrameCounts * said, 0.0);
  return doubt < kIsAnother;
}

}  // namespace ninedot
