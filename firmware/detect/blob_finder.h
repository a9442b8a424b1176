#pragma once
/// Dark, roundish blobs of every size in a picture: candidates for dots.
#include <array>
#include <cstdint>
#include <span>

#include "detect/blob.h"
#include "detect/blob_grid.h"
#include "detect/region_finder.h"
#include "detect/work_budget.h"
#include "image/dark_spots.h"
#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Memory: the constructor's. Threads: one caller.
class BlobFinder {
 public:
  static constexpr int kLevels = 4;

  /// \param width_px, height_px  of the largest picture
  BlobFinder(int width_px, int height_px);

  /// Levels of the pyramid to look at: level i finds spots of about 2 to 20 pixels of 1/2^i of the size.
  struct Levels {
    int first = 0;
    int last = kLevels - 1;
  };

  /// \param luma  at most the constructed size (contract)
  /// \param blobs  filled; when there are more than kMaxBlobs or than the budget allows, those of the smallest pictures
  /// (the largest blobs) come first, and the rest is left out and counted: the next search of a whole picture begins
  /// with it, so that no part of the picture stays unseen
  void find_blobs(const ImageView& luma, Levels levels, BlobList& blobs, WorkBudget& budget) noexcept;

  /// Looks at one finer level than the last search of the same picture did. \param blobs  what it filled; added to
  void add_finer_level(const ImageView& luma, BlobList& blobs, WorkBudget& budget) noexcept;

  /// Noise of the picture last searched [grey levels, 1-sigma].
  double noise_lsb() const noexcept { return noise_lsb_; }

  /// Found no room, over all calls: dark runs (RegionFinder), blobs. Both wrap.
  std::uint32_t runs_cut() const noexcept { return regions_.runs_cut(); }
  std::uint32_t blobs_cut() const noexcept { return blobs_cut_; }

  /// Whether level 0 of the picture last searched was smoothed first: it is noisy, and was searched there.
  bool is_smoothed() const noexcept { return is_smoothed_; }

  /// The picture last searched at 1 / 2^level of its size, level 1 .. the last one searched plus one; level 0 where it
  /// is smoothed (contract).
  ImageView picture_at(int level) const noexcept;

  /// Of a pixel there, of level 0 as it was searched [grey levels, 1-sigma].
  double noise_at_lsb(int level) const noexcept;

 private:
  /// Where the next search of a whole picture begins at a level.
  struct Begin {
    int row = 0;
    std::size_t region = 0;
  };

  /// A level as it is searched: the picture, the one of half its size that its threshold comes from, and their noise.
  struct Searched {
    ImageView picture, half;
    double noise_lsb, half_noise_lsb;
  };
  Searched level_of(const ImageView& luma, int level) noexcept;
  void search_level(const ImageView& luma, int level, BlobList& blobs, WorkBudget& budget) noexcept;
  bool collect(const Searched& searched, std::span<const Region> regions, int level, int& allowance,
               std::size_t& begin_at, BlobList& blobs) noexcept;
  bool add_blob(const Blob& blob, BlobList& blobs) noexcept;

  ImageBuffer levels_[kLevels];  // levels_[i] is the picture at 1 / 2^(i+1)
  ImageBuffer rows_, smoothed_, half_smoothed_;
  SpotThreshold threshold_;
  RegionFinder regions_;
  BlobGrid coarser_;  // the blobs of the levels above the one that is searched
  int width_px_, height_px_;
  std::array<Begin, kLevels> begin_{};
  Levels searched_;
  double noise_lsb_ = 0;
  bool is_smoothed_ = false;
  std::uint32_t blobs_cut_ = 0;
};

}  // namespace ninedot
