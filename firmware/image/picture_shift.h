#pragma once
/// A visual gyroscope: by how much a picture as a whole has moved since the one before, whatever it shows.
///
/// Each picture is summed up along its columns, in bands one above the other, and along its rows likewise; the slopes
/// of these profiles, which light from above leaves alone, are laid over those of the picture before at every shift.
/// Smeared pictures, whose corners nobody finds again, have such profiles all the same.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "image/image_view.h"

namespace ninedot {

/// From one picture to the next.
struct ShiftedBy {
  double x_px = 0, y_px = 0;
};

/// Memory: everything is allocated by the constructor. Threads: one caller.
class PictureShift {
 public:
  /// \param width_px  of all pictures \param height_px  likewise
  PictureShift(int width_px, int height_px);

  /// The next picture. \return  what most of it has moved by since the one before; none: there was none, or the two
  /// have too little in common. Up to two fifths of the picture are found.
  std::optional<ShiftedBy> to(const ImageView& luma) noexcept;
  /// What comes next has nothing to do with what came before.
  void forget() noexcept { has_before_ = false; }

 private:
  static constexpr std::size_t kBands = 4;
  /// Slopes along one direction, of each band, and at last of all bands together.
  struct Profiles {
    std::array<std::vector<float>, kBands + 1> slopes;
    /// Sums of their squares up to each place.
    std::array<std::vector<float>, kBands + 1> energy;
  };
  struct Picture {
    Profiles along_x, along_y;
  };
  void sum_up(const ImageView& luma) noexcept;
  void take_slopes(std::size_t band_px, Profiles& profiles) noexcept;
  std::optional<double> shift_px(const Profiles& before, const Profiles& now) noexcept;
  std::optional<double> best_shift_px(const Profiles& before, const Profiles& now, std::size_t first_band,
                                      std::size_t end_band) noexcept;

  int width_px_, height_px_;
  bool has_before_ = false;
  Picture before_, now_;
  std::vector<std::uint32_t> sums_;  // of a band's columns or rows: [band][place]
  std::vector<float> scores_;        // of each shift
};

}  // namespace ninedot
