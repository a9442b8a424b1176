#include "config/landmark_checks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/units.h"
#include "geometry/landmark.h"
#include "world/landmark_codes.h"
#include "world/landmark_map.h"

namespace ninedot {
namespace {

/// Two digits after the point make a quaternion's length wrong by up to 0.01; more is a typing error.
constexpr double kLengthTolerance = 0.01;

/// One landmark's keys among each other.
class LandmarkCheck {
 public:
  LandmarkCheck(const MapLandmarkConfig& landmark, std::size_t index, ConfigProblems& problems)
      : landmark_(landmark), index_(index), problems_(problems) {}

  void check_place() {
    if (landmark_.orientation_wxyz) {
      const auto& [w, x, y, z] = *landmark_.orientation_wxyz;
      const double length = std::sqrt(w * w + x * x + y * y + z * z);
      if (std::abs(length - 1) > kLengthTolerance)
        refuse("orientation_wxyz",
               fmt::format("'orientation_wxyz' has the length {:.4g}; write a quaternion of length 1", length));
      if (is_given("heading_deg"))
        refuse("orientation_wxyz", "'orientation_wxyz' and 'heading_deg' say the same: keep one of them");
    }
    if (landmark_.position_mm) return;
    for (const char* key :
         {"heading_deg", "orientation_wxyz", "sigma_position_mm", "sigma_rotation_deg", "from_pictures"})
      if (is_given(key))
        return refuse(key,
                      fmt::format("'{}' without 'position_mm': give both, or neither where the place is unknown", key));
  }

 private:
  std::string path(const char* key) const { return fmt::format("landmarks.{}.{}", index_, key); }
  bool is_given(const char* key) const { return problems_.lines.contains(path(key)); }
  void refuse(const char* key, std::string what) { problems_.add(problems_.line_of(path(key)), std::move(what)); }

  const MapLandmarkConfig& landmark_;
  const std::size_t index_;
  ConfigProblems& problems_;
};

/// The landmarks among each other. Each is held against those before it, and told of the first that it clashes with:
/// otherwise a thousand equal ones would make half a million lines.
class MapCheck {
 public:
  MapCheck(const Config& config, ConfigProblems& problems)
      : landmarks_(config.landmarks), side_mm_(side_mm(config.landmark)), problems_(problems) {
    for (const MapLandmarkConfig& landmark : landmarks_) sheets_.push_back(sheet_of(landmark));
  }

  void check_id(std::size_t i) {
    if (!ids_.insert(landmarks_[i].id).second)
      refuse(i, "id", fmt::format("two landmarks have the id {}", landmarks_[i].id));
  }

  void check_code(std::size_t i) {
    const std::string& code = landmarks_[i].code;
    if (!sheets_[i].has_code)
      return refuse(i, "code", fmt::format("'code' is '{}'; write eight of K R G B for P1..P8", code));
    if (is_black_and_white(code)) return;
    if (const CodeDistance own = own_distance(code); own.places < kLeastCodeDistance)
      refuse(
          i, "code",
          fmt::format("'code' {} looks the same when the sheet is turned by {}; choose another", code, dots(own.turn)));
    for (std::size_t j = 0; j < landmarks_.size(); ++j) {
      // A coded one is told of the black-and-white ones after it too, since those are held against nothing.
      if (j == i || !sheets_[j].has_code || (j > i && !is_black_and_white(landmarks_[j].code))) continue;
      const CodeDistance distance = code_distance(landmarks_[j].code, code);
      if (distance.places >= kLeastCodeDistance) continue;
      return refuse(i, "code",
                    fmt::format("landmarks {} and {} can't be told apart: {} their colours differ in {} of 8 places; "
                                "choose codes that differ in {} or more at every turn",
                                landmarks_[j].id, landmarks_[i].id,
                                distance.turn == 0 ? "without any turn"
                                                   : fmt::format("with the sheet of {} turned clockwise by {}",
                                                                 landmarks_[i].id, dots(distance.turn)),
                                distance.places, kLeastCodeDistance));
    }
  }

  void check_place(std::size_t i) {
    if (!landmarks_[i].position_mm) return;
    for (std::size_t j = 0; j < i; ++j) {
      if (!landmarks_[j].position_mm || !is_one_place(sheets_[j], sheets_[i])) continue;
      return refuse(i, "position_mm",
                    fmt::format("landmarks {} and {} hang in one place: {:.4g} mm apart and facing the same way, while "
                                "a sheet is {:.4g} mm wide; correct one of them",
                                landmarks_[j].id, landmarks_[i].id,
                                (sheets_[j].middle_mm - sheets_[i].middle_mm).norm(), side_mm_));
    }
  }

 private:
  struct Sheet {
    bool has_code = false;  ///< or none, which is black and white; false: what is written there is no code
    Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();  ///< world; zero where the place is unknown
    Eigen::Vector3d facing = Eigen::Vector3d::Zero();     ///< world, of length 1
  };

  static double side_mm(const LandmarkConfig& l) {
    return 2 * LandmarkGeometry{l.ring_radius_mm, l.dot_diameter_mm / 2, l.centre_diameter_mm / 2}.paper_radius_m();
  }

  static Sheet sheet_of(const MapLandmarkConfig& landmark) {
    Sheet sheet{.has_code = landmark.code.empty() || is_landmark_code(landmark.code)};
    if (!landmark.position_mm) return sheet;
    sheet.middle_mm = Eigen::Map<const Eigen::Vector3d>(landmark.position_mm->data());
    if (landmark.orientation_wxyz) {
      const auto& [w, x, y, z] = *landmark.orientation_wxyz;
      sheet.facing = Eigen::Quaterniond(w, x, y, z).normalized() * Eigen::Vector3d::UnitY();
    } else {
      sheet.facing = place_upright({}, landmark.heading_deg * kRadPerDeg).rotation * Eigen::Vector3d::UnitY();
    }
    return sheet;
  }

  /// Sheets edge to edge on a column's neighbouring faces, which look a degrees apart, have their middles
  /// side cos(a / 2) apart: the limit, of which this is the square. Those that look 90 degrees apart or more are not
  /// seen well from one place.
  bool is_one_place(const Sheet& a, const Sheet& b) const {
    const double cosine = a.facing.dot(b.facing);
    return cosine > 0 && (a.middle_mm - b.middle_mm).squaredNorm() < side_mm_ * side_mm_ * (1 + cosine) / 2;
  }

  static std::string dots(int turn) { return fmt::format("{} {}", turn, turn == 1 ? "dot" : "dots"); }
  void refuse(std::size_t i, const char* key, std::string what) {
    problems_.add(problems_.line_of(fmt::format("landmarks.{}.{}", i, key)), std::move(what));
  }

  const std::vector<MapLandmarkConfig>& landmarks_;
  const double side_mm_;
  ConfigProblems& problems_;
  std::vector<Sheet> sheets_;
  std::set<int> ids_;
};

}  // namespace

void check_landmarks(const Config& config, ConfigProblems& problems) {
  const std::vector<MapLandmarkConfig>& landmarks = config.landmarks;
  if (landmarks.size() > LandmarkMap::kCapacity)
    return problems.add(problems.line_of(fmt::format("landmarks.{}.id", LandmarkMap::kCapacity)),
                        fmt::format("more than {} landmarks", LandmarkMap::kCapacity));
  const bool is_room = landmarks.size() > 1 || (landmarks.size() == 1 && !is_black_and_white(landmarks.front().code));
  if (is_room && config.pose.solver == "ellipse")
    problems.add(
        problems.line_of("pose.solver"),
        "'solver' is 'ellipse', which serves one black-and-white landmark; write \"full\" for several or coded ones");
  MapCheck map(config, problems);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    map.check_id(i);
    map.check_code(i);
    map.check_place(i);
    LandmarkCheck(landmarks[i], i, problems).check_place();
  }
}

void check_outputs(const Config& config, ConfigProblems& problems) {
  const auto has_place = [](const MapLandmarkConfig& landmark) { return landmark.position_mm.has_value(); };
  if (config.outputs.pose == "body_in_world" && std::ranges::none_of(config.landmarks, has_place))
    problems.add(problems.line_of("outputs.pose"),
                 "'pose' is 'body_in_world', and no landmark has a place in the world: write 'position_mm' in "
                 "[[landmarks]], or a 'map'");
  const int followed = config.pan_tilt.landmark_id;
  const bool is_there = config.landmarks.empty()
                            ? followed == 0
                            : std::ranges::any_of(config.landmarks, [&](const MapLandmarkConfig& landmark) {
                                return landmark.id == followed;
                              });
  if (config.pan_tilt.driver != "none" && config.pan_tilt.landmark == "id" && !is_there)
    problems.add(
        problems.line_of("pan_tilt.landmark_id"),
        fmt::format("'landmark_id' is {}, and no landmark has that 'id': the head would follow none", followed));
}

}  // namespace ninedot
