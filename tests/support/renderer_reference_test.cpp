// The renderers against pictures that others made of the same landmarks from the same places: a path tracer, and for
// rooms a ray caster with a moving camera.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/renderer.h"
#include "tests/support/renderer_optics.h"
#include "tests/support/room_renderer.h"

namespace ninedot::test {
namespace {

// The references' own optical blur. Their pixel filter has another shape than the renderer's square; the edges agree
// all the same to the tolerances below.
constexpr double kReferencePointSpread_px = 0.45;

/// A part of somebody else's picture, with what is known of it.
struct Reference {
  Picture picture;
  int u0_px = 0, v0_px = 0;  ///< of the whole picture, the crop's (0, 0)
  std::map<std::string, std::vector<double>> truth;
  std::string code;                      ///< of a room's landmark
  std::vector<std::vector<double>> way;  ///< in a room: of the camera, time and pose
};

Reference read_reference(const std::string& name) {
  const std::string path = std::string(NINEDOT_SOURCE_DIR) + "/tests/support/reference/" + name;
  Reference reference;
  std::ifstream pgm(path + ".pgm", std::ios::binary);
  std::string magic;
  int maximum = 0;
  pgm >> magic >> reference.picture.width_px >> reference.picture.height_px >> maximum;
  pgm.get();
  reference.picture.pixels.resize(static_cast<std::size_t>(reference.picture.width_px * reference.picture.height_px));
  pgm.read(reinterpret_cast<char*>(reference.picture.pixels.data()),
           static_cast<std::streamsize>(reference.picture.pixels.size()));
  EXPECT_TRUE(pgm.good() && magic == "P5" && maximum == 255) << path;
  std::ifstream text(path + ".txt");
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "code") words >> reference.code;
    std::vector<double> values;
    for (double value = 0; words >> value;) values.push_back(value);
    if (key == "way")
      reference.way.push_back(values);
    else
      reference.truth[key] = values;
  }
  reference.u0_px = static_cast<int>(reference.truth.at("u0_px").at(0));
  reference.v0_px = static_cast<int>(reference.truth.at("v0_px").at(0));
  return reference;
}

CameraPose pose_of(const double* position_m, const double* quaternion) {
  return {{position_m[0], position_m[1], position_m[2]}, {quaternion[0], quaternion[1], quaternion[2], quaternion[3]}};
}

// Signed distance in px from a pixel of the whole picture to the nearest dot outline (negative inside), by rays.
double outline_distance_px(const Scene& scene, double u_px, double v_px) {
  const Eigen::Matrix3d R = rotation_of(scene.camera);
  const auto& c = scene.camera.position_m;
  const auto to_outline_m = [&](double u, double v) {
    const Eigen::Vector3d d = R * ray_of_pixel(scene.lens, u, v).direction;
    const double x_m = c[0] - c[1] / d.y() * d.x(), z_m = c[2] - c[1] / d.y() * d.z();
    double nearest_m = 1;
    for (const Disc& disc : scene.sheets[0].discs)
      nearest_m = std::min(nearest_m, std::hypot(x_m - disc.x_m, z_m - disc.z_m) - disc.radius_m);
    return nearest_m;
  };
  const double per_u = to_outline_m(u_px + 0.5, v_px) - to_outline_m(u_px - 0.5, v_px);
  const double per_v = to_outline_m(u_px, v_px + 0.5) - to_outline_m(u_px, v_px - 0.5);
  return to_outline_m(u_px, v_px) / std::hypot(per_u, per_v);
}

// What can be measured in both pictures, given the distance of each pixel to the nearest outline.
struct Measured {
  double paper_lsb = 0, ink_lsb = 0, noise_lsb = 0;
  std::array<double, 61>
      profile{};                   ///< in linear light, 0 = ink, 1 = paper; bin i is (i - 30) / 10 px from the outline
  double at(double level) const {  // where the profile crosses a level [px]
    for (std::size_t i = 1; i < profile.size(); ++i)
      if (profile[i] >= level)
        return (static_cast<double>(i) - 30 - (profile[i] - level) / (profile[i] - profile[i - 1])) / 10;
    return 99;
  }
};

Measured measure(const Picture& picture, const std::vector<double>& distance_px, int sheet_reach_px) {
  Measured m;
  std::vector<double> paper, ink;
  std::array<double, 61> sums{}, counts{};
  double squares = 0;
  int triples = 0;
  const auto inside = [&](int x, int y) {  // of the sheet, away from its border
    return std::hypot(x - distance_px[distance_px.size() - 2], y - distance_px.back()) < sheet_reach_px;
  };
  const auto index = [&](int x, int y) { return static_cast<std::size_t>(y * picture.width_px + x); };
  for (int y = 0; y < picture.height_px; ++y)
    for (int x = 0; x < picture.width_px; ++x) {
      if (!inside(x, y)) continue;
      const double d_px = distance_px[index(x, y)];
      const double grey = picture.pixels[index(x, y)];
      if (d_px < -3) ink.push_back(grey);
      if (d_px > 3 && d_px < 8) paper.push_back(grey);
      if (std::abs(d_px) < 3.04) {
        const auto bin = static_cast<std::size_t>(std::lround(d_px * 10) + 30);
        sums[bin] += light_from_grey(grey, ToneCurve::kSrgb), counts[bin] += 1;
      }
      if (x + 2 < picture.width_px && inside(x + 2, y) && std::min(d_px, distance_px[index(x + 2, y)]) > 3) {
        const double bend = grey - 2.0 * picture.pixels[index(x + 1, y)] + picture.pixels[index(x + 2, y)];
        squares += bend * bend, ++triples;
      }
    }
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  m.paper_lsb = mean(paper), m.ink_lsb = mean(ink), m.noise_lsb = std::sqrt(squares / triples / 6);
  const double paper_light = light_from_grey(m.paper_lsb, ToneCurve::kSrgb);
  const double ink_light = light_from_grey(m.ink_lsb, ToneCurve::kSrgb);
  for (std::size_t i = 0; i < sums.size(); ++i)
    m.profile[i] = (sums[i] / counts[i] - ink_light) / (paper_light - ink_light);
  return m;
}

void compare(const std::string& name, int sheet_reach_px) {
  const Reference reference = read_reference(name);
  Scene scene;
  std::vector<double> position_m = reference.truth.at("position_mm");
  for (double& value : position_m) value /= 1000;
  scene.camera = pose_of(position_m.data(), reference.truth.at("quaternion").data());
  scene.sensor.point_spread_px = kReferencePointSpread_px;
  set_noise(scene.sensor, reference.truth.at("sigma_at_grey128_lsb").at(0));
  const int width = reference.picture.width_px, height = reference.picture.height_px;
  std::vector<double> distance_px;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      distance_px.push_back(outline_distance_px(scene, x + reference.u0_px, y + reference.v0_px));
  const Eigen::Vector2d p9_px = pixel_of_wall_point(scene.lens, scene.camera, 0, 0);
  distance_px.push_back(p9_px.x() - reference.u0_px), distance_px.push_back(p9_px.y() - reference.v0_px);

  const Measured recorded = measure(reference.picture, distance_px, sheet_reach_px);
  // Brightness is the scene's, not the renderer's: taken from the reference.
  scene.light.level = 1;
  scene.sheets[0].reflectance = light_from_grey(recorded.paper_lsb, scene.sensor.tone);
  for (Disc& disc : scene.sheets[0].discs) disc.reflectance = light_from_grey(recorded.ink_lsb, scene.sensor.tone);
  const Picture whole = render(scene, 5);
  Picture crop{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) crop.pixels.push_back(whole.view().at(x + reference.u0_px, y + reference.v0_px));
  const Measured rendered = measure(crop, distance_px, sheet_reach_px);

  EXPECT_NEAR(rendered.paper_lsb, recorded.paper_lsb, 0.5);
  EXPECT_NEAR(rendered.ink_lsb, recorded.ink_lsb, 0.5);
  EXPECT_NEAR(rendered.noise_lsb / recorded.noise_lsb, 1, 0.1) << recorded.noise_lsb;
  EXPECT_NEAR(rendered.at(0.5), recorded.at(0.5), 0.015) << "the outlines lie elsewhere";
  const double rendered_width_px = rendered.at(0.9) - rendered.at(0.1);
  const double recorded_width_px = recorded.at(0.9) - recorded.at(0.1);
  EXPECT_NEAR(rendered_width_px / recorded_width_px, 1, 0.03) << recorded_width_px;
  double squares = 0;
  for (std::size_t i = 0; i < rendered.profile.size(); ++i)
    squares += std::pow(rendered.profile[i] - recorded.profile[i], 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(rendered.profile.size())), 0.012);
}

TEST(RendererReference, EdgesAndNoiseAgreeWithAPathTracedCloseUp) { compare("near", 130); }

TEST(RendererReference, EdgesAndNoiseAgreeWithAPathTracedLandmarkAtOneMetre) { compare("middle", 62); }

/// Straight from one instant to the next: 4 ms apart the turning head is 0.002 px off.
CameraPose on_the_way(const std::vector<std::vector<double>>& way, double after_s) {
  std::size_t next = 1;
  while (next + 1 < way.size() && way[next][0] < after_s) ++next;
  const double part = (after_s - way[next - 1][0]) / (way[next][0] - way[next - 1][0]);
  std::array<double, 8> at;
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = way[next - 1][i] + part * (way[next][i] - way[next - 1][i]);
  return pose_of(&at[1], &at[4]);
}

/// The room of a reference with its one landmark; walls of even grey.
Room room_of(const Reference& reference) {
  const auto triple = [&](const char* key) {
    const std::vector<double>& v = reference.truth.at(key);
    return std::array<double, 3>{v.at(0), v.at(1), v.at(2)};
  };
  Room room;
  room.low_m = triple("low_m"), room.high_m = triple("high_m");
  room.wall.contrast = 0;
  room.lamp = {triple("lamp_m"), 0.3, 3.2, 1.5};
  room.light = {triple("light")[0], triple("light")[1], triple("light")[2]};
  room.landmarks = {{static_cast<RoomSide>(reference.truth.at("side").at(0)), reference.truth.at("along_m").at(0),
                     reference.truth.at("height_m").at(0), inks_of_code(reference.code)}};
  return room;
}

struct Difference {
  Eigen::Vector2d shift_px{0, 0};  ///< of the other one's outlines
  double rms_lsb = 0, mean_lsb = 0;
};

/// Over the landmark, away from its sheet's border: beyond it walls differ. The shift explains most of the difference
/// with the picture's slopes, in the sense of least squares.
Difference difference_between(const Picture& ours, const Reference& theirs, const Room& room, const Lens& lens) {
  constexpr double kInside_m = 0.085;
  const Eigen::Vector3d place_m = place_of(room, room.landmarks[0]);
  const Eigen::Matrix3d axes = axes_of(room.landmarks[0].side);
  Eigen::Matrix2d slopes = Eigen::Matrix2d::Zero();
  Eigen::Vector2d moments = Eigen::Vector2d::Zero();
  double sum = 0, squares = 0;
  int count = 0;
  for (int y = 1; y + 1 < theirs.picture.height_px; ++y)
    for (int x = 1; x + 1 < theirs.picture.width_px; ++x) {
      const int u = x + theirs.u0_px, v = y + theirs.v0_px;
      const double since_s = (v - (lens.height_px - 1) / 2.0) * theirs.truth.at("row_time_s").at(0);
      const CameraPose camera = on_the_way(theirs.way, since_s);
      const Eigen::Vector3d from_m = axes.transpose() * (Eigen::Vector3d(camera.position_m.data()) - place_m);
      const Eigen::Vector3d d = axes.transpose() * rotation_of(camera) * ray_of_pixel(lens, u, v).direction;
      const Eigen::Vector3d at_m = from_m - from_m.y() / d.y() * d;
      if (std::abs(at_m.x()) > kInside_m || std::abs(at_m.z()) > kInside_m) continue;
      const double more = theirs.picture.view().at(x, y) - ours.view().at(u, v);
      const Eigen::Vector2d slope(ours.view().at(u + 1, v) - ours.view().at(u - 1, v),
                                  ours.view().at(u, v + 1) - ours.view().at(u, v - 1));
      slopes += slope * slope.transpose() / 4, moments += -more * slope / 2;
      sum += more, squares += more * more, ++count;
    }
  return {slopes.inverse() * moments, std::sqrt(squares / count), sum / count};
}

void compare_room(const std::string& name) {
  const Reference reference = read_reference(name);
  const Room room = room_of(reference);
  Lens lens;
  lens.fx_px = lens.fy_px = reference.truth.at("fx_px").at(0);
  const Sensor sensor;
  const ColourExposure exposure =
      RoomRenderer(room, lens, sensor)
          .expose([&](double after_s) { return on_the_way(reference.way, after_s); },
                  {reference.truth.at("exposure_s").at(0), reference.truth.at("row_time_s").at(0), 4});
  const ColourPicture picture = read_out(exposure, sensor, ChromaLayout::k420, 1);
  const Difference difference = difference_between(picture.luma, reference, room, lens);
  EXPECT_LT(difference.shift_px.norm(), 0.01) << difference.shift_px.transpose();
  EXPECT_NEAR(difference.mean_lsb, 0, 0.3);
  EXPECT_LT(difference.rms_lsb, 1);
}

TEST(RendererReference, RoomsAgreeWithAnotherRenderersOneWhereTheHeadHardlyMoves) { compare_room("room_slow"); }

TEST(RendererReference, RoomsAgreeWithAnotherRenderersOneWhereALandmarkIsBlurredOverFivePixels) {
  compare_room("room_fast");
}

}  // namespace
}  // namespace ninedot::test
