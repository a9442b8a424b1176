#pragma once
/// How `ninedot calibrate camera` fares, for another program: a line of JSON for each piece of news.
/// docs/calibrating.md has the table.
#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/mono_time.h"
#include "calibrate_camera/lens_calibration.h"
#include "programs/commands/gathering_view.h"

namespace ninedot {

/// Where somebody should hold the sheet.
struct SheetGhost {
  std::vector<std::string> meets;                      ///< names of the wanted views that it gives
  std::vector<std::vector<Eigen::Vector2d>> outlines;  ///< as outlines_of has them [px]
};

/// Five lines a second at most, but for the last one and for views that were taken. Each is written whole, and waits
/// for whoever reads. Threads: one caller.
class CalibrationNews {
 public:
  /// \param fd  open for as long as this is
  explicit CalibrationNews(int fd) noexcept : fd_(fd) {}

  /// Whether anything would be said now; spares whoever makes it.
  bool is_due() const noexcept;
  /// \param sheet_px  border of the sheet in the newest picture; empty: it shows none
  void gathering(const GatheringState& state, std::span<const Eigen::Vector2d> sheet_px, const SheetGhost& ghost);
  void working(std::string_view what);
  /// \param out, picture  the files; picture is empty where there is none
  void done(const LensCalibration& result, const std::vector<std::string>& lines, const std::string& out,
            const std::string& picture);
  void failed(std::string_view why);

  /// Nobody reads any more: there is no reason to go on.
  bool is_broken() const noexcept { return is_broken_; }

 private:
  void say(std::string line);

  int fd_;
  bool is_broken_ = false;
  MonoTime said_at_{};
};

}  // namespace ninedot
