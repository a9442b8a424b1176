// The time of a row, from dots whose rows were exposed one after the other. The pictures here are made by asking where
// a dot is at the time at which its row is exposed, by fixed-point iteration, with no derivative in common with the
// fit.
#include "calibrate/row_time_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/startup_error.h"
#include "geometry/landmark.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

constexpr double kPeriod_s = 1.0 / 35, kNoise_px = 0.03;

CameraModel camera_of_the_test() {
  CameraModel camera;
  camera.fx_px = camera.fy_px = 600;
  camera.k = {-0.1, 0.03, 0, 0, 0, 0, 0, 0};
  return camera;
}

constexpr double kLongest_s = kPeriod_s / 480;

/// A hand that swings the camera before a sheet that leans.
struct Hand {
  double swing = 1;  ///< 1: half a metre to and fro each second
  double distance_m = 0.5;
  double jerk_s = 0;  ///< the hand changes its speed all at once, after so long each time; 0: smoothly

  Eigen::Vector<double, 6> smooth(double time_s) const {
    const double phase = 2 * M_PI * 0.7 * time_s;
    return {0.35 + 0.15 * swing * std::sin(0.8 * phase),
            0.3 * swing * std::cos(phase),
            0.1 * swing * std::sin(phase),
            swing * 0.12 * std::sin(phase),
            swing * 0.08 * std::cos(1.3 * phase),
            distance_m + 0.05 * swing * std::sin(0.6 * phase)};
  }

  CameraFromLandmark at(double time_s) const {
    Eigen::Vector<double, 6> place = smooth(time_s);
    if (jerk_s > 0) {
      const double first_s = jerk_s * std::floor(time_s / jerk_s);
      place = smooth(first_s) + (time_s - first_s) / jerk_s * (smooth(first_s + jerk_s) - smooth(first_s));
    }
    const Eigen::Matrix3d upright = (Eigen::Matrix3d() << -1, 0, 0, 0, 0, -1, 0, -1, 0).finished();
    return {exp_so3(place.head<3>()) * upright, place.tail<3>()};
  }
};

MovingSighting sighting(double time_s, double row_time_s, const Hand& hand, test::Random& random) {
  const CameraModel camera = camera_of_the_test();
  const LandmarkGeometry landmark{};
  MovingSighting seen{7, MonoTime(std::chrono::nanoseconds(std::llround(1e9 * (time_s + 1)))), hand.at(time_s), {}};
  seen.T_camera_landmark.translation_m += Eigen::Vector3d(random.normal(), random.normal(), random.normal()) * 5e-4;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(dot);
    double since_s = 0;
    Eigen::Vector2d px;
    for (int i = 0; i < 30; ++i) {
      const CameraFromLandmark T = hand.at(time_s + since_s);
      px = camera.pixel_from_normalised((T * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y())).hnormalized());
      since_s = row_time_s * (px.y() - 239.5);
    }
    px += kNoise_px * Eigen::Vector2d(random.normal(), random.normal());
    seen.dots[dot].ray = camera.normalised_from_pixel(px).value();
    seen.dots[dot].information = Eigen::Matrix2d::Identity() * std::pow(camera.fx_px / kNoise_px, 2);
  }
  return seen;
}

std::vector<MovingSighting> film(double row_time_s, const Hand& hand, std::uint64_t seed, int frames = 60) {
  test::Random random(seed);
  std::vector<MovingSighting> all;
  for (int i = 0; i < frames; ++i) all.push_back(sighting(i * kPeriod_s, row_time_s, hand, random));
  return all;
}

std::string refusal(const std::vector<MovingSighting>& sightings) {
  try {
    fit_row_time(sightings, camera_of_the_test(), {}, kLongest_s);
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    return error.what();
  }
  return "no refusal";
}

TEST(RowTimeFit, IsAsFarFromTheTruthAsItSays) {
  for (const double row_time_s : {0.0, 15e-6, 45e-6}) {
    double squares = 0;
    constexpr int kFilms = 30;
    for (std::uint64_t seed = 0; seed < kFilms; ++seed) {
      const RowTimeFit fit = fit_row_time(film(row_time_s, Hand{}, seed), camera_of_the_test(), {}, kLongest_s);
      squares += std::pow((fit.row_time_s - row_time_s) / fit.sigma_s, 2);
      EXPECT_LT(fit.sigma_s, 1e-6);
      EXPECT_NEAR(fit.misfit, 1, 0.25);
    }
    EXPECT_GT(std::sqrt(squares / kFilms), 0.5) << row_time_s;
    EXPECT_LT(std::sqrt(squares / kFilms), 1.4) << row_time_s;
  }
}

// Between two pictures nobody knows when the hand set off; they must not decide for those in which it moved evenly.
TEST(RowTimeFit, BelievesLittleOfPicturesBetweenWhichTheHandSetsOff) {
  constexpr double kRow_s = 45e-6;
  constexpr int kFilms = 15;
  for (const double jerk_s : {0.17, 0.31, 0.6}) {
    double squares = 0, sum_s = 0;
    for (std::uint64_t seed = 0; seed < kFilms; ++seed) {
      const RowTimeFit fit =
          fit_row_time(film(kRow_s, Hand{1, 0.5, jerk_s}, seed), camera_of_the_test(), {}, kLongest_s);
      squares += std::pow((fit.row_time_s - kRow_s) / fit.sigma_s, 2);
      sum_s += fit.row_time_s - kRow_s;
    }
    EXPECT_LT(std::sqrt(squares / kFilms), 1.2) << jerk_s;
    EXPECT_LT(std::abs(sum_s / kFilms), 0.2e-6) << jerk_s;
  }
}

TEST(RowTimeFit, DoesNotCareForTheOrderNorForAPictureThatShowsSomethingElse) {
  std::vector<MovingSighting> sightings = film(30e-6, Hand{}, 5);
  const RowTimeFit right = fit_row_time(sightings, camera_of_the_test(), {}, kLongest_s);
  std::swap(sightings[3], sightings[40]);
  EXPECT_EQ(fit_row_time(sightings, camera_of_the_test(), {}, kLongest_s).row_time_s, right.row_time_s);
  for (DotSighting& dot : sightings[20].dots) dot.ray.x() *= 1.2;
  const RowTimeFit spoiled = fit_row_time(sightings, camera_of_the_test(), {}, kLongest_s);
  EXPECT_NEAR(spoiled.row_time_s, right.row_time_s, 4 * right.sigma_s);
}

/// By the outlines' own model, with a speed that is not the sheet's.
MovingSighting taken_back(MovingSighting seen, const SheetMotion& motion) {
  const CameraModel camera = camera_of_the_test();
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d on_sheet_m = LandmarkGeometry{}.centre_m(dot);
    const Eigen::Vector3d p_m = seen.T_camera_landmark * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
    seen.dots[dot].ray -= motion.since_s(camera.pixel_from_normalised(seen.dots[dot].ray).y()) *
                          motion.ray_velocity(p_m, seen.T_camera_landmark.translation_m);
  }
  seen.taken_back_by = motion;
  return seen;
}

TEST(RowTimeFit, UndoesWhatTheLocaliserMadeOfTheRowsHoweverWrongItsMotionWas) {
  constexpr double kRow_s = 45e-6;
  const RowTimeFit exposed = fit_row_time(film(kRow_s, Hand{}, 3), camera_of_the_test(), {}, kLongest_s);
  std::vector<MovingSighting> sightings = film(kRow_s, Hand{}, 3);
  test::Random random(4);
  for (MovingSighting& seen : sightings)
    seen = taken_back(seen, {{random.normal(), random.normal(), random.normal()},
                             {0.3 * random.normal(), 0.3 * random.normal(), 0.3 * random.normal()},
                             0.8 * kRow_s,
                             239.5});
  const RowTimeFit fit = fit_row_time(sightings, camera_of_the_test(), {}, kLongest_s);
  EXPECT_NEAR(fit.row_time_s, exposed.row_time_s, 0.1 * exposed.sigma_s);
}

TEST(RowTimeFit, RefusesWhatDoesNotTellItAndSaysWhatIsMissing) {
  EXPECT_NE(refusal(film(30e-6, Hand{0.02}, 1)).find("the motion is too slow"), std::string::npos)
      << refusal(film(30e-6, Hand{0.02}, 1));
  EXPECT_NE(refusal(film(30e-6, Hand{0}, 1)).find("the motion is too slow"), std::string::npos)
      << refusal(film(30e-6, Hand{0}, 1));
  EXPECT_EQ(refusal(film(30e-6, Hand{}, 1, 20)).substr(0, 51), "16 pictures show a landmark with two before and two");
  EXPECT_EQ(refusal({}).substr(0, 11), "0 pictures ");
  EXPECT_NE(refusal(film(-30e-6, Hand{}, 1)).find("stands on its head"), std::string::npos);
  EXPECT_NE(refusal(film(75e-6, Hand{}, 1)).find("more than a frame has time for"), std::string::npos)
      << refusal(film(75e-6, Hand{}, 1));
}

}  // namespace
}  // namespace ninedot
