// The picture speaks of the six freedoms of the pose only. So the crest is sought in those, under the marginal of the
// prediction; the velocities follow by what they have in common with the pose. That is the same as one solution in
// twelve unknowns, with decompositions of 6 x 6.
#include "track/pose_mode.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

namespace ninedot {
namespace {

/// L with L L^T = covariance of the push N^-1 pushes by, N the information that makes the gain: of the picture's whole
/// uncertainty, in units of the sightings' sigma and beyond it, all that is not its own.
PoseInformation common_push(const Crest& crest, const ErrorShares& shares) noexcept {
  const PoseInformation& soft = crest.fit.sum.normal;
  const PoseInformation own = soft * root_of(crest.fit.with_exact_places).solve(soft);
  const PoseInformation common = (shares.own + shares.common) * soft - shares.own * (own + own.transpose()) / 2;
  return root_of(common / (shares.own * shares.own)).matrixL();
}

}  // namespace

std::optional<ForetoldPose> foretold_pose(const PoseMode& mode) noexcept {
  const Eigen::LLT<PoseInformation> root = PoseInformation(mode.covariance.topLeftCorner<6, 6>()).llt();
  if (root.info() != Eigen::Success) return {};
  return ForetoldPose{.T_world_camera = mode.motion.T_world_camera,
                      .information = root.solve(PoseInformation::Identity()),
                      .log_density = -root.matrixLLT().diagonal().array().log().sum(),
                      .covariance = mode.whole_covariance().topLeftCorner<6, 6>()};
}

void PoseMode::predict(double dt_s, const MotionNoise& noise, double common_lasts_s) noexcept {
  const MotionPrediction prediction(motion, dt_s);
  covariance = prediction.covariance(covariance, noise);
  common_covariance = prediction.covariance(common_covariance, {});
  common_cross = std::exp(-dt_s / common_lasts_s) * prediction.carried<6>(common_cross);
  motion = prediction.motion();
}

// Moments of a normal distribution cut off at one side: N. L. Johnson, S. Kotz, N. Balakrishnan, "Continuous Univariate
// Distributions" 1, Wiley 1994, section 13.10.1.
std::optional<std::array<PoseMode, 2>> PoseMode::halved(const Eigen::Vector3d& point_m, const Eigen::Vector3d& across,
                                                        double least_weight) const noexcept {
  const double mean_m = across.dot(motion.T_world_camera.translation_m - point_m);
  const double sigma_m = std::sqrt(across.dot(covariance.topLeftCorner<3, 3>() * across));
  const double beyond = std::erfc(std::abs(mean_m) / sigma_m / std::numbers::sqrt2) / 2;
  if (!(beyond > least_weight)) return {};
  const MotionStep gain = covariance.leftCols<3>() * across / (sigma_m * sigma_m);
  std::array<PoseMode, 2> halves{*this, *this};
  for (const bool is_beyond : {false, true}) {
    PoseMode& half = halves[is_beyond ? 1 : 0];
    const double share = is_beyond ? beyond : 1 - beyond, sign = (mean_m < 0) == is_beyond ? 1 : -1;
    const double cut = -sign * mean_m / sigma_m;  // in sigmas from the middle
    const double hazard = std::exp(-cut * cut / 2) / std::sqrt(2 * std::numbers::pi) / share;
    half.motion = moved_by(motion, sign * sigma_m * hazard * gain);
    half.covariance -= sigma_m * sigma_m * hazard * (hazard - cut) * gain * gain.transpose();
    half.log_motion += std::log(share);
  }
  return halves;
}

// With P the covariance before, G = P(:, pose) P(pose, pose)^-1 carries what is learnt of the pose to all twelve.
// The picture's common error u, of unit covariance, pushes by L u: errors become (1 - M N) error + M L u, with M the
// new covariance's columns of the pose.
void PoseMode::settle(const Crest& crest, const ErrorShares& shares) noexcept {
  const Eigen::Matrix<double, 6, 12> P_rows = covariance.topRows<6>();
  const Eigen::Matrix<double, 12, 6> G = PoseInformation(P_rows.leftCols<6>()).llt().solve(P_rows).transpose();
  const MotionStep step = G * crest.moved;
  const Eigen::Matrix<double, 12, 6> M = G * crest.covariance;
  // What the pose does not tell of the velocities, and what it does. The difference of whole covariances would lose the
  // digits that a well known pose leaves.
  PoseInformation speeds = covariance.bottomRightCorner<6, 6>() - G.bottomRows<6>() * P_rows.rightCols<6>();
  speeds += M.bottomRows<6>() * G.bottomRows<6>().transpose();
  covariance.topLeftCorner<6, 6>() = crest.covariance;
  covariance.bottomLeftCorner<6, 6>() = M.bottomRows<6>();
  covariance.topRightCorner<6, 6>() = M.bottomRows<6>().transpose();
  covariance.bottomRightCorner<6, 6>() = (speeds + speeds.transpose()) / 2;
  motion.T_world_camera = crest.T_world_camera;
  motion.velocity_m_s += step.segment<3>(6);
  motion.angular_velocity_rad_s += step.tail<3>();

  const Eigen::Matrix<double, 12, 6> MN = M * (crest.fit.sum.normal / shares.own);
  const Eigen::Matrix<double, 12, 6> pushed = M * common_push(crest, shares);
  common_covariance -= MN * common_covariance.topRows<6>();
  common_covariance -= common_covariance.leftCols<6>() * MN.transpose();
  common_cross -= MN * common_cross.topRows<6>();
  const MotionCovariance both = common_cross * pushed.transpose();
  common_covariance += both + both.transpose() + pushed * pushed.transpose();
  common_cross += pushed;
}

PoseMode mode_at_rest(const Crest& crest, std::size_t turn, const ErrorShares& shares, double speed_sigma_m_s,
                      double turning_sigma_rad_s) noexcept {
  PoseMode mode;
  mode.motion.T_world_camera = crest.T_world_camera;
  mode.turn = turn;
  mode.covariance.topLeftCorner<6, 6>() = crest.covariance;
  mode.covariance.diagonal().segment<3>(6).setConstant(speed_sigma_m_s * speed_sigma_m_s);
  mode.covariance.diagonal().tail<3>().setConstant(turning_sigma_rad_s * turning_sigma_rad_s);
  mode.common_cross.topRows<6>() = crest.covariance * common_push(crest, shares);
  mode.common_covariance = mode.common_cross * mode.common_cross.transpose();
  return mode;
}

}  // namespace ninedot
