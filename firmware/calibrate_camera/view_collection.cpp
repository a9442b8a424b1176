#include "calibrate_camera/view_collection.h"

#include <algorithm>
#include <utility>

namespace ninedot {

bool ViewCollection::is_new(const SheetView& view) const {
  return std::ranges::none_of(views_, [&](const SheetView& kept) { return distance_px(kept, view) < spacing_px_; });
}

bool ViewCollection::add(SheetView view) {
  ++found_;
  if (!is_new(view)) return false;
  views_.push_back(std::move(view));
  while (views_.size() > kMost) {
    spacing_px_ *= 1.25;
    std::vector<SheetView> all = std::exchange(views_, {});
    for (SheetView& one : all)
      if (is_new(one)) views_.push_back(std::move(one));
  }
  return true;
}

}  // namespace ninedot
