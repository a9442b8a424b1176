#pragma once
/// The dots of a landmark so distant that the search of the whole picture sees little of it but its middle dot, P9.
///
/// Dots of 2 to 4 px, blurred, are paler than half of the ink beside them, and of the picture at half its size, which
/// the threshold is made from (dark_spots.h), their contrast is gone. A window of twice the size has the picture itself
/// for its half.
#include "detect/blob.h"
#include "detect/blob_finder.h"
#include "detect/hypothesis.h"
#include "detect/work_budget.h"
#include "geometry/landmark.h"
#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class CloseLook {
 public:
  /// \param landmark  copied
  explicit CloseLook(const LandmarkGeometry& landmark);

  /// Whether a spot may be such a landmark's P9: small, as dark as ink, and with paper all around where the sheet is
  /// blank. \param blob  of `luma`
  bool may_be_centre(const ImageView& luma, const Blob& blob) const noexcept;

  /// \param centre  one that may be a centre (contract) \param budget  its regions are taken from
  /// \return  it and the blobs around it, in px of `luma`, to be sorted as one likes; until the next call
  BlobList& blobs_around(const ImageView& luma, const Blob& centre, WorkBudget& budget) noexcept;

  /// Moves a guess's blobs to the middles of their darkness: a threshold cuts them where their neighbours' blur lets
  /// it. Under motion they lie a fifth nearer to the truth then (close_look_test.cpp); at rest nothing changes. \param
  /// guess  of the blobs that blobs_around gave last
  void centre_blobs(const ImageView& luma, const Hypothesis& guess) noexcept;

 private:
  void centre_blob(const ImageView& luma, const Hypothesis& guess, std::size_t dot) noexcept;

  LandmarkGeometry landmark_;
  ImageBuffer window_;  ///< at twice its size
  BlobFinder finder_;
  BlobList blobs_;
};

}  // namespace ninedot
