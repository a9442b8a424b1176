#include "world/sighting_fit.h"

#include <limits>

#include "world/place_uncertainty.h"

namespace ninedot {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// The middle of a dot in the camera frame: affine in its place on the sheet. [m]
Eigen::Vector3d seen_from(const CameraFromLandmark& T, const Eigen::Vector2d& on_sheet_m) noexcept {
  return T.translation_m + on_sheet_m.x() * T.rotation.col(0) + on_sheet_m.y() * T.rotation.col(2);
}

}  // namespace

WorldFromCamera moved_by(const WorldFromCamera& T_world_camera, const PoseStep& step) noexcept {
  return {T_world_camera.rotation * exp_so3(step.tail<3>()), T_world_camera.translation_m + step.head<3>()};
}

PoseStep step_between(const WorldFromCamera& from, const WorldFromCamera& to) noexcept {
  PoseStep step;
  step << to.translation_m - from.translation_m, log_so3(from.rotation.transpose() * to.rotation);
  return step;
}

// The ray moves by -G/z R with the camera's position, and by G [(u, v, 1)]x with its rotation, G = (1 0 -u; 0 1 -v).
Eigen::Matrix<double, 2, 6> ray_by_step(const Eigen::Vector3d& p_camera_m,
                                        const Eigen::Matrix3d& R_world_camera) noexcept {
  const double per_z = 1 / p_camera_m.z(), u = p_camera_m.x() * per_z, v = p_camera_m.y() * per_z;
  Eigen::Matrix<double, 2, 3> G, by_turn;
  G << 1, 0, -u, 0, 1, -v;
  by_turn << u * v, -1 - u * u, v, 1 + v * v, -u * v, -u;
  Eigen::Matrix<double, 2, 6> by_step;
  by_step << -per_z * G.lazyProduct(R_world_camera.transpose()), by_turn;
  return by_step;
}

SightingFit& SightingFit::operator+=(const SightingFit& other) noexcept {
  chi2 += other.chi2;
  dots += other.dots;
  normal += other.normal;
  gradient += other.gradient;
  return *this;
}

SightingFit fit_of_sighting(const LandmarkSighting& sighting, const WorldFromLandmark& T_world_landmark,
                            const WorldFromCamera& T_world_camera, const LandmarkGeometry& landmark) noexcept {
  const CameraFromLandmark T_camera_landmark = T_world_camera.inverse() * T_world_landmark;
  // ray = (u, v) = (x/z, y/z). With G = (1 0 -u; 0 1 -v) it moves by -G/z per camera's position, in camera axes, and by
  // G [(u, v, 1)]x per rotation: all follows from A = G^T W G.
  double chi2 = 0;
  int dots = 0;
  Eigen::Matrix3d N_pp = Eigen::Matrix3d::Zero(), N_pr = N_pp, N_rr = N_pp;  // position, rotation
  Eigen::Vector3d g_p = Eigen::Vector3d::Zero(), g_r = g_p;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const DotSighting& seen = sighting.dots[dot];
    const Eigen::Matrix2d& W = seen.information;
    if (W(0, 0) == 0 && W(1, 1) == 0) continue;
    const Eigen::Vector3d p = seen_from(T_camera_landmark, landmark.centre_m(dot));
    if (!(p.z() > kNearestSeen_m)) return {.chi2 = kNever};
    const double per_z = 1 / p.z(), u = p.x() * per_z, v = p.y() * per_z;
    const Eigen::Vector2d residual = Eigen::Vector2d(u, v) - seen.ray;
    const Eigen::Vector2d Wr = W * residual;
    const Eigen::Vector3d h(Wr.x(), Wr.y(), -u * Wr.x() - v * Wr.y());
    const double W_u = -u * W(0, 0) - v * W(0, 1), W_v = -u * W(0, 1) - v * W(1, 1);
    Eigen::Matrix3d A, AX, XAX;
    A << W(0, 0), W(0, 1), W_u, W(0, 1), W(1, 1), W_v, W_u, W_v, -u * W_u - v * W_v;
    AX << A.col(1) - v * A.col(2), u * A.col(2) - A.col(0), v * A.col(0) - u * A.col(1);
    XAX << AX.row(1) - v * AX.row(2), u * AX.row(2) - AX.row(0), v * AX.row(0) - u * AX.row(1);
    chi2 += residual.dot(Wr);
    ++dots;
    N_pp += per_z * per_z * A;
    N_pr -= per_z * AX;
    N_rr += XAX;
    g_p -= per_z * h;
    g_r += Eigen::Vector3d(h.y() - v * h.z(), u * h.z() - h.x(), v * h.x() - u * h.y());
  }
  // The position from camera axes to the world's, once for all dots.
  const Eigen::Matrix3d& R = T_world_camera.rotation;
  SightingFit fit{.chi2 = chi2, .dots = dots};
  fit.normal.topLeftCorner<3, 3>() = R * N_pp * R.transpose();
  fit.normal.topRightCorner<3, 3>() = R * N_pr;
  fit.normal.bottomLeftCorner<3, 3>() = fit.normal.topRightCorner<3, 3>().transpose();
  fit.normal.bottomRightCorner<3, 3>() = N_rr;
  fit.gradient << R * g_p, g_r;
  return sighting.turn_sigma_rad > 0 ? softened_by_turn(fit, sighting.turn_sigma_rad) : fit;
}

}  // namespace ninedot
