/// The homography's first-order behaviour at one point fixes the plane's orientation up to a reflection about the line
/// of sight: two rotations. For each the translation is linear. Both are then polished, because the homography has
/// eight parameters where the pose has six, and the surplus is noise.
#include "geometry/planar_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/levenberg_marquardt.h"

namespace ninedot {
namespace {

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
/// Eigenvalue of the linear system that must not vanish, relative to the largest: a second one near zero means that the
/// points leave a family of homographies open. Four corners of a square seen at 85 deg give 1e-4; three points on a
/// line 1e-16.
constexpr double kMinSecondEigenvalue = 1e-8;

/// x' = scale (x - middle): zero mean, mean squared distance 2.
struct Normalisation {
  Eigen::Vector2d middle;
  double scale;
  Eigen::Vector2d operator()(const Eigen::Vector2d& x) const noexcept { return scale * (x - middle); }
  Eigen::Matrix3d matrix() const noexcept {
    Eigen::Matrix3d N;
    N << scale, 0, -scale * middle.x(), 0, scale, -scale * middle.y(), 0, 0, 1;
    return N;
  }
};

Normalisation normalisation(std::span<const PlanePoint> points, Eigen::Vector2d PlanePoint::*side) noexcept {
  double weights = 0, squares = 0;
  Eigen::Vector2d middle(0, 0);
  for (const PlanePoint& p : points) {
    weights += p.weight;
    middle += p.weight * (p.*side);
  }
  middle /= weights;
  for (const PlanePoint& p : points) squares += p.weight * ((p.*side) - middle).squaredNorm();
  return {middle, std::sqrt(2 * weights / squares)};
}

/// The rotation that turns the z axis into the direction of (v, 1).
Eigen::Matrix3d rotation_to(const Eigen::Vector2d& v) noexcept {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), v.homogeneous()).toRotationMatrix();
}

/// The two rotations [X0 Z0 -Y0] -> camera that agree with H to first order at the plane's origin (IPPE, section 4).
std::array<Eigen::Matrix3d, 2> infinitesimal_rotations(const Eigen::Matrix3d& H) noexcept {
  const Eigen::Vector2d v = H.col(2).hnormalized();
  const Eigen::Matrix2d J = (H.topLeftCorner<2, 2>() - v * H.block<1, 2>(2, 0)) / H(2, 2);
  const Eigen::Matrix3d Rv = rotation_to(v);
  const Eigen::Matrix2d B = Rv.topLeftCorner<2, 2>() - v * Rv.block<1, 2>(2, 0);
  const Eigen::Matrix2d A = B.inverse() * J;
  const Eigen::Matrix2d AtA = A.transpose() * A;
  const double half_trace = 0.5 * AtA.trace();
  const double gamma_squared = half_trace + std::hypot(0.5 * (AtA(0, 0) - AtA(1, 1)), AtA(0, 1));
  const Eigen::Matrix2d R22 = A / std::sqrt(gamma_squared);
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - R22.transpose() * R22;
  Eigen::Vector2d b(std::sqrt(std::fmax(rest(0, 0), 0)), std::sqrt(std::fmax(rest(1, 1), 0)));
  if (rest(0, 1) < 0) b.y() = -b.y();

  std::array<Eigen::Matrix3d, 2> rotations;
  for (Eigen::Matrix3d& R : rotations) {
    R.topLeftCorner<2, 2>() = R22;
    R.block<1, 2>(2, 0) = b.transpose();
    R.col(0).normalize();
    R.col(1) = (R.col(1) - R.col(0) * R.col(0).dot(R.col(1))).normalized();
    R.col(2) = R.col(0).cross(R.col(1));
    R = (Rv * R).eval();
    b = -b;
  }
  return rotations;
}

/// Translation for a known rotation: x (r3 p + tz) = r1 p + tx and its twin, linear in t.
Eigen::Vector3d translation_for(std::span<const PlanePoint> points, const Eigen::Matrix3d& R) noexcept {
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const PlanePoint& p : points) {
    const Eigen::Vector3d turned = R * Eigen::Vector3d(p.plane_m.x(), 0, p.plane_m.y());
    Eigen::Matrix<double, 2, 3> A;
    A << 1, 0, -p.seen.x(), 0, 1, -p.seen.y();
    N += p.weight * A.transpose() * A;
    g -= p.weight * A.transpose() * (A * turned);
  }
  return N.ldlt().solve(g);
}

/// Reprojection. Unknowns: rotation vector on the left of the rotation, then translation.
struct Reprojection {
  using State = CameraFromLandmark;
  static constexpr int kUnknowns = 6;
  std::span<const PlanePoint> points;

  double linearise(const State& T, Matrix6& N, Vector6& g) const noexcept { return accumulate(T, &N, &g); }
  double cost(const State& T) const noexcept { return accumulate(T, nullptr, nullptr); }
  static State moved(const State& T, const Vector6& step) noexcept {
    return {exp_so3(step.head<3>()) * T.rotation, T.translation_m + step.tail<3>()};
  }
  /// Rays are seen to 1e-6 at best. What is left after a step is a small share of it.
  static bool is_negligible(const State& T, const Vector6& step) noexcept {
    return step.head<3>().norm() < 1e-6 && step.tail<3>().norm() < 1e-6 * T.translation_m.norm();
  }

 private:
  /// The weighted sum of squared residuals; infinite where a point is not in front of the camera.
  double accumulate(const State& T, Matrix6* N, Vector6* g) const noexcept {
    double cost = 0;
    if (N != nullptr) N->setZero(), g->setZero();
    for (const PlanePoint& p : points) {
      const Eigen::Vector3d turned = T.rotation * Eigen::Vector3d(p.plane_m.x(), 0, p.plane_m.y());
      const Eigen::Vector3d q = turned + T.translation_m;
      if (!(q.z() > 0)) return std::numeric_limits<double>::infinity();
      const Eigen::Vector2d predicted = q.hnormalized();
      const Eigen::Vector2d residual = predicted - p.seen;
      cost += p.weight * residual.squaredNorm();
      if (N == nullptr) continue;
      Eigen::Matrix<double, 2, 3> projection;
      projection << 1, 0, -predicted.x(), 0, 1, -predicted.y();
      projection /= q.z();
      Eigen::Matrix3d minus_cross;  // d(R p)/d(rotation) = -[R p]x
      minus_cross << 0, turned.z(), -turned.y(), -turned.z(), 0, turned.x(), turned.y(), -turned.x(), 0;
      Eigen::Matrix<double, 2, 6> J;
      J << projection * minus_cross, projection;
      *N += p.weight * J.transpose() * J;
      *g += p.weight * J.transpose() * residual;
    }
    return cost;
  }
};

bool on_printed_side(const CameraFromLandmark& T) noexcept { return T.inverse().translation_m.y() > 0; }

}  // namespace

Result<Eigen::Matrix3d> fit_homography(std::span<const PlanePoint> points) noexcept {
  if (points.size() < 4) return fail(Errc::kPoseDegenerate, "a planar pose needs four points");
  const Normalisation plane = normalisation(points, &PlanePoint::plane_m);
  const Normalisation picture = normalisation(points, &PlanePoint::seen);
  if (!std::isfinite(plane.scale) || !std::isfinite(picture.scale))
    return fail(Errc::kPoseDegenerate, "the points of a planar pose coincide or are no numbers");

  Matrix9d N = Matrix9d::Zero();
  for (const PlanePoint& p : points) {
    const Eigen::Vector3d m = plane(p.plane_m).homogeneous();
    const Eigen::Vector2d x = picture(p.seen);
    Vector9d row_x, row_y;
    row_x << m, Eigen::Vector3d::Zero(), -x.x() * m;
    row_y << Eigen::Vector3d::Zero(), m, -x.y() * m;
    N += p.weight * (row_x * row_x.transpose() + row_y * row_y.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(N);
  if (!(eigen.eigenvalues()(1) > kMinSecondEigenvalue * eigen.eigenvalues()(8)))
    return fail(Errc::kPoseDegenerate, "the points of a planar pose lie on a line");
  const Vector9d h = eigen.eigenvectors().col(0);
  Eigen::Matrix3d H;
  H << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(), h.segment<3>(6).transpose();
  H = (picture.matrix().inverse() * H * plane.matrix()).eval();
  if (H.row(2).dot(points.front().plane_m.homogeneous()) < 0) H = -H;
  for (const PlanePoint& p : points)
    if (!(H.row(2).dot(p.plane_m.homogeneous()) > 0))
      return fail(Errc::kPoseDegenerate, "the points of a planar pose are not all in front of the camera");
  return H;
}

PlanarPose refine_planar_pose(std::span<const PlanePoint> points, const CameraFromLandmark& start) noexcept {
  PlanarPose best{start, 0, {}};
  const Reprojection problem{points};
  best.statistics = levenberg_marquardt(problem, best.T_camera_landmark);
  double weights = 0;
  for (const PlanePoint& p : points) weights += p.weight;
  best.rms = std::sqrt(problem.cost(best.T_camera_landmark) / weights);
  return best;
}

namespace {

/// Both solutions from the homography alone, unrefined.
Result<std::array<CameraFromLandmark, 2>> start_poses(std::span<const PlanePoint> points) noexcept {
  NINEDOT_TRY(const Eigen::Matrix3d H, fit_homography(points));
  // [X0 Z0 t] has a positive determinant where the camera is on the side to which Y0 = Z0 x X0 points.
  if (!(H.determinant() > 0))
    return fail(Errc::kPoseDegenerate, "the dots are mirrored: no printed side shows them so");

  // The first-order behaviour is best known in the middle of the points.
  const Eigen::Vector2d middle = normalisation(points, &PlanePoint::plane_m).middle;
  Eigen::Matrix3d H_middle = H;
  H_middle.col(2) = H * middle.homogeneous();
  const auto rotations = infinitesimal_rotations(H_middle);
  std::array<CameraFromLandmark, 2> starts;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Eigen::Matrix3d& R = rotations[i];
    starts[i].rotation << R.col(0), -R.col(2), R.col(1);  // Y0 is the third axis, reversed
    starts[i].translation_m = translation_for(points, starts[i].rotation);
  }
  return starts;
}

bool is_solution(const PlanarPose& pose) noexcept {
  return std::isfinite(pose.rms) && on_printed_side(pose.T_camera_landmark);
}

}  // namespace

Result<PlanarPoses> solve_planar_pose(std::span<const PlanePoint> points) noexcept {
  NINEDOT_TRY(const auto starts, start_poses(points));
  PlanarPoses poses;
  std::size_t count = 0;
  for (const CameraFromLandmark& start : starts)
    if (const PlanarPose pose = refine_planar_pose(points, start); is_solution(pose)) poses[count++] = pose;
  if (count == 0) return fail(Errc::kPoseDegenerate, "no planar pose sees the printed side of the dots");
  if (count == 1) poses[1] = poses[0];
  if (poses[1].rms < poses[0].rms) std::swap(poses[0], poses[1]);
  return poses;
}

Result<PlanarPose> solve_likelier_planar_pose(std::span<const PlanePoint> points) noexcept {
  NINEDOT_TRY(auto starts, start_poses(points));
  const Reprojection problem{points};
  if (problem.cost(starts[1]) < problem.cost(starts[0])) std::swap(starts[0], starts[1]);
  for (const CameraFromLandmark& start : starts)
    if (const PlanarPose pose = refine_planar_pose(points, start); is_solution(pose)) return pose;
  return fail(Errc::kPoseDegenerate, "no planar pose sees the printed side of the dots");
}

double depth_of_origin(const Eigen::Matrix3d& H) noexcept {
  const Eigen::Vector2d ray = H.col(2).hnormalized();
  const Eigen::Matrix2d J = (H.topLeftCorner<2, 2>() - ray * H.bottomLeftCorner<1, 2>()) / H(2, 2);
  const double squared = J.squaredNorm(), area = J.determinant();
  return 1 / std::sqrt(0.5 * (squared + std::sqrt(std::max(squared * squared - 4 * area * area, 0.0))));
}

}  // namespace ninedot
