#include "pose/blurred_disc.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/vector_clones.h"
#include "pose/normal_tail.h"

namespace ninedot {
namespace {

// Sigmas of the blur from node to node: the trapezoidal rule leaves 2e-4 of the contrast (blurred_disc_test.cpp).
// What is laid over itself along a smear needs no more than two.
constexpr double kSpacing = 1.3, kSmearedSpacing = 2;
constexpr std::size_t kLeastNodes = 6;
// More than these cost more than a profile across the outline. Where the tone curve is fitted they are worth it: what a
// profile is off by looks like a curve, and steps go to and fro. Without the curve they are worth nothing, for its bend
// and the profile's error are alike, and of opposite signs.
constexpr std::size_t kUsualNodes = 13;
constexpr double kLeastPart = 0.1;  // of an outline's length: what no offset takes away
// Below a pixel's own 1/12 and a bit, an edge is no Gaussian's (outline_columns.cpp has the same).
constexpr double kLeastVariance_px2 = 0.1;
constexpr float kSeenSigmas = 3.5F;  // beyond the outline: 2e-4 of its ink
constexpr float kNotAtNode = 1e-4F;  // keeps (1 - exp(-t)) / t finite and exact to a float at a node itself

/// From pixels to sigmas of the blur: the inverse of its covariance's Cholesky factor.
Eigen::Matrix2d sigma_per_px(const Smear& smear) noexcept {
  const double xx = std::max(smear.blur_px2 + smear.cos_px2, kLeastVariance_px2), xy = smear.sin_px2;
  const double x = std::sqrt(xx), yx = xy / x;
  const double y = std::sqrt(std::max(smear.blur_px2 - smear.cos_px2 - yx * yx, kLeastVariance_px2));
  Eigen::Matrix2d W;
  W << 1 / x, 0, -yx / (x * y), 1 / y;
  return W;
}

}  // namespace

BlurredDisc::BlurredDisc(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state,
                         std::size_t dot, Asked asked) noexcept {
  const CameraFromLandmark& T = state.T_camera_landmark;
  const Eigen::Vector3d X = T.rotation.col(0), n = T.rotation.col(1), Z = T.rotation.col(2);
  const Eigen::Vector2d C = landmark.centre_m(dot);
  const double r_m = landmark.radius_m(dot);
  const Eigen::Vector3d middle_m = T.translation_m + C.x() * X + C.y() * Z;
  middle_ray_ = middle_m.hnormalized().cast<float>();
  const Eigen::Vector2d middle = middle_ray_.cast<double>();  // the nodes are beside it as it is rounded
  const Eigen::Matrix2d px_per_ray = pixels.normalised_per_px[dot].inverse();
  const Smear smear(state);
  const Eigen::Matrix2d W = sigma_per_px(smear);
  // How a ray moves when the sheet's point does.
  const auto ray_by = [](const Eigen::Vector3d& p_m, const Eigen::Vector3d& move) -> Eigen::Vector2d {
    return (move.head<2>() - p_m.hnormalized() * move.z()) / p_m.z();
  };
  Eigen::Matrix2d circle;
  circle << W * px_per_ray * ray_by(middle_m, r_m * X), W * px_per_ray * ray_by(middle_m, r_m * Z);
  const double semi_major = std::sqrt(
      0.5 * (circle.squaredNorm() +
             std::sqrt(std::max(std::pow(circle.squaredNorm(), 2) - 4 * std::pow(circle.determinant(), 2), 0.0))));
  const double wanted = 2 * std::numbers::pi * semi_major / (smear.parts > 1 ? kSmearedSpacing : kSpacing);
  const std::size_t most = smear.parts > 1 ? kSmearedNodes : pixels.has_tone ? kMostNodes : kUsualNodes;
  if (!(wanted <= static_cast<double>(most))) return;
  count_ = std::max(kLeastNodes, static_cast<std::size_t>(std::ceil(wanted)));
  sigma_per_ray_ = (W * px_per_ray).cast<float>();

  const double step = 2 * std::numbers::pi / static_cast<double>(count_);
  const double area_px2 = std::abs(circle.determinant() / W.determinant());  // over pi: curvature times speed^3
  const double turns = circle.determinant() > 0 ? 1 : -1;  // which way round the angle goes in the picture
  const double share = 1 / static_cast<double>(smear.parts);
  const double per_area = share * W.determinant() / (2 * std::numbers::pi);
  const Eigen::Vector2d along_line = smear.line_px.normalized(), across_line(-along_line.y(), along_line.x());
  const Eigen::Rotation2Dd on(step);
  Eigen::Vector2d angle(1, 0);  // its cosine and sine
  for (std::size_t i = 0; i < count_; ++i, angle = on * angle) {
    Node& node = nodes_[i];
    const double cos = angle.x(), sin = angle.y();
    const double x_m = C.x() + r_m * cos, z_m = C.y() + r_m * sin;
    const Eigen::Vector3d p_m = T.translation_m + x_m * X + z_m * Z;
    // In pixels from the dot's middle.
    Eigen::Vector2d along_px = turns * step * (px_per_ray * ray_by(p_m, r_m * (cos * Z - sin * X)));
    const Eigen::Vector2d outwards_px = Eigen::Vector2d(along_px.y(), -along_px.x()).normalized();
    if (pixels.has_tone)
      along_px *= std::max(1 + state.offset_px * area_px2 / std::pow(along_px.norm() / step, 3), kLeastPart);
    const Eigen::Vector2d at_px = px_per_ray * (p_m.hnormalized() - middle) + state.offset_px * outwards_px;
    const Eigen::Vector2d at = W * at_px, part = W * along_px;
    node.x = static_cast<float>(at.x()), node.y = static_cast<float>(at.y());
    node.part_x = static_cast<float>(share * part.x() / (4 * std::numbers::pi));
    node.part_y = static_cast<float>(share * part.y() / (4 * std::numbers::pi));
    if (asked == Asked::kLightOnly) continue;

    const Eigen::Vector2d across_px(along_px.y(), -along_px.x());  // outwards, as long as the part
    const double out = per_area * along_px.norm();                 // swept by a move outwards
    if (asked == Asked::kState) {
      // Swept by a move of the sheet's point: of its ray across the part.
      const Eigen::Vector2d per_ray = per_area / p_m.z() * px_per_ray.transpose() * across_px;
      const Eigen::Vector3d per_move(per_ray.x(), per_ray.y(), -per_ray.dot(p_m.hnormalized()));
      const double by_X = per_move.dot(X), by_n = per_move.dot(n), by_Z = per_move.dot(Z);
      const std::array<double, kMoveColumns> moves{
          -z_m / kLever_m * by_n, (z_m * by_X - x_m * by_Z) / kLever_m, x_m / kLever_m * by_n, by_X, by_n, by_Z, out};
      std::ranges::transform(moves, node.moves.begin(), [](double move) { return static_cast<float>(move); });
    } else {
      const double cos2 = cos * cos - sin * sin, sin2 = 2 * cos * sin;
      const std::array<double, kMoveColumns> harmonics{
          1, cos, sin, cos2, sin2, cos2 * cos2 - sin2 * sin2, 2 * cos2 * sin2};
      std::ranges::transform(harmonics, node.moves.begin(),
                             [&](double harmonic) { return static_cast<float>(harmonic * out); });
    }
    // More blur along x, along y and across: half of the second derivatives (the heat equation).
    const std::array<Eigen::Vector2d, kBlurColumns> blur{W * across_px,
                                                         W * Eigen::Vector2d(across_px.x(), -across_px.y()),
                                                         W * Eigen::Vector2d(across_px.y(), across_px.x())};
    for (std::size_t k = 0; k < kBlurColumns; ++k) {
      node.blur_x[k] = static_cast<float>(0.5 * per_area * blur[k].x());
      node.blur_y[k] = static_cast<float>(0.5 * per_area * blur[k].y());
    }
    if (smear.parts == 1) continue;
    node.longer = static_cast<float>(per_area * across_px.dot(along_line));
    node.turned = static_cast<float>(per_area * across_px.dot(across_line));
  }
  smear_nodes(smear, (W * smear.line_px / static_cast<double>(smear.parts)).cast<float>());
}

/// The outline once for each part of a smear.
void BlurredDisc::smear_nodes(const Smear& smear, const Eigen::Vector2f& from_part_to_part) noexcept {
  const std::size_t of_one = count_, parts = smear.parts;
  is_line_ = parts > 1;
  if (is_line_) {
    // A line of L px at an angle a has the harmonic L^2 / 24 at 2 a; its parts are blurred by what is left of that.
    const double length_px = smear.line_px.norm(), per_length = 12 / length_px;
    const double cos = smear.line_px.x() / length_px, sin = smear.line_px.y() / length_px;
    const double cos2 = cos * cos - sin * sin, sin2 = 2 * cos * sin;
    const double left = 1 / static_cast<double>(parts * parts);
    const auto by = [&](double in_line, double aside) -> ByHarmonic {
      return {static_cast<float>(per_length * in_line), static_cast<float>(per_length * aside),
              static_cast<float>((left - 1) * in_line), static_cast<float>(left)};
    };
    by_harmonic_ = {by(cos2, -sin2), by(sin2, cos2)};
  }
  for (std::size_t part = parts; part-- > 0;) {  // the first one, which the others are copied from, at last
    const float parts_on = static_cast<float>(part) - 0.5F * static_cast<float>(parts - 1);
    const float share_on = parts_on / static_cast<float>(parts);
    const Eigen::Vector2f by = parts_on * from_part_to_part;
    for (std::size_t i = 0; i < of_one; ++i) {
      Node& node = nodes_[part * of_one + i];
      node = nodes_[i];
      node.x += by.x(), node.y += by.y();
      node.longer *= share_on, node.turned *= share_on;
    }
  }
  count_ = parts * of_one;
  reach_.setZero();
  for (std::size_t i = 0; i < count_; ++i)
    reach_ = reach_.cwiseMax(Eigen::Vector2f(std::abs(nodes_[i].x), std::abs(nodes_[i].y)));
}

bool BlurredDisc::reaches_any(const Lanes& ray_x, const Lanes& ray_y) const noexcept {
  const float xx = sigma_per_ray_(0, 0), xy = sigma_per_ray_(0, 1), yx = sigma_per_ray_(1, 0),
              yy = sigma_per_ray_(1, 1), middle_x = middle_ray_.x(), middle_y = middle_ray_.y();
  const float most_x = reach_.x() + kSeenSigmas, most_y = reach_.y() + kSeenSigmas;
  std::int32_t reached = 0;  // all lanes at once, without a branch
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float rx = ray_x[l] - middle_x, ry = ray_y[l] - middle_y;
    const float x = xx * rx + xy * ry, y = yx * rx + yy * ry;
    reached |= static_cast<std::int32_t>(x * x < most_x * most_x) & static_cast<std::int32_t>(y * y < most_y * most_y);
  }
  return reached != 0;
}

template <bool kWithShare, bool kWithMoves, bool kWithBlur, bool kWithLine>
void BlurredDisc::sum_up(const Lanes& ray_x, const Lanes& ray_y, Lanes* share,
                         std::array<Lanes, kMoveColumns>* by_moves,
                         std::array<Lanes, kBlurColumns>* by_blur) const noexcept {
  const float xx = sigma_per_ray_(0, 0), xy = sigma_per_ray_(0, 1), yx = sigma_per_ray_(1, 0),
              yy = sigma_per_ray_(1, 1), middle_x = middle_ray_.x(), middle_y = middle_ray_.y();
  Lanes x, y;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float rx = ray_x[l] - middle_x, ry = ray_y[l] - middle_y;
    x[l] = xx * rx + xy * ry, y[l] = yx * rx + yy * ry;
  }
  Lanes sum{};
  std::array<Lanes, kMoveColumns> moves{};
  std::array<Lanes, kBlurColumns> blur{};
  Lanes longer{}, turned{};
  for (std::size_t i = 0; i < count_; ++i) {
    const Node node = nodes_[i];  // a copy: by reference the loops over lanes become no vector instructions
    Lanes weight, along_x, along_y;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float dx = node.x - x[l], dy = node.y - y[l], t = 0.5F * (dx * dx + dy * dy) + kNotAtNode;
      const float e = exp_of_negative(-t);
      if constexpr (kWithShare) sum[l] += (1 - e) / t * (dx * node.part_y - dy * node.part_x);
      weight[l] = e, along_x[l] = e * dx, along_y[l] = e * dy;
    }
    if constexpr (kWithMoves)
      for (std::size_t c = 0; c < kMoveColumns; ++c)
        for (std::size_t l = 0; l < kLanes; ++l) moves[c][l] -= weight[l] * node.moves[c];
    if constexpr (kWithBlur)
      for (std::size_t k = 0; k < kBlurColumns; ++k)
        for (std::size_t l = 0; l < kLanes; ++l)
          blur[k][l] += along_x[l] * node.blur_x[k] + along_y[l] * node.blur_y[k];
    if constexpr (kWithLine)
      for (std::size_t l = 0; l < kLanes; ++l)
        longer[l] -= weight[l] * node.longer, turned[l] -= weight[l] * node.turned;
  }
  if constexpr (kWithLine)
    for (std::size_t k = 0; k < by_harmonic_.size(); ++k)
      for (std::size_t l = 0; l < kLanes; ++l)
        blur[k + 1][l] = by_harmonic_[k].longer * longer[l] + by_harmonic_[k].turned * turned[l] +
                         by_harmonic_[k].mean * blur[0][l] + by_harmonic_[k].harmonic * blur[k + 1][l];
  if constexpr (kWithShare) *share = sum;
  if constexpr (kWithMoves) *by_moves = moves;
  if constexpr (kWithBlur) *by_blur = blur;
}

NINEDOT_VECTOR_CLONES
void BlurredDisc::ink_share(const Lanes& ray_x, const Lanes& ray_y, Lanes& share) const noexcept {
  sum_up<true, false, false, false>(ray_x, ray_y, &share, nullptr, nullptr);
}

NINEDOT_VECTOR_CLONES
void BlurredDisc::ink_share(const Lanes& ray_x, const Lanes& ray_y, Lanes& share,
                            std::array<Lanes, kMoveColumns>& by_moves,
                            std::array<Lanes, kBlurColumns>& by_blur) const noexcept {
  if (is_line_)
    sum_up<true, true, true, true>(ray_x, ray_y, &share, &by_moves, &by_blur);
  else
    sum_up<true, true, true, false>(ray_x, ray_y, &share, &by_moves, &by_blur);
}

NINEDOT_VECTOR_CLONES
void BlurredDisc::ink_by_blur(const Lanes& ray_x, const Lanes& ray_y,
                              std::array<Lanes, kBlurColumns>& by_blur) const noexcept {
  sum_up<false, false, true, false>(ray_x, ray_y, nullptr, nullptr, &by_blur);
}

}  // namespace ninedot
