#include "tests/support/room_wall.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot::test {
namespace {

constexpr double kPatternPitch_m = 0.015;  // half of a texture's finest octave in its default size

Eigen::Array3d array_of(const LinearRgb& colour) { return {colour.red, colour.green, colour.blue}; }

Eigen::Vector3d vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// Of the side where `axis` is constant: columns X, Y (into the room), Z in the world.
Eigen::Matrix3d axes_of(int axis, bool high) {
  const Eigen::Vector3d inwards = (high ? -1 : 1) * Eigen::Vector3d::Unit(axis);
  const Eigen::Vector3d up = axis == 2 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  Eigen::Matrix3d axes;
  axes << inwards.cross(up), inwards, up;
  return axes;
}

int axis_of(RoomSide side) { return side == RoomSide::kHighX || side == RoomSide::kLowX ? 0 : 1; }
bool is_high(RoomSide side) { return side == RoomSide::kHighX || side == RoomSide::kHighY; }

Eigen::Vector3d place_on(const Room& room, RoomSide side, double along_m, double height_m) {
  const int axis = axis_of(side);
  Eigen::Vector3d place_m(along_m, along_m, height_m);
  place_m[axis] = (is_high(side) ? room.high_m : room.low_m)[static_cast<std::size_t>(axis)];
  return place_m;
}

double cover_of(const RoomWall::Mark& mark, Spot& spot) {
  return mark.round
             ? cover_of_disc(spot, mark.middle_m, mark.half_width_m)
             : cover_of_rectangle(spot, mark.middle_m, Eigen::Vector2d::UnitX(), mark.half_width_m, mark.half_height_m);
}

/// Paper first, then the discs.
std::vector<RoomWall::Mark> marks_of(const HungLandmark& landmark, const Eigen::Vector2d& middle_m) {
  const Sheet sheet = nine_dot_sheet();
  EXPECTS(sheet.discs.size() == landmark.discs.size());
  std::vector<RoomWall::Mark> marks{{middle_m, sheet.width_m / 2, sheet.height_m / 2, false, array_of(landmark.paper)}};
  for (std::size_t i = 0; i < sheet.discs.size(); ++i) {
    const Disc& disc = sheet.discs[i];
    marks.push_back({middle_m + Eigen::Vector2d(disc.x_m, disc.z_m), disc.radius_m, disc.radius_m, true,
                     array_of(landmark.discs[i])});
  }
  return marks;
}

}  // namespace

double irradiance(const Lamp& lamp, const Eigen::Vector3d& to_lamp_m, const Eigen::Vector3d& normal) {
  if (lamp.strength_m2 <= 0) return lamp.ambient;
  const double r2_m2 = to_lamp_m.squaredNorm();
  const double cosine = std::max(0.0, to_lamp_m.dot(normal) / std::sqrt(r2_m2));
  return lamp.ambient + lamp.strength_m2 * cosine / (r2_m2 + lamp.softening_m2);
}

Eigen::Matrix3d axes_of(RoomSide side) { return axes_of(axis_of(side), is_high(side)); }

Eigen::Vector3d place_of(const Room& room, const HungLandmark& landmark) {
  return place_on(room, landmark.side, landmark.along_m, landmark.height_m);
}

std::array<LinearRgb, 9> inks_of_code(std::string_view code) {
  EXPECTS(code.size() == 8);
  std::array<LinearRgb, 9> inks;
  inks.fill({0.035, 0.035, 0.035});
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == 'R') inks[i] = {0.42, 0.05, 0.06};
    if (code[i] == 'G') inks[i] = {0.06, 0.30, 0.10};
    if (code[i] == 'B') inks[i] = {0.05, 0.10, 0.38};
  }
  return inks;
}

RoomWall::Pattern::Pattern(const Texture& texture, const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m)
    : even_(texture.reflectance), low_m_(low_m) {
  if (texture.contrast <= 0) return;
  const auto count = [](double length_m) { return static_cast<Eigen::Index>(length_m / kPatternPitch_m) + 2; };
  values_.resize(count((high_m - low_m).x()), count((high_m - low_m).y()));
  Spot spot;
  for (Eigen::Index j = 0; j < values_.cols(); ++j)
    for (Eigen::Index i = 0; i < values_.rows(); ++i) {
      spot.at_m = low_m + kPatternPitch_m * Eigen::Vector2d(static_cast<double>(i), static_cast<double>(j));
      values_(i, j) = textured(texture, spot);
    }
}

double RoomWall::Pattern::at(const Eigen::Vector2d& at_m) const {
  if (values_.size() == 0) return even_;
  const Eigen::Array2d cell = (at_m - low_m_).array() / kPatternPitch_m;
  const auto i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(cell.x()), 0, values_.rows() - 2);
  const auto j = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(cell.y()), 0, values_.cols() - 2);
  const double u = std::clamp(cell.x() - static_cast<double>(i), 0.0, 1.0);
  const double v = std::clamp(cell.y() - static_cast<double>(j), 0.0, 1.0);
  return (1 - v) * ((1 - u) * values_(i, j) + u * values_(i + 1, j)) +
         v * ((1 - u) * values_(i, j + 1) + u * values_(i + 1, j + 1));
}

RoomWall::RoomWall(const Room& room, int axis, bool high)
    : R_side_world_(axes_of(axis, high).transpose()),
      origin_m_((high ? room.high_m : room.low_m)[static_cast<std::size_t>(axis)] * Eigen::Vector3d::Unit(axis)),
      pattern_([&] {
        const Eigen::Vector3d a_m = moved(vector_of(room.low_m)), b_m = moved(vector_of(room.high_m));
        Texture texture = room.wall;
        texture.seed += 16 * static_cast<std::uint64_t>(2 * axis + (high ? 1 : 0));
        return Pattern(texture, a_m.cwiseMin(b_m)({0, 2}), a_m.cwiseMax(b_m)({0, 2}));
      }()),
      lamp_(room.lamp),
      lamp_m_(moved(vector_of(room.lamp.position_m))),
      tint_(array_of(room.light)) {
  const auto is_here = [&](RoomSide side) { return axis_of(side) == axis && is_high(side) == high; };
  for (const Poster& poster : room.posters)
    if (is_here(poster.side))
      things_.push_back({{moved(place_on(room, poster.side, poster.along_m, poster.height_m))({0, 2}),
                          poster.width_m / 2, poster.tall_m / 2, false, array_of(poster.colour)}});
  for (const HungLandmark& landmark : room.landmarks)
    if (is_here(landmark.side)) things_.push_back(marks_of(landmark, moved(place_of(room, landmark))({0, 2})));
}

Eigen::Array3d RoomWall::light_of_cell(Spot& spot, Marks& near) const {
  near.clear();
  const double margin_m = spot.sample_px * spot.per_px.norm();
  const auto is_near = [&](const Mark& mark) {
    const double reach_m = mark.reach_m + margin_m;
    return (spot.at_m - mark.middle_m).squaredNorm() < reach_m * reach_m;
  };
  for (const std::vector<Mark>& thing : things_) {
    if (!is_near(thing.front())) continue;
    for (const Mark& mark : thing)
      if (is_near(mark)) near.push_back(&mark);
  }
  return light_of_sample(spot, near);
}

Eigen::Array3d RoomWall::light_of_sample(Spot& spot, const Marks& near) const {
  Eigen::Array3d reflectance = Eigen::Array3d::Constant(pattern_.at(spot.at_m));
  for (const Mark* mark : near) {
    const double part = cover_of(*mark, spot);
    if (part >= 1) reflectance = mark->reflectance;
    if (part > 0 && part < 1) reflectance += part * (mark->reflectance - reflectance);
  }
  const Eigen::Vector3d to_lamp_m = lamp_m_ - Eigen::Vector3d(spot.at_m.x(), 0, spot.at_m.y());
  return reflectance * (irradiance(lamp_, to_lamp_m, Eigen::Vector3d::UnitY()) * tint_);
}

}  // namespace ninedot::test
