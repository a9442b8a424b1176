#pragma once
/// The pixels along the outlines of the nine dots, gathered into groups that share their light.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/inline_vector.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "geometry/sheet_motion.h"
#include "geometry/transform.h"
#include "image/image_view.h"
#include "pose/light_edge.h"
#include "pose/ray_table.h"
#include "pose/tone.h"

namespace ninedot {

/// A whole small dot, or a stretch of a large dot's outline. Within it paper and ink are taken as constant (of a whole
/// dot: as sloping), so that light may change from group to group as it likes.
struct OutlineGroup {
  std::int32_t first = 0;  ///< index of its first pixel
  std::int32_t count = 0;
  std::uint8_t dot = 0;  ///< 0..7 = P1..P8, 8 = P9
  bool whole_dot = false;
  bool at_paper_edge = false;              ///< what lies beyond the sheet's white may reach into it
  float centre_x_px = 0, centre_y_px = 0;  ///< of its pixels
};

/// Whether a dot is one group or is cut into sectors.
enum class Cut : std::uint8_t {
  kBySize,   ///< large ones are cut, P9 sooner than the others, for it may be all that is in sight and be half hidden
  kWhole,    ///< crossed by a shadow's edge that is known: one group, P9 as well while it is no larger than the others
             ///< may be
  kSectors,  ///< crossed by edges that are not known: cut although it is small
};
using Cuts = std::array<Cut, kDotCount>;
inline constexpr double kWholeDotBelow_px = 12.0;  ///< semi-minor axis: no larger dot is one group

inline constexpr std::size_t kMaxSectors = 16;  ///< of one dot
inline constexpr std::size_t kMaxGroups = kDotCount * kMaxSectors;

inline constexpr float kUsualInkShare = 0.3F;  ///< of toner on paper, through an sRGB curve

/// Pixels as columns, for loops that the compiler can turn into vector instructions.
struct OutlinePixels {
  explicit OutlinePixels(std::size_t capacity);
  std::vector<float> x_px, y_px, ray_x, ray_y, luma;  ///< position, normalised ray (distortion removed), grey level
  std::size_t count = 0;
  int work_px = 0;  ///< that collecting them took, in pixels fitted to outlines [1]
  InlineVector<OutlineGroup, kMaxGroups> groups;
  /// Of each dot that is one group: the edge of a shadow that crosses it.
  std::array<std::optional<LightEdge>, kDotCount> light_edges;
  /// By how much ink's grey level changes where the light does, when paper's changes by 1.
  float ink_share = 0;
  /// [1] The same, also of a guess.
  float lit_ink() const noexcept { return ink_share > 0 ? ink_share : kUsualInkShare; }
  bool has_tone = false;                         ///< the tone curve is more than an offset of the outlines
  std::array<ToneBend, kDotCount> tone_bends{};  ///< how it bends each dot's grey levels then [1]
  /// d(ray)/d(pixel) at each dot's centre.
  std::array<Eigen::Matrix2d, kDotCount> normalised_per_px;
  /// A dot's pixels before they are sorted into its groups.
  struct Candidate {
    std::int16_t x, y;
    std::uint8_t sector;
  };
  std::vector<Candidate> candidates;
  bool has_pattern = false;  ///< ImageView::has_pattern of the picture
  /// What lies beyond the sheet may change along its side: another unknown of each small dot beside one. It takes out
  /// what many pictures of the same sheet have in common; a single one tells less by a few per cent.
  bool regards_walls = false;
  /// Motion smears small dots into each other (smeared_ink.h): what the others of them take off each pixel's grey level
  /// is to be put back. [LSB]
  bool are_smeared = false;
  /// `luma` is light, not grey levels (straighten_tone in tone.h): of a colour camera's smeared landmark.
  bool shows_light = false;
  std::vector<float> ink_of_others_lsb;
  int visible_outlines = 0;  ///< dots of which at least a part lies inside the picture
};

/// Collects the pixels within `band_px` of every dot's outline as the pose predicts it.
/// \param thinning  1 = every pixel, 2 = every second one, ...
/// \param cuts  of each dot
/// \param motion  of the sheet while the rows are exposed: rays are those that the pixels would have, had the sheet
/// stood where the pose says
/// Above the capacity of `out`, large dots are thinned to every second or third pixel instead of being cut off.
void collect_outline_pixels(const ImageView& luma, const CameraModel& camera, const RayTable& rays,
                            const LandmarkGeometry& landmark, const CameraFromLandmark& T_camera_landmark,
                            double band_px, int thinning, const Cuts& cuts, const SheetMotion& motion,
                            OutlinePixels& out) noexcept;

}  // namespace ninedot
