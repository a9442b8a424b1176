// Light is painted sheet by sheet, the farthest first, into the rectangle of each; then blurred, and turned into grey
// levels. The wall's grey level stays from picture to picture; noise is put on all of it at the end.
#include "drivers/simulation/sheet_renderer.h"

#include <algorithm>
#include <cmath>

#include "drivers/simulation/paint_pixel.h"

namespace ninedot {
namespace {

// Linear: white paper 0.9 and a wall 0.35 in light of 0.85.
constexpr float kPaper = 0.765F, kWall = 0.30F, kCover = 0.05F, kLightLevel = 0.85F;
constexpr double kNearest_m = 0.02;  // nearer than this nothing is seen

bool is_colourless(const Reflectance& ink) { return ink.red == ink.green && ink.green == ink.blue; }

bool has_colour(const std::vector<HungSheet>& sheets) {
  return std::ranges::any_of(sheets,
                             [](const HungSheet& sheet) { return !std::ranges::all_of(sheet.inks, is_colourless); });
}

std::vector<float> gaussian(double sigma_px) {
  if (sigma_px <= 0) return {1};
  std::vector<float> weights;
  const int reach = std::min(static_cast<int>(std::ceil(3 * sigma_px)), RayField::kBorder_px - 1);
  for (int i = 0; i <= reach; ++i) weights.push_back(static_cast<float>(std::exp(-i * i / (2 * sigma_px * sigma_px))));
  float sum = weights[0];
  for (std::size_t i = 1; i < weights.size(); ++i) sum += 2 * weights[i];
  for (float& weight : weights) weight /= sum;
  return weights;
}

/// From a ray to the sheet's plane, up to a positive factor: (X, Z, 1) times the inverse of the distance along the ray.
Eigen::Matrix3d plane_from_ray(const Eigen::Isometry3d& T_camera_sheet) noexcept {
  Eigen::Matrix3d ray_from_plane;
  ray_from_plane << T_camera_sheet.linear().col(0), T_camera_sheet.linear().col(2), T_camera_sheet.translation();
  return ray_from_plane.inverse();
}

}  // namespace

SheetRenderer::SheetRenderer(const CameraModel& camera, std::vector<HungSheet> sheets, const RendererOptions& options)
    : rays_(camera),
      camera_(camera),
      sheets_(std::move(sheets)),
      options_(options),
      has_colour_(has_colour(sheets_)),
      noise_(options.noise_lsb, options.seed),
      kernel_(gaussian(options.blur_px)),
      chroma_width_((camera.width_px + 1) / 2),
      chroma_height_((camera.height_px + 1) / 2),
      luma_(camera.width_px, camera.height_px) {
  sights_.reserve(sheets_.size());
  developed_.reserve(sheets_.size());
  const auto size = static_cast<std::size_t>(camera.width_px + 2 * RayField::kBorder_px) *
                    static_cast<std::size_t>(camera.height_px + 2 * RayField::kBorder_px);
  for (std::size_t channel = 0; channel < (has_colour_ ? 3U : 1U); ++channel) {
    light_[channel].resize(size);
    half_blurred_[channel].resize(size);
  }
  clean_[0].resize(static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px));
  if (!has_colour_) return;
  for (std::size_t i = 0; i < 2; ++i) {
    clean_[i + 1].assign(static_cast<std::size_t>(chroma_width_) * static_cast<std::size_t>(chroma_height_), 128 * 256);
    chroma_[i].resize(clean_[i + 1].size());
  }
}

ChromaView SheetRenderer::chroma() const noexcept {
  if (!has_colour_) return {};
  return {chroma_[0].data(), chroma_[1].data(), chroma_width_, chroma_height_, 1, chroma_width_};
}

void SheetRenderer::render(const ExposureMotion& motion, bool hidden, std::uint64_t frame_number) noexcept {
  const Area all{0, 0, camera_.width_px, camera_.height_px};
  // What the picture before held gives way to the wall again.
  if (was_hidden_ || hidden)
    fill_clean(tone_.grey_256th(hidden ? kCover : kWall), all);
  else
    for (const Area& area : developed_) fill_clean(tone_.grey_256th(kWall), area);
  was_hidden_ = hidden;
  developed_.clear();
  sights_.clear();
  if (!hidden)
    for (const HungSheet& sheet : sheets_)
      if (Sight sight; find(sheet, motion, sight)) sights_.push_back(sight);
  std::ranges::sort(sights_, std::greater{}, &Sight::distance_m);
  const int reach = static_cast<int>(kernel_.size());
  for (const Sight& sight : sights_) {
    const Area area = grown(sight.area, 2 * reach, RayField::kBorder_px);
    for (std::size_t channel = 0; channel < (has_colour_ ? 3U : 1U); ++channel)
      for (int v = area.v0; v < area.v1; ++v)
        std::fill_n(light_[channel].begin() + static_cast<std::ptrdiff_t>(light_at(area.u0, v)), area.u1 - area.u0,
                    kWall);
  }
  for (const Sight& sight : sights_) {
    if (has_colour_)
      paint<3>(sight, motion.half_s.count());
    else
      paint<1>(sight, motion.half_s.count());
  }
  for (const Sight& sight : sights_) {
    const Area area = in_whole_blocks(grown(sight.area, reach, 0));
    if (area.empty()) continue;
    if (has_colour_)
      develop<3>(area);
    else
      develop<1>(area);
    developed_.push_back(area);
  }
  read_out(frame_number);
}

/// \return  whether any of it is in the picture
bool SheetRenderer::find(const HungSheet& sheet, const ExposureMotion& motion, Sight& sight) const noexcept {
  sight.sheet = &sheet;
  std::array<Eigen::Isometry3d, 3> T_camera_sheet;
  for (std::size_t i = 0; i < 3; ++i) T_camera_sheet[i] = motion.T_world_camera[i].inverse() * sheet.T_world_sheet;
  const Eigen::Vector3d camera_m = T_camera_sheet[1].inverse().translation();  // in the sheet's frame
  if (camera_m.y() < kNearest_m) return false;
  sight.distance_m = camera_m.norm();
  const Eigen::Matrix3d before = plane_from_ray(T_camera_sheet[0]), middle = plane_from_ray(T_camera_sheet[1]),
                        after = plane_from_ray(T_camera_sheet[2]);
  sight.plane_from_ray = {middle, (after - before) / 2, (after + before) / 2 - middle};

  // Where its outline is; that of a sheet which reaches behind the camera is anywhere.
  double u0 = 1e9, v0 = 1e9, u1 = -1e9, v1 = -1e9;
  constexpr int kPointsPerSide = 8;
  for (const Eigen::Isometry3d& T : T_camera_sheet)
    for (int i = 0; i < 4 * kPointsPerSide; ++i) {
      const double along = 2.0 * (i % kPointsPerSide) / kPointsPerSide - 1;
      const double s = sheet.half_side_m;
      const std::array<Eigen::Vector3d, 4> sides{Eigen::Vector3d(along * s, 0, -s), Eigen::Vector3d(s, 0, along * s),
                                                 Eigen::Vector3d(-along * s, 0, s), Eigen::Vector3d(-s, 0, -along * s)};
      const Eigen::Vector3d p = T * sides[static_cast<std::size_t>(i / kPointsPerSide)];
      if (p.z() < kNearest_m) {
        sight.area = {-RayField::kBorder_px, -RayField::kBorder_px, camera_.width_px + RayField::kBorder_px,
                      camera_.height_px + RayField::kBorder_px};
        return true;
      }
      Eigen::Vector2d point = p.head<2>() / p.z();
      // The lens's polynomials mean something in the picture alone.
      if (const double limit = 1.2 * rays_.farthest(); point.norm() > limit) point *= limit / point.norm();
      const Eigen::Vector2d pixel = project(camera_, point);
      u0 = std::min(u0, pixel.x()), u1 = std::max(u1, pixel.x());
      v0 = std::min(v0, pixel.y()), v1 = std::max(v1, pixel.y());
    }
  const double far = 1e6;
  const auto whole = [&](double x) { return static_cast<int>(std::clamp(x, -far, far)); };
  // Straight sides bulge between their points by less than a pixel.
  sight.area = grown({whole(std::floor(u0)), whole(std::floor(v0)), whole(std::ceil(u1)) + 1, whole(std::ceil(v1)) + 1},
                     1, RayField::kBorder_px);
  if (options_.exposure_s > 0 && motion.half_s.count() > 0) {
    const Eigen::Vector3d moved = T_camera_sheet[2].translation() / T_camera_sheet[2].translation().z() -
                                  T_camera_sheet[0].translation() / T_camera_sheet[0].translation().z();
    sight.blur_px = camera_.fx_px * moved.norm() * options_.exposure_s / (2 * motion.half_s.count());
  }
  return !sight.area.empty();
}

template <std::size_t kChannels>
void SheetRenderer::paint(const Sight& sight, double half_s) noexcept {
  // A motion of a pixel or less is one moment's picture.
  const int moments = std::clamp(static_cast<int>(std::ceil(sight.blur_px)), 1, 16);
  const double middle_row = (camera_.height_px - 1) / 2.0;
  std::array<PixelPainter, 16> painters;
  for (int v = sight.area.v0; v < sight.area.v1; ++v) {
    for (int i = 0; i < moments; ++i) {
      const double after_s = (v - middle_row) * options_.row_time_s + ((i + 0.5) / moments - 0.5) * options_.exposure_s;
      const double part = half_s > 0 ? std::clamp(after_s / half_s, -1.0, 1.0) : 0;
      const auto& H = sight.plane_from_ray;
      painters[static_cast<std::size_t>(i)].begin(*sight.sheet, H[0] + part * (H[1] + part * H[2]));
    }
    const RayField::Ray* const above = rays_.row(std::max(v - 1, -RayField::kBorder_px));
    const RayField::Ray* const below = rays_.row(std::min(v + 1, camera_.height_px + RayField::kBorder_px - 1));
    const RayField::Ray* const row = rays_.row(v);
    for (int u = sight.area.u0; u < sight.area.u1; ++u) {
      const RayField::Ray& left = row[std::max(u - 1, -RayField::kBorder_px)];
      const RayField::Ray& right = row[std::min(u + 1, camera_.width_px + RayField::kBorder_px - 1)];
      const PixelRay ray{{row[u].x, row[u].y},
                         {(right.x - left.x) / 2, (right.y - left.y) / 2},
                         {(below[u].x - above[u].x) / 2, (below[u].y - above[u].y) / 2}};
      PixelCover cover;
      for (int i = 0; i < moments; ++i) painters[static_cast<std::size_t>(i)].add(ray, cover);
      if (cover.paper == 0) continue;
      const auto share = 1 / static_cast<float>(moments);
      const float white = (cover.paper - cover.ink) * share * kPaper;
      for (std::size_t channel = 0; channel < kChannels; ++channel) {
        float& light = light_[channel][light_at(u, v)];
        light = (1 - cover.paper * share) * light + white + cover.light[channel] * share * kLightLevel;
      }
    }
  }
}

template <std::size_t kChannels>
void SheetRenderer::develop(const Area& area) noexcept {
  const auto reach = static_cast<int>(kernel_.size()) - 1;
  constexpr std::ptrdiff_t kBorder_px = RayField::kBorder_px;
  const std::ptrdiff_t stride = camera_.width_px + 2 * kBorder_px;
  for (std::size_t channel = 0; channel < kChannels; ++channel)
    for (int v = area.v0 - reach; v < area.v1 + reach; ++v) {
      const float* const from = light_[channel].data() + light_at(area.u0, v);
      float* const to = half_blurred_[channel].data() + light_at(area.u0, v);
      for (int i = 0; i < area.u1 - area.u0; ++i) {
        float sum = kernel_[0] * from[i];
        for (int k = 1; k <= reach; ++k) sum += kernel_[static_cast<std::size_t>(k)] * (from[i - k] + from[i + k]);
        to[i] = sum;
      }
    }
  for (int v = area.v0; v < area.v1; ++v)
    for (int u = area.u0; u < area.u1; ++u) {
      std::array<std::uint16_t, kChannels> grey{};
      for (std::size_t channel = 0; channel < kChannels; ++channel) {
        const float* const from = half_blurred_[channel].data() + light_at(u, v);
        float sum = kernel_[0] * *from;
        for (int k = 1; k <= reach; ++k)
          sum += kernel_[static_cast<std::size_t>(k)] * (from[-k * stride] + from[k * stride]);
        grey[channel] = tone_.grey_256th(sum);
      }
      std::uint16_t& luma = clean_[0][static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width_px) +
                                      static_cast<std::size_t>(u)];
      if constexpr (kChannels == 1) {
        luma = grey[0];
      } else {
        // ITU-R BT.601, full range; a block's chroma is that of its first pixel's neighbourhood: the mean of the four.
        const float y = 0.299F * grey[0] + 0.587F * grey[1] + 0.114F * grey[2];
        luma = static_cast<std::uint16_t>(y);
        const auto block =
            static_cast<std::size_t>(v / 2) * static_cast<std::size_t>(chroma_width_) + static_cast<std::size_t>(u / 2);
        const bool is_first = u % 2 == 0 && v % 2 == 0;
        const std::array<float, 2> difference{0.564F * (grey[2] - y), 0.713F * (grey[0] - y)};
        for (std::size_t i = 0; i < 2; ++i) {
          const float before = is_first ? 128 * 256.0F : static_cast<float>(clean_[i + 1][block]);
          clean_[i + 1][block] = static_cast<std::uint16_t>(std::clamp(before + difference[i] / 4, 0.0F, 65280.0F));
        }
      }
    }
}

void SheetRenderer::read_out(std::uint64_t frame_number) noexcept {
  const auto rows = static_cast<std::uint64_t>(camera_.height_px) + 2 * static_cast<std::uint64_t>(chroma_height_);
  std::uint64_t row_number = frame_number * rows;
  const auto width = static_cast<std::size_t>(camera_.width_px);
  for (int v = 0; v < camera_.height_px; ++v)
    noise_.read_out({clean_[0].data() + static_cast<std::size_t>(v) * width, width}, row_number++, luma_.row(v));
  if (!has_colour_) return;
  const auto chroma_width = static_cast<std::size_t>(chroma_width_);
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t v = 0; v < static_cast<std::size_t>(chroma_height_); ++v)
      noise_.read_out({clean_[i + 1].data() + v * chroma_width, chroma_width}, row_number++,
                      chroma_[i].data() + v * chroma_width);
}

SheetRenderer::Area SheetRenderer::grown(const Area& area, int by_px, int border_px) const noexcept {
  return {std::max(area.u0 - by_px, -border_px), std::max(area.v0 - by_px, -border_px),
          std::min(area.u1 + by_px, camera_.width_px + border_px),
          std::min(area.v1 + by_px, camera_.height_px + border_px)};
}

SheetRenderer::Area SheetRenderer::in_whole_blocks(const Area& area) const noexcept {
  return {area.u0 & ~1, area.v0 & ~1, std::min((area.u1 + 1) & ~1, camera_.width_px),
          std::min((area.v1 + 1) & ~1, camera_.height_px)};
}

std::size_t SheetRenderer::light_at(int u, int v) const noexcept {
  return static_cast<std::size_t>(v + RayField::kBorder_px) *
             static_cast<std::size_t>(camera_.width_px + 2 * RayField::kBorder_px) +
         static_cast<std::size_t>(u + RayField::kBorder_px);
}

void SheetRenderer::fill_clean(std::uint16_t level, const Area& area) noexcept {
  for (int v = area.v0; v < area.v1; ++v)
    std::fill_n(clean_[0].begin() + static_cast<std::ptrdiff_t>(v) * camera_.width_px + area.u0, area.u1 - area.u0,
                level);
  if (!has_colour_) return;
  for (std::size_t i = 1; i < 3; ++i)
    for (int v = area.v0 / 2; v < (area.v1 + 1) / 2; ++v)
      std::fill_n(clean_[i].begin() + static_cast<std::ptrdiff_t>(v) * chroma_width_ + area.u0 / 2,
                  (area.u1 + 1) / 2 - area.u0 / 2, static_cast<std::uint16_t>(128 * 256));
}

}  // namespace ninedot
