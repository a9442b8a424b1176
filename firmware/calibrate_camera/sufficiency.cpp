#include "calibrate_camera/sufficiency.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "calibrate_camera/sheet_attitude.h"

namespace ninedot {
namespace {

/// Nine parameters and a covariance of them that holds: with fewer the spread between views can't be told.
constexpr std::size_t kLeastViews = 10;
/// Half of ViewGoals::views are tilted. From 25 degrees on, which a picture without its lens can't tell from 30; at 45
/// dots begin to be narrow.
constexpr int kGoodTilted = 4;
constexpr double kTilted_rad = 25 * std::numbers::pi / 180;
/// What is near shows how lines converge, and its outlines are long.
constexpr int kGoodNear = 6;
constexpr double kNear_heights = 1.0 / 3;
/// A focal length that is wrong by 0.5 % makes a distance wrong by as much: 5 mm of a metre.
constexpr double kMaxFocalShare = 0.005;
/// Half a pixel is what a careless calibration has; beyond it the pose's own sigma means nothing.
constexpr double kMaxDirection_px = 0.5, kMaxPartDirection_px = 1;
/// A tenth of a pixel at f = 600 px is 0.17 mm at a metre: what a landmark's own outlines allow at best.
constexpr double kGoodDirection_px = 0.1;
/// Outlines that lie so far from any lens's: the sheet is bent, or its dots are elsewhere than is said.
constexpr double kMaxUnexplained_px = 0.7;
/// A slip of the hand now and then. Of two zooms in one recording, whose views lie near enough to each other that a
/// part of the smaller one stays in the fit, a sixth and more are seen to contradict.
constexpr double kMaxContradicting = 0.15;

std::string number_word(std::size_t number) {
  constexpr const char* kWords[] = {"no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine"};
  return number < std::size(kWords) ? kWords[number] : std::to_string(number);
}

/// The smallest first.
std::vector<double> sigmas_of_part(const DirectionErrors& directions, std::size_t part) {
  const auto column = static_cast<int>(part % 3), row = static_cast<int>(part / 3);
  std::vector<double> sigmas_px;
  for (int y = row * DirectionErrors::kRows / 3; y < (row + 1) * DirectionErrors::kRows / 3; ++y)
    for (int x = column * DirectionErrors::kColumns / 3; x < (column + 1) * DirectionErrors::kColumns / 3; ++x)
      sigmas_px.push_back(directions.at(x, y));
  std::ranges::sort(sigmas_px);
  return sigmas_px;
}

}  // namespace

std::size_t part_of(const Eigen::Vector2d& at_px, int width_px, int height_px) {
  const int column = std::clamp(static_cast<int>(3 * at_px.x() / width_px), 0, 2);
  const int row = std::clamp(static_cast<int>(3 * at_px.y() / height_px), 0, 2);
  return 3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column);
}

std::array<int, 9> views_by_part(std::span<const SheetView> views, int width_px, int height_px) {
  std::array<int, 9> counts{};
  for (const SheetView& view : views) {
    std::array<bool, 9> seen{};
    for (const SeenDisc& disc : view.seen) {
      seen[part_of(disc.centre_px, width_px, height_px)] = true;
    }
    for (std::size_t part = 0; part < seen.size(); ++part) counts[part] += seen[part] ? 1 : 0;
  }
  return counts;
}

std::vector<std::string> what_views_lack(std::span<const SheetView> views, std::size_t found, int width_px,
                                         int height_px) {
  if (views.size() == 1 && found > 1)
    return {fmt::format("all {} pictures show the sheet in one place: move it, or the camera, from one to the next",
                        found)};
  std::vector<std::string> lacks;
  if (views.size() < kLeastViews)
    lacks.push_back(fmt::format("{} view{} too few: take {} at least, 30 or more are good", number_word(views.size()),
                                views.size() == 1 ? " is" : "s are", kLeastViews));
  const std::array<int, 9> counts = views_by_part(views, width_px, height_px);
  std::vector<std::string> empty;
  for (std::size_t part = 0; part < counts.size(); ++part)
    if (counts[part] == 0) empty.push_back(fmt::format("in the {}", kPartNames[part]));
  if (!empty.empty()) lacks.push_back(fmt::format("no views {}: show the sheet there too", fmt::join(empty, ", ")));
  return lacks;
}

ViewTally tally_of(std::span<const SheetView> views, std::span<const PlaneDisc> discs, int width_px, int height_px) {
  ViewTally tally{views.size(), views_by_part(views, width_px, height_px), {}, 0};
  for (const SheetView& view : views) {
    const std::optional<SheetAttitude> attitude = attitude_of(view.seen, discs, height_px);
    if (!attitude) continue;
    if (attitude->height_share >= kNear_heights) ++tally.near;
    if (attitude->tilt_rad < kTilted_rad) continue;
    const Eigen::Vector2d away = attitude->away;
    const bool is_sideways = std::abs(away.x()) > std::abs(away.y());
    ++tally.tilts[is_sideways ? (away.x() > 0 ? 0 : 1) : (away.y() < 0 ? 2 : 3)];
  }
  return tally;
}

std::string name_of(const Want& want) {
  switch (want.kind) {
    case Want::Kind::kPart:
      return kPartNames[want.which];
    case Want::Kind::kTilt:
      return kTiltNames[want.which];
    case Want::Kind::kNearer:
      return "nearer";
    case Want::Kind::kMore:
      break;
  }
  return fmt::format("{} more", want.which);
}

std::vector<Want> wanted_views(const ViewTally& tally, const ViewGoals& goals) {
  std::vector<Want> wanted;
  for (std::size_t part = 0; part < tally.parts.size(); ++part)
    if (tally.parts[part] < goals.parts[part]) wanted.push_back({Want::Kind::kPart, part});
  for (std::size_t tilt = 0; tilt < tally.tilts.size(); ++tilt)
    if (tally.tilts[tilt] < kGoodTilted) wanted.push_back({Want::Kind::kTilt, tilt});
  if (tally.near < kGoodNear) wanted.push_back({Want::Kind::kNearer, 0});
  if (wanted.empty() && tally.views < goals.views) wanted.push_back({Want::Kind::kMore, goals.views - tally.views});
  return wanted;
}

bool is_wanted(const Want& want, const ViewTally& view) {
  switch (want.kind) {
    case Want::Kind::kPart:
      return view.parts[want.which] > 0;
    case Want::Kind::kTilt:
      return view.tilts[want.which] > 0;
    case Want::Kind::kNearer:
      return view.near > 0;
    case Want::Kind::kMore:
      break;
  }
  return view.views > 0;
}

std::vector<std::string> what_lens_lacks(const LensCalibration& calibration) {
  std::vector<std::string> lacks;
  const CameraModel& camera = calibration.fit.camera;
  const Eigen::MatrixXd& covariance = calibration.covariance.matrix;
  const double focal_share = std::sqrt(
      std::max(covariance(0, 0) / (camera.fx_px * camera.fx_px), covariance(1, 1) / (camera.fy_px * camera.fy_px)));
  if (!(focal_share <= kMaxFocalShare))
    lacks.push_back(
        fmt::format("focal length uncertain by {:.2g} %: tilt the sheet by 30 to 45 degrees in a part of the "
                    "views, to all sides",
                    100 * focal_share));
  const DirectionErrors& directions = calibration.directions;
  // Where the focal length is not known no direction is, however often the sheet is shown there.
  const bool is_focal_known = lacks.empty();
  bool is_part_named = false;
  for (std::size_t part = 0; part < kPartNames.size(); ++part) {
    const std::vector<double> sigmas_px = sigmas_of_part(directions, part);
    const double sigma_px = sigmas_px[sigmas_px.size() / 2];
    if (sigma_px <= kMaxPartDirection_px || (!is_focal_known && std::isfinite(sigma_px))) continue;
    is_part_named = true;
    lacks.push_back(
        std::isfinite(sigma_px)
            ? fmt::format("few views in the {}: directions there are uncertain by {:.2g} px: show the sheet "
                          "there more often",
                          kPartNames[part], sigma_px)
            : fmt::format("the lens has no directions in the {}: show the sheet there more often", kPartNames[part]));
  }
  if (is_focal_known && !is_part_named && directions.median_px() > kMaxDirection_px)
    lacks.push_back(fmt::format("directions are uncertain by {:.2g} px: take more views, nearer, tilted to all sides",
                                directions.median_px()));
  if (calibration.fit.floor_px > kMaxUnexplained_px)
    lacks.push_back(
        fmt::format("outlines are off by {:.2g} px whatever the lens: is the sheet flat, and are its lengths those "
                    "that were given?",
                    calibration.fit.floor_px));
  const std::size_t used = calibration.views.size();
  const auto contradicting = static_cast<std::size_t>(calibration.contradicting);
  if (static_cast<double>(contradicting) > kMaxContradicting * static_cast<double>(used + contradicting))
    lacks.push_back(fmt::format("{} of {} views contradict the others: were all taken with the same focus and zoom?",
                                contradicting, used + contradicting));
  else if (used < kLeastViews)
    lacks.push_back(fmt::format("{} views of use are too few: take {} at least, 30 or more are good", number_word(used),
                                kLeastViews));
  return lacks;
}

std::vector<UncertainPart> uncertain_parts(const LensCalibration& calibration) {
  std::vector<UncertainPart> uncertain;
  for (std::size_t part = 0; part < kPartNames.size(); ++part)
    if (const double sigma_px = sigmas_of_part(calibration.directions, part).back(); !(sigma_px <= kGoodDirection_px))
      uncertain.push_back({part, sigma_px});
  return uncertain;
}

}  // namespace ninedot
