#pragma once
/// Which lens model the views support: the simplest, unless another one foretells views better that it has not seen.
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calibrate_camera/lens_adjustment.h"
#include "calibrate_camera/lens_calibration.h"

namespace ninedot {

struct ModelChoiceOptions {
  AdjustLensOptions adjust;
  std::function<bool(std::string_view what)> go_on;  ///< false ends the work
};

/// Fits plumb_bob, equidistant and rational_polynomial to three quarters of the views each and looks at the fourth,
/// four times over (cross-validation: M. Stone, J. Royal Statistical Society B 36, 1974). Plumb_bob stays unless
/// another one's loss in unseen views is lower by two standard errors of the ratio's logarithm and by a part that is
/// worth it.
/// \param fit  of any model \param tried  filled
/// \return  of the chosen model, of all views; nothing: it was told to stop, or none fits
std::optional<LensFit> choose_model(std::span<const PlaneDisc> discs, std::span<const SheetView> views,
                                    const LensFit& fit, const ModelChoiceOptions& options,
                                    std::vector<TriedModel>& tried);

}  // namespace ninedot
