// Each sub-exposure is a picture of its own, of which each row has its own pose of the camera. Over a cell the ray and
// the centre change linearly, down the picture with the motion too: what a sub-sample between two rows meets is what
// the shutter would have seen between them.
#include "tests/support/room_renderer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "base/contract.h"
#include "tests/support/renderer_film.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::test {
namespace {

// Sub-samples per pixel and axis of cells that an outline crosses. Sub-exposures lie between each other: fewer will do.
constexpr int kSubAtRest = 8, kSubMoving = 4;

/// What a cell of the picture looks along.
struct Beam {
  Eigen::Vector3d centre_m, direction, per_u, per_v, centre_per_v_m;

  Beam(const std::array<RoomRenderer::Row, 3>& rows, std::size_t x)
      : centre_m(rows[1].centre_m),
        direction(rows[1].directions[x + 1]),
        per_u((rows[1].directions[x + 2] - rows[1].directions[x]) / 2),
        per_v((rows[2].directions[x + 1] - rows[0].directions[x + 1]) / 2),
        centre_per_v_m((rows[2].centre_m - rows[0].centre_m) / 2) {}

  /// The same in the frame of a side.
  void enter(const RoomWall& wall) {
    centre_m = wall.moved(centre_m);
    for (Eigen::Vector3d* v : {&direction, &per_u, &per_v, &centre_per_v_m}) *v = wall.turned(*v);
  }

  /// Where it meets the plane Y = 0 of the side that it has entered.
  void meet(double du_px, double dv_px, Spot& spot) const {
    const Eigen::Vector3d d = direction + du_px * per_u + dv_px * per_v;
    const Eigen::Vector3d c_m = centre_m + dv_px * centre_per_v_m;
    const double reach = -c_m.y() / d.y(), slope_x = d.x() / d.y(), slope_z = d.z() / d.y();
    spot.at_m = {c_m.x() + reach * d.x(), c_m.z() + reach * d.z()};
    spot.per_px << reach * (per_u.x() - slope_x * per_u.y()),
        reach * (per_v.x() - slope_x * per_v.y()) + (centre_per_v_m.x() - slope_x * centre_per_v_m.y()),
        reach * (per_u.z() - slope_z * per_u.y()),
        reach * (per_v.z() - slope_z * per_v.y()) + (centre_per_v_m.z() - slope_z * centre_per_v_m.y());
  }
};

/// Index of the side that a ray from inside of the room meets first: those of X, Y and Z, each low then high.
std::size_t side_met(const Beam& beam, const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
  std::size_t side = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double d = beam.direction[axis];
    const double reach = ((d > 0 ? high_m : low_m)[axis] - beam.centre_m[axis]) / d;
    if (d != 0 && reach < nearest) nearest = reach, side = static_cast<std::size_t>(2 * axis + (d > 0 ? 1 : 0));
  }
  return side;
}

/// The picture under way, each colour's light apart.
class Films {
 public:
  /// \param exposures  that the light is the mean of
  Films(const Lens& lens, const Spread& spread, int exposures)
      : reach_px_(spread.reach()),
        stride_(lens.width_px + 2 * reach_px_),
        sub_(spread.samples()),
        exposures_(exposures),
        films_{Film(lens.width_px, lens.height_px, spread), Film(lens.width_px, lens.height_px, spread),
               Film(lens.width_px, lens.height_px, spread)} {
    for (std::vector<double>& cells : flat_)
      cells.resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(lens.height_px + 2 * reach_px_));
    for (std::vector<double>& samples : samples_) samples.resize(static_cast<std::size_t>(sub_ * sub_));
  }

  /// \param x, y  of the picture with its margin \param near  scratch
  void add_cell(int x, int y, const RoomWall& wall, const Beam& beam, RoomWall::Marks& near) {
    Spot spot;
    spot.sample_px = kEdgeReach_px;
    beam.meet(0, 0, spot);
    const Eigen::Array3d light = wall.light_of_cell(spot, near);
    if (!spot.edge_near) {
      for (std::size_t c = 0; c < 3; ++c)
        flat_[c][static_cast<std::size_t>(y * stride_ + x)] += light[static_cast<Eigen::Index>(c)] / exposures_;
      return;
    }
    for (int j = 0; j < sub_; ++j)
      for (int i = 0; i < sub_; ++i) {
        Spot part;
        part.sample_px = 1.0 / sub_;
        beam.meet((i + 0.5) / sub_ - 0.5, (j + 0.5) / sub_ - 0.5, part);
        const Eigen::Array3d sample = wall.light_of_sample(part, near);
        for (std::size_t c = 0; c < 3; ++c)
          samples_[c][static_cast<std::size_t>(j * sub_ + i)] = sample[static_cast<Eigen::Index>(c)] / exposures_;
      }
    for (std::size_t c = 0; c < 3; ++c) films_[c].add(x - reach_px_, y - reach_px_, samples_[c]);
  }

  ColourExposure take() {
    ColourExposure exposure;
    for (std::size_t c = 0; c < 3; ++c) films_[c].add_flat(flat_[c]), exposure[c] = films_[c].take();
    return exposure;
  }

 private:
  int reach_px_, stride_, sub_, exposures_;
  std::array<Film, 3> films_;
  std::array<std::vector<double>, 3> flat_, samples_;
};

}  // namespace

RoomRenderer::RoomRenderer(const Room& room, const Lens& lens, const Sensor& sensor)
    : lens_(lens),
      point_spread_px_(sensor.point_spread_px),
      margin_px_(Spread(sensor.point_spread_px, 1).reach()),
      low_m_(room.low_m.data()),
      high_m_(room.high_m.data()) {
  for (int y = -margin_px_ - 1; y <= lens.height_px + margin_px_; ++y)
    for (int x = -margin_px_ - 1; x <= lens.width_px + margin_px_; ++x) {
      const Ray ray = ray_of_pixel(lens, x, y);
      EXPECTS(ray.valid);
      rays_.push_back(ray.direction);
    }
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) walls_.emplace_back(room, axis, high);
}

ColourExposure RoomRenderer::expose(const CameraWay& way, const Shutter& shutter) const {
  EXPECTS(shutter.sub_exposures > 0);
  const int exposures = shutter.exposure_s > 0 ? shutter.sub_exposures : 1;
  const Spread spread(point_spread_px_, exposures > 1 ? kSubMoving : kSubAtRest);
  const int width = lens_.width_px + 2 * margin_px_, height = lens_.height_px + 2 * margin_px_;
  Films films(lens_, spread, exposures);
  RoomWall::Marks near;
  for (int exposure = 0; exposure < exposures; ++exposure) {
    const double after_s = ((exposure + 0.5) / exposures - 0.5) * shutter.exposure_s;
    const auto pose_at = [&](int row) {
      const double v_px = row - margin_px_ - 1;
      return way(after_s + (v_px - (lens_.height_px - 1) / 2.0) * shutter.row_time_s);
    };
    std::array<Row, 3> rows;
    read_row(0, pose_at(0), rows[1]), read_row(1, pose_at(1), rows[2]);
    for (int y = 0; y < height; ++y) {
      std::rotate(rows.begin(), rows.begin() + 1, rows.end());
      read_row(y + 2, pose_at(y + 2), rows[2]);
      for (int x = 0; x < width; ++x) {
        Beam beam(rows, static_cast<std::size_t>(x));
        const RoomWall& wall = walls_[side_met(beam, low_m_, high_m_)];
        beam.enter(wall);
        films.add_cell(x, y, wall, beam, near);
      }
    }
  }
  return films.take();
}

void RoomRenderer::read_row(int row, const CameraPose& pose, Row& out) const {
  const Eigen::Matrix3d R = rotation_of(pose);
  const auto count = static_cast<std::size_t>(lens_.width_px + 2 * (margin_px_ + 1));
  out.centre_m = Eigen::Vector3d(pose.position_m.data());
  out.directions.resize(count);
  for (std::size_t x = 0; x < count; ++x) out.directions[x] = R * rays_[static_cast<std::size_t>(row) * count + x];
}

}  // namespace ninedot::test
