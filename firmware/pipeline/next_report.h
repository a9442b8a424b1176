#pragma once
/// The one place where reports are made: each follows from the one before it and from what is new. Nothing is changed
/// in a report afterwards.
#include "aim/head_snapshot.h"
#include "geometry/body.h"
#include "pipeline/frame_processor.h"

namespace ninedot {

/// What goes into a report beside the frame.
struct ReportContext {
  MonoTime now{};                      ///< when the report will be published
  const HeadSnapshot* head = nullptr;  ///< null: there is no head; the angles are then those of the frame
  std::uint32_t dropped_before = 0;    ///< frames lost since the one before
  const BodyGeometry* body = nullptr;  ///< where the camera sits; null: it is the body, and looks along its x
};

/// After a frame. When nothing was found the pose of `before` stays, with valid = false and the reason. A frame whose
/// size is wrong counts as failed, every other one as processed. Memory: none. Threads: pure; the frame loop's.
Report next_report(const Report& before, const Frame& frame, const Fix& fix, const ReportContext& context) noexcept;

/// For tables: the report of a frame with what that frame says of one landmark in place of the last valid pose,
/// whatever its verdict. \param report  what next_report said of the same frame in the same context
Report with_pose_of(const Report& report, const Frame& frame, const LandmarkFix& landmark,
                    const ReportContext& context) noexcept;

/// Where there was no frame: the pose stays, everything that calls it fresh goes.
/// \param reason  not kNone (contract). Unreadable frames and those of a wrong size are counted.
Report report_of_failure(const Report& before, Reason reason, const ReportContext& context) noexcept;

/// Where there was nothing at all: the same report with what the head does now. `before` is not valid (contract): the
/// angles of a valid one are those of its exposure.
Report report_of_head(const Report& before, const ReportContext& context) noexcept;

}  // namespace ninedot
