#pragma once
/// The views that a calibration is made of, out of many pictures.
#include <cstddef>
#include <vector>

#include "calibrate_camera/sheet_view.h"

namespace ninedot {

/// Keeps views that differ from all before: a sheet that stands still says nothing new. Bounded: when there are more
/// than kMost, those that are nearest to others go. Threads: one caller.
class ViewCollection {
 public:
  static constexpr std::size_t kMost =
      150;  ///< number of views [1]: sigmas fall with the root of their number; 60 are plenty

  /// \param width_px  of the pictures: views differ when their discs are an eightieth of it apart on average
  explicit ViewCollection(int width_px) : spacing_px_(width_px / 80.0) {}

  /// Whether its discs are elsewhere than in all views that were kept; what the picture shows beside them does not
  /// count.
  bool is_new(const SheetView& view) const;
  /// \return  whether it was kept
  bool add(SheetView view);

  /// Number of pictures in which the sheet was found, kept or not.
  std::size_t found() const noexcept { return found_; }
  const std::vector<SheetView>& views() const noexcept { return views_; }

 private:
  double spacing_px_;
  std::size_t found_ = 0;
  std::vector<SheetView> views_;
};

}  // namespace ninedot
