#pragma once
/// Views for a calibration out of what a camera shows while somebody moves the sheet, or the camera.
#include <cstddef>
#include <span>

#include "calibrate_camera/sheet_finder.h"
#include "calibrate_camera/view_collection.h"

namespace ninedot {

/// What became of a picture.
enum class Looked {
  kNoSheet,     ///< it shows none
  kMoving,      ///< the sheet was elsewhere a moment ago: motion blurs it, and a rolling shutter shears it
  kSeenBefore,  ///< it stands still where a view was taken
  kBlurred,     ///< its outlines can't be measured
  kTaken,
};

/// Takes a view where the sheet stands still, is sharp, and is seen otherwise than in all views before. Bounded: no
/// more views than ViewCollection keeps, each as large as a picture at most. Threads: one caller.
class ViewGatherer {
 public:
  /// \param width_px  of the pictures
  ViewGatherer(int width_px, std::span<const PlaneDisc> discs);

  /// \param luma  the next picture of the camera, some may be left out in between
  Looked look(SheetFinder& finder, const ImageView& luma, SensorKind sensor);

  const std::vector<SheetView>& views() const noexcept { return views_.views(); }
  const ViewCollection& collection() const noexcept { return views_; }
  /// Number of pictures in which the sheet was found.
  std::size_t found() const noexcept { return found_; }
  /// What the newest picture shows of the sheet; empty: nothing.
  std::span<const SeenDisc> newest() const noexcept { return newest_; }

 private:
  double still_px_;
  std::span<const PlaneDisc> discs_;
  ViewCollection views_;
  std::vector<SeenDisc> newest_;
  std::size_t found_ = 0;
  int still_ = 0;  ///< how many pictures in a row show it where the one before does
};

}  // namespace ninedot
