#pragma once
/// Whether views are enough for a calibration, and what is missing where they are not.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calibrate_camera/lens_calibration.h"

namespace ninedot {

/// Nine parts of a picture, row by row.
inline constexpr std::array<const char*, 9> kPartNames{"upper left", "top",    "upper right", "left", "middle", "right",
                                                       "lower left", "bottom", "lower right"};
/// Which of them a place belongs to; one beyond the border to the nearest.
std::size_t part_of(const Eigen::Vector2d& at_px, int width_px, int height_px);
/// Of how many views a disc's middle lies in each part.
std::array<int, 9> views_by_part(std::span<const SheetView> views, int width_px, int height_px);

/// What can be said before any lens is fitted: too few views, one place only, empty parts of the picture.
/// \param found  number of pictures that show the sheet, those that repeat others included
/// \return  a line each; none: go on
std::vector<std::string> what_views_lack(std::span<const SheetView> views, std::size_t found, int width_px,
                                         int height_px);

/// As the camera sees them: a sheet that is tilted to the right has its right side furthest away.
inline constexpr std::array<const char*, 4> kTiltNames{"tilted to the right", "tilted to the left", "tilted upwards",
                                                       "tilted downwards"};

/// Views, counted by what makes a calibration good.
struct ViewTally {
  std::size_t views = 0;       ///< number of them
  std::array<int, 9> parts{};  ///< as views_by_part
  std::array<int, kTiltNames.size()> tilts{};
  int near = 0;  ///< how many show the sheet as large as a third of the picture's height
};
ViewTally tally_of(std::span<const SheetView> views, std::span<const PlaneDisc> discs, int width_px, int height_px);

/// How many views there should be at least, in all and of each part of the picture: those of a good calibration, or
/// more where a lens has told that they are needed.
struct ViewGoals {
  std::size_t views = 30;  ///< number of them; sigmas fall with its root, so further ones are worth little [1]
  std::array<int, 9> parts{3, 3, 3, 3, 3, 3, 3, 3, 3};  ///< one might have a finger before the sheet
};

/// A kind of view of which there should be more.
struct Want {
  enum class Kind : std::uint8_t { kPart, kTilt, kNearer, kMore };
  Kind kind = Kind::kMore;
  std::size_t which = 0;  ///< of kPartNames or kTiltNames; of kMore how many
  friend bool operator==(const Want&, const Want&) = default;
};
/// "lower left", "tilted to the right", "nearer", "12 more".
std::string name_of(const Want& want);

/// Which views would make a calibration good, where what_views_lack says what it can't do without: somebody who moves
/// the sheet is told these.
/// \return  parts, tilts and nearness that lack some; kMore, alone, where none of these does; none: there are enough
std::vector<Want> wanted_views(const ViewTally& tally, const ViewGoals& goals = {});
/// Whether a view is of the wanted kind. \param view  tally of it alone
bool is_wanted(const Want& want, const ViewTally& view);

/// What the calibration itself says: a focal length or directions too uncertain, views that contradict each other.
/// \return  a line each; none: it may be used
std::vector<std::string> what_lens_lacks(const LensCalibration& calibration);

/// A part of the picture in which some directions are uncertain by more than a tenth of a pixel: of use, but more views
/// there, in its outer corner, would make it better.
struct UncertainPart {
  std::size_t part = 0;  ///< of kPartNames
  double sigma_px = 0;   ///< the largest there; infinite: the lens has no directions there
};
std::vector<UncertainPart> uncertain_parts(const LensCalibration& calibration);

}  // namespace ninedot
