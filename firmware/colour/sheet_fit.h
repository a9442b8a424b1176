#pragma once
/// What all nine dots are printed with, by one fit to the whole sheet.
#include <array>

#include "colour/disc_picture.h"
#include "colour/ink_fit.h"
#include "geometry/landmark.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// Small discs have hardly a block of paper of their own, and share those between them with their neighbours.
///
/// Least squares of light = paper + slope . place + sum over the dots of cover_k step_k, for red, green and blue, over
/// all blocks of pixels on the sheet's paper. Where motion draws lines, cover_k is the share of disc k's line, and what
/// is brought onto the paper from beyond either end of the lines has a light of its own. \param discs  P1..P8 and P9
/// \param chroma  not empty (contract) \param line_px  PictureMotion's [px] \return  for each dot as fit_ink has it;
/// `residuals` are those of the blocks that it covers, as they are covered Memory: 20 kB of stack, 36 kB for lines.
/// Threads: pure.
std::array<InkFit, kDotCount> fit_sheet(const ImageView& luma, const ChromaView& chroma,
                                        const std::array<DiscPicture, kDotCount>& discs,
                                        const LandmarkGeometry& landmark,
                                        const Eigen::Vector2f& line_px = Eigen::Vector2f::Zero()) noexcept;

}  // namespace ninedot
