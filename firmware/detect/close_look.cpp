#include "detect/close_look.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/contract.h"
#include "detect/homography.h"
#include "image/pyramid.h"

namespace ninedot {
namespace {

/// P9's semi-major axis with its blur, where the ring's dots are 2 to 4 px across.
constexpr float kLeast_px = 1.7F, kMost_px = 5;
/// Of that axis: the outermost outlines lie at 3.65 radii of P9, and blur makes the axis longer.
constexpr float kReach = 4.2F;
constexpr int reach_of(float semi_major_px) noexcept { return static_cast<int>(kReach * semi_major_px) + 2; }
/// More than any window has, for BlobFinder goes on where it ended in what is as large as it was made for.
constexpr int kSide_px = 4 * reach_of(kMost_px) + 2;
/// Of the paper's grey level, between P9's middle and the paper around it. Ink has three quarters, of which
/// 1 - exp(-1/2) = 0.39 are left in the middle of a disc under a blur of its own radius.
constexpr int kInkShare = 4;

}  // namespace

CloseLook::CloseLook(const LandmarkGeometry& landmark)
    : landmark_(landmark), window_(kSide_px, kSide_px), finder_(kSide_px, kSide_px) {}

bool CloseLook::may_be_centre(const ImageView& luma, const Blob& blob) const noexcept {
  const float semi_major_px = blob.semi_major_px();
  if (semi_major_px < kLeast_px || semi_major_px > kMost_px) return false;
  // A disc's second moments are a quarter of its radius squared.
  const Eigen::Matrix2d axes_px = 2 * Eigen::LLT<Eigen::Matrix2d>(blob.moments_px2()).matrixL().toDenseMatrix();
  const Eigen::Vector2d middle_px(blob.x_px, blob.y_px);
  const auto grey_at = [&](const Eigen::Vector2d& px) {
    const auto x = static_cast<int>(std::lround(px.x())), y = static_cast<int>(std::lround(px.y()));
    return luma.contains(x, y) ? static_cast<int>(luma.at(x, y)) : 0;
  };
  // Halfway between P9's outline and those of the ring's dots.
  const double blank = 0.5 * (1 + (landmark_.ring_radius_m - landmark_.dot_radius_m) / landmark_.centre_radius_m);
  constexpr int kDirections = 8;
  int paper = 255;
  for (int i = 0; i < kDirections; ++i) {
    const double a_rad = i * 2 * std::numbers::pi / kDirections;
    paper = std::min(paper, grey_at(middle_px + blank * axes_px * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad))));
  }
  return paper - grey_at(middle_px) > paper / kInkShare;
}

BlobList& CloseLook::blobs_around(const ImageView& luma, const Blob& centre, WorkBudget& budget) noexcept {
  EXPECTS(centre.semi_major_px() <= kMost_px);
  const int reach_px = reach_of(centre.semi_major_px());
  const int left = std::max(static_cast<int>(centre.x_px) - reach_px, 0);
  const int top = std::max(static_cast<int>(centre.y_px) - reach_px, 0);
  const ImageView window{luma.row(top) + left, std::min(2 * reach_px, luma.width_px - left),
                         std::min(2 * reach_px, luma.height_px - top), luma.stride_bytes};
  enlarge(window, window_);
  finder_.find_blobs(window_.view(), {0, 0}, blobs_, budget);
  for (Blob& blob : blobs_) {
    blob.x_px = 0.5F * (blob.x_px - 0.5F) + static_cast<float>(left);
    blob.y_px = 0.5F * (blob.y_px - 0.5F) + static_cast<float>(top);
    for (float* area_px2 : {&blob.area_px2, &blob.xx_px2, &blob.xy_px2, &blob.yy_px2}) *area_px2 *= 0.25F;
    blob.level = kEnlarged;
  }
  return blobs_;
}

void CloseLook::centre_blobs(const ImageView& luma, const Hypothesis& guess) noexcept {
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (guess.blob[dot] >= 0) centre_blob(luma, guess, dot);
}

void CloseLook::centre_blob(const ImageView& luma, const Hypothesis& guess, std::size_t dot) noexcept {
  const Eigen::Matrix2d J = jacobian_of_map(guess.H_px_plane, landmark_.centre_m(dot));
  if (!(J.determinant() > 0)) return;
  const Eigen::Matrix2d to_plane = J.inverse();
  // Halfway to what is next: another dot of the ring, or from P9 the ring; and no further than the paper.
  const double reach_m = dot == kCentreDot
                             ? 0.5 * (landmark_.centre_radius_m + landmark_.ring_radius_m - landmark_.dot_radius_m)
                             : std::min(landmark_.ring_radius_m * std::sin(std::numbers::pi / kRingDotCount),
                                        landmark_.paper_radius_m() - landmark_.ring_radius_m);
  const Eigen::Vector2d half_px = reach_m * J.rowwise().norm();
  Blob& blob = blobs_[static_cast<std::size_t>(guess.blob[dot])];
  Eigen::Vector2d at(blob.x_px, blob.y_px);
  for (int round = 0; round < 2; ++round) {  // paper that is not quite white draws it to the window's middle
    const auto first_x = static_cast<int>(std::ceil(at.x() - half_px.x()));
    const auto first_y = static_cast<int>(std::ceil(at.y() - half_px.y()));
    const auto last_x = static_cast<int>(std::floor(at.x() + half_px.x()));
    const auto last_y = static_cast<int>(std::floor(at.y() + half_px.y()));
    if (!luma.contains(first_x, first_y) || !luma.contains(last_x, last_y)) return;
    int paper = 0, greys = 0, count = 0;
    Eigen::Vector2d places(0, 0), grey_places(0, 0);
    for (int y = first_y; y <= last_y; ++y)
      for (int x = first_x; x <= last_x; ++x) {
        const Eigen::Vector2d off(x - at.x(), y - at.y());
        if ((to_plane * off).squaredNorm() > reach_m * reach_m) continue;
        const int grey = luma.at(x, y);
        paper = std::max(paper, grey), greys += grey, ++count;
        places += off, grey_places += grey * off;
      }
    // Of the darkness, paper - grey, at each place.
    const int darkness = count * paper - greys;
    if (darkness <= 0) return;
    at += (paper * places - grey_places) / darkness;
  }
  blob.x_px = static_cast<float>(at.x()), blob.y_px = static_cast<float>(at.y());
}

}  // namespace ninedot
