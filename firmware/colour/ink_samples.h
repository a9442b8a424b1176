#pragma once
/// The colours of a picture at and around one disc of the sheet, summed up for the fit of its ink.
#include <Eigen/Core>

#include "colour/disc_picture.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// Where around a disc there is paper.
struct PaperAround {
  Eigen::Vector2f disc_radii{0, 0};  ///< the disc's middle on the sheet, in radii of the disc, from P9 [1]
  float reach_radii = 2;             ///< paper around the disc as far as this, from its middle, in its radii [1]
  float sheet_radii = 2;             ///< and no farther than this from P9, in radii of the disc [1]
};

/// Sums over samples. Each has a cover, the share 0..1 of its light that comes from the disc while the rest comes from
/// paper, and its light: red, green, blue, nearly linear: (coded / 255)^2, 0 dark to 1.
struct InkSums {
  float count = 0;                                   ///< [1]
  float cover = 0, cover2 = 0;                       ///< sum of cover, and of its square [1]
  Eigen::Vector3f light{0, 0, 0};                    ///< sum of light [1]
  Eigen::Vector3f covered_light{0, 0, 0};            ///< of cover times light [1]
  Eigen::Matrix3f light2 = Eigen::Matrix3f::Zero();  ///< of light times its transpose [1]
};

/// Samples are blocks of pixels that share their chroma, two pixels or more each way: luma, averaged over the block,
/// and chroma are then seen with the same resolution, which red, green and blue need that are computed of both. Of a
/// large disc not every block is taken, and none that its outline crosses. \param chroma  not empty, of the luma's size
/// or a part of it (contract) \param most_blocks  count of the blocks of its box that are taken at most
/// Memory: none. Threads: pure.
InkSums sum_samples(const ImageView& luma, const ChromaView& chroma, const DiscPicture& disc, const PaperAround& paper,
                    float most_blocks) noexcept;

}  // namespace ninedot
