#pragma once
/// What one picture says of the time from row to row, by all landmarks that it shows.
///
/// A row time that is far off makes landmarks in different rows contradict each other, and the world solver leaves one
/// of them out as moved, or can't tell which. So all are asked: where a row time makes them agree they are believed,
/// and that row time with them. A sheet that was moved is not explained so: its place is off in six freedoms, a row
/// time has one.
#include <array>
#include <optional>

#include "base/inline_vector.h"
#include "pipeline/sighting_uncertainty.h"
#include "track/pose_filter.h"
#include "world/row_time_equations.h"

namespace ninedot {

/// Memory: none. Threads: one caller.
class PictureRowTime {
 public:
  /// \param tracked  the camera, this picture included: how it moves, where that is known better than by the forecasts
  /// that the fits took; null: it is not. All must outlive it.
  PictureRowTime(const TrackedPose* tracked, const LandmarkGeometry& landmark, const CameraModel& camera) noexcept
      : tracked_(tracked), landmark_(landmark), camera_(camera) {}

  /// A landmark in the picture; kMaxSightings at most, others are not asked.
  /// \param sighting  with its dots as the picture shows them: nothing that was done to them for the row time's sake
  /// \param taken_by  what its dots were taken to the middle row with
  /// \param T_world_landmark  its place \param place_covariance  of that, as JointMember has it [m^2, m rad, rad^2]
  /// \param is_used  the camera's place is made of it
  void add(const LandmarkSighting& sighting, const SheetMotion& taken_by, const WorldFromLandmark& T_world_landmark,
           const PoseCovariance* place_covariance, bool is_used) noexcept;

  /// \param T_world_camera  where the camera is, by those that are used; none: nowhere that may be acted on
  /// \return  none: they say nothing
  std::optional<RowTimeEvidence> evidence(const std::optional<WorldFromCamera>& T_world_camera) const noexcept;

 private:
  struct Member {
    LandmarkSighting sighting;
    SheetMotion taken_by, motion;  ///< motion: how its sheet moved
    WorldFromLandmark T_world_landmark;
    const PoseCovariance* place_covariance = nullptr;
    bool is_used = false;
    double alone_chi2 = 0;               ///< at its own best pose [1]
    double moved_1_s2 = 0, unsure_1_s2;  ///< squared speed of its ray, and its variance
  };
  std::optional<RowTimeEvidence> evidence_at(const WorldFromCamera& T_world_camera, bool of_all) const noexcept;
  bool explains_each(const WorldFromCamera& T_world_camera, const RowTimeEvidence& evidence) const noexcept;
  std::optional<RowTimeEvidence> evidence_that_explains_all(const WorldFromCamera& start) const noexcept;

  const TrackedPose* tracked_;
  const LandmarkGeometry& landmark_;
  const CameraModel& camera_;
  InlineVector<Member, kMaxSightings> members_;
};

/// What an uncertain row time adds to the covariance of one landmark's pose: the pose moves with the row time that its
/// dots were taken to the middle row with. \param sigma_s  1-sigma of it; 0: it adds nothing
/// \return  of a PoseStep [m^2, m rad, rad^2]; zero also where its dots determine no pose
PoseInformation row_time_share(const LandmarkSighting& sighting, const SheetMotion& taken_by, double sigma_s,
                               const LandmarkGeometry& landmark, const CameraModel& camera) noexcept;

}  // namespace ninedot
