// First with losses that let nothing weigh much, straight tables, and a wide spread of the told angles, which narrows;
// then with as many knots as the stops support. What contradicts is left out then, and the spread of the told angles
// follows from the rest: expectation and maximisation, A. Dempster, N. Laird, D. Rubin, JRSS B 39 (1977). At last the
// same without an eighth of the stops, eight times over: what they are foretold by, and how far all numbers move.
#include "calibrate_head/head_calibration.h"

#include <algorithm>
#include <cmath>

#include "base/median.h"
#include "base/units.h"
#include "calibrate_head/head_adjustment.h"
#include "geometry/euler_angles.h"
#include "mapping/chi_square.h"

namespace ninedot {
namespace {

constexpr int kRobustRounds = 3, kOutlierRounds = 3, kMostSpreadRounds = 12;
/// A told angle that is so many spreads off is another one's: the head had not arrived, or slipped.
constexpr double kFarOff = 5;
/// No servo is as good, and no equation is divided by less.
constexpr double kLeastSpread_rad = 0.001 * kRadPerDeg;
/// Nor is a smaller deviation worth leaving a stop out for: tables have corners.
constexpr double kLeastFar_rad = 0.2 * kRadPerDeg;
/// Robust spreads begin there: with a few stops a median may be 0.
constexpr double kLeastRobust_rad = 0.02 * kRadPerDeg;
constexpr double kSettled = 0.02;  // of the spread
constexpr double kMedianDeviate = 0.6745;
constexpr std::size_t kFolds = 8;
/// Fewer say nothing of a spread.
constexpr std::ptrdiff_t kLeastStops = 5;

/// The chain's numbers as a person reads them: tilt_axis_m.x, camera_m, camera_rpy_rad.
Eigen::Matrix<double, kChainUnknowns, 1> chain_of(const BodyGeometry& body) {
  Eigen::Matrix<double, kChainUnknowns, 1> numbers;
  numbers << body.tilt_axis_m.x(), body.camera_m, body.camera_rpy_rad;
  return numbers;
}

Eigen::VectorXd table_of(const AngleTable& table) {
  Eigen::VectorXd numbers(static_cast<Eigen::Index>(table.angle_rad.size()) + 1);
  for (std::size_t i = 0; i < table.angle_rad.size(); ++i) numbers(static_cast<Eigen::Index>(i)) = table.angle_rad[i];
  numbers(numbers.size() - 1) = table.lag_rad;
  return numbers;
}

/// Likewise, and the turn of the camera as roll, pitch and yaw. [m^2], [rad^2]
Eigen::Matrix<double, kChainUnknowns, 1> chain_variances(const BodyGeometry& body, const HeadCovariance& covariance) {
  const Eigen::Vector3d& rpy = body.camera_rpy_rad;
  const YawPitchRoll angles{rpy.z(), rpy.y(), rpy.x()};
  const Eigen::Matrix3d R = rotation_of(angles);
  const Eigen::Matrix3d of_angles =
      covariance_of_angles(angles, R.transpose() * covariance.chain.bottomRightCorner<3, 3>() * R);
  Eigen::Matrix<double, kChainUnknowns, 1> variances;
  variances << covariance.chain.diagonal().head<4>(), of_angles.diagonal().reverse();
  return variances;
}

class HeadFitter {
 public:
  HeadFitter(std::span<const HeadStop> stops, const LandmarkGeometry& landmark, const BodyGeometry& before,
             const std::function<bool()>& go_on)
      : before_(before), go_on_(go_on), network_(guess_network(stops, landmark, before)) {}

  std::optional<HeadCalibration> fit() {
    HeadCalibration result;
    result.foretold_before_rad = foretold_before_rad();
    for (int round = 0; round < kRobustRounds; ++round)
      if (!fit_robustly()) return std::nullopt;
    take_knots(network_.pan, true);
    take_knots(network_.tilt, false);
    if (!fit_robustly() || !leave_out_contradictions() || !find_spreads()) return std::nullopt;
    describe(result);
    if (!check_by_folds(result) || !find_skew(result)) return std::nullopt;
    return result;
  }

 private:
  bool adjust(HeadNetwork& network, bool is_robust, bool frees_skew = false) const {
    HeadAdjustmentOptions options{.is_robust = is_robust, .frees_skew = frees_skew, .go_on = go_on_};
    return adjust_head(network, options) && !(go_on_ && !go_on_());
  }

  bool fit_robustly() {
    if (!adjust(network_, true)) return false;
    std::vector<double> pan, tilt, misfits;
    for (std::size_t i = 0; i < network_.stops.size(); ++i) {
      const HeadAngles tie = tie_of(network_, i);
      pan.push_back(std::abs(tie.pan_rad)), tilt.push_back(std::abs(tie.tilt_rad));
    }
    network_.pan_spread_rad = std::max(kLeastRobust_rad, median(pan) / kMedianDeviate);
    network_.tilt_spread_rad = std::max(kLeastRobust_rad, median(tilt) / kMedianDeviate);
    for (const StopSighting& sighting : network_.sightings) {
      const int freedoms = residual_count(*sighting.seen);
      misfits.push_back(chi2_of(network_, sighting) / chi2_median(freedoms));
    }
    network_.variance_factor = std::max(1.0, median(misfits));
    return true;
  }

  void take_knots(AngleTable& table, bool is_pan) {
    std::vector<AxisStop> stops;
    const double far_rad = kFarOff * (is_pan ? network_.pan_spread_rad : network_.tilt_spread_rad);
    for (std::size_t i = 0; i < network_.stops.size(); ++i) {
      const HeadStop& stop = network_.stops[i];
      const HeadAngles tie = tie_of(network_, i);
      if (std::abs(is_pan ? tie.pan_rad : tie.tilt_rad) > far_rad) continue;
      stops.push_back(is_pan ? AxisStop{stop.told.pan_rad, network_.angles[i].pan_rad, stop.pan_side}
                             : AxisStop{stop.told.tilt_rad, network_.angles[i].tilt_rad, stop.tilt_side});
    }
    if (stops.size() < 5) return;
    AngleTable finer{choose_knots(stops), {}, table.lag_rad};
    for (const double told_rad : finer.told_rad) finer.angle_rad.push_back(table.at(told_rad));
    table = finer;
  }

  /// What is out stays out.
  bool leave_out_contradictions() {
    for (int round = 0; round < kOutlierRounds; ++round) {
      bool is_changed = false;
      for (StopSighting& sighting : network_.sightings) {
        const double limit = network_.variance_factor * chi2_limit(residual_count(*sighting.seen));
        if (!network_.counts(sighting) || chi2_of(network_, sighting) <= limit) continue;
        sighting.is_believed = false, is_changed = true;
      }
      for (std::size_t i = 0; i < network_.stops.size(); ++i) {
        const HeadAngles tie = tie_of(network_, i);
        const auto is_near_to = [](double off_rad, double spread_rad) {
          return std::abs(off_rad) <= std::max(kLeastFar_rad, kFarOff * spread_rad);
        };
        const bool is_near =
            is_near_to(tie.pan_rad, network_.pan_spread_rad) && is_near_to(tie.tilt_rad, network_.tilt_spread_rad);
        if (is_near || !network_.is_believed[i]) continue;
        network_.is_believed[i] = false, is_changed = true;
      }
      if (!is_changed && round > 0) return true;
      if (!adjust(network_, false) || !take_spreads()) return false;
    }
    return true;
  }

  bool find_spreads() {
    for (int round = 0; round < kMostSpreadRounds; ++round) {
      const double pan_rad = network_.pan_spread_rad, tilt_rad = network_.tilt_spread_rad;
      if (!adjust(network_, false) || !take_spreads()) return false;
      if (std::abs(network_.pan_spread_rad - pan_rad) < kSettled * pan_rad &&
          std::abs(network_.tilt_spread_rad - tilt_rad) < kSettled * tilt_rad)
        break;
    }
    return true;
  }

  /// The spreads that are likeliest where the fit is now, and the pictures' factor.
  /// \return  false: too little is left
  bool take_spreads() {
    const std::vector<bool> is_used = used_stops(network_);
    if (std::ranges::count(is_used, true) < kLeastStops) return false;
    const HeadCovariance covariance = covariance_of_head(network_, false);
    double pan = 0, tilt = 0, chi2 = 0, count = 0, freedoms = -kChainUnknowns;
    for (std::size_t i = 0; i < is_used.size(); ++i) {
      if (!is_used[i]) continue;
      const HeadAngles tie = tie_of(network_, i);
      pan += tie.pan_rad * tie.pan_rad + covariance.pan_tie_rad2[i];
      tilt += tie.tilt_rad * tie.tilt_rad + covariance.tilt_tie_rad2[i];
      freedoms -= 2, ++count;
    }
    std::vector<bool> is_placed(network_.places.size());
    for (const StopSighting& sighting : network_.sightings) {
      if (!network_.counts(sighting)) continue;
      chi2 += chi2_of(network_, sighting);
      freedoms += residual_count(*sighting.seen);
      is_placed[sighting.place] = true;
    }
    freedoms -= 6.0 * static_cast<double>(std::ranges::count(is_placed, true));
    if (freedoms < 1 || !std::isfinite(pan + tilt + chi2)) return false;
    network_.pan_spread_rad = std::max(kLeastSpread_rad, std::sqrt(pan / count));
    network_.tilt_spread_rad = std::max(kLeastSpread_rad, std::sqrt(tilt / count));
    network_.variance_factor = std::max(1.0, chi2 / freedoms);
    return true;
  }

  static std::vector<bool> used_stops(const HeadNetwork& network) {
    std::vector<bool> is_used(network.stops.size());
    for (const StopSighting& sighting : network.sightings)
      if (network.counts(sighting)) is_used[sighting.stop] = true;
    return is_used;
  }

  /// By the first guess, which has the angles as they are told.
  double foretold_before_rad() const {
    std::vector<double> off;
    for (const StopSighting& sighting : network_.sightings)
      off.push_back(off_rad(network_, sighting, network_.angles[sighting.stop]));
    return median(off) * kRmsOverMedian;
  }
  /// Of a direction's two errors, normal and alike: the median of their length is sqrt(2 ln 2) sigma, its root mean
  /// square sqrt(2).
  static constexpr double kRmsOverMedian = 1.2011;

  void describe(HeadCalibration& result) {
    const HeadCovariance covariance = covariance_of_head(network_, false);
    chain_variances_ = chain_variances(network_.body, covariance);
    pan_variances_ = covariance.pan.diagonal();
    tilt_variances_ = covariance.tilt.diagonal();
    result.body = before_;
    result.body.tilt_axis_m = network_.body.tilt_axis_m;
    result.body.camera_m = network_.body.camera_m;
    result.body.camera_rpy_rad = network_.body.camera_rpy_rad;
    result.variance_factor = network_.variance_factor;
    const std::vector<bool> is_used = used_stops(network_);
    result.stops = static_cast<std::size_t>(std::ranges::count(is_used, true));
    result.left_out = is_used.size() - result.stops;
    result.landmarks = network_.places.size();
  }

  /// Without an eighth of the stops at a time: what these are foretold by, and the delete-a-group jackknife's
  /// variances, which know nothing of any model (P. Kott, "The delete-a-group jackknife", J. Official Statistics 17
  /// (2001)).
  bool check_by_folds(HeadCalibration& result) {
    const Eigen::VectorXd chain = chain_of(network_.body), pan = table_of(network_.pan), tilt = table_of(network_.tilt);
    Eigen::VectorXd chain_scatter = Eigen::VectorXd::Zero(chain.size()),
                    pan_scatter = Eigen::VectorXd::Zero(pan.size()), tilt_scatter = Eigen::VectorXd::Zero(tilt.size());
    const std::vector<bool> is_used = used_stops(network_);
    double sum = 0, count = 0;
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
      HeadNetwork rest = network_;
      std::size_t place = 0;
      std::vector<bool> is_left_out(is_used.size());
      for (std::size_t i = 0; i < is_used.size(); ++i)
        if (is_used[i] && place++ % kFolds == fold) is_left_out[i] = true, rest.is_believed[i] = false;
      if (!adjust(rest, false)) return false;
      chain_scatter += (chain_of(rest.body) - chain).cwiseAbs2();
      pan_scatter += (table_of(rest.pan) - pan).cwiseAbs2();
      tilt_scatter += (table_of(rest.tilt) - tilt).cwiseAbs2();
      for (const StopSighting& sighting : network_.sightings) {
        if (!is_left_out[sighting.stop] || !sighting.is_believed || !is_placed(rest, sighting.place)) continue;
        const double off = off_rad(rest, sighting, angles_of(rest, rest.stops[sighting.stop].told));
        sum += off * off, ++count;
      }
    }
    if (count > 0) result.foretold_rad = std::sqrt(sum / count);
    const double share = (kFolds - 1.0) / kFolds;
    const Eigen::VectorXd sigmas = chain_variances_.cwiseMax(share * chain_scatter).cwiseSqrt();
    result.tilt_axis_x_sigma_m = sigmas(0);
    result.camera_sigma_m = sigmas.segment<3>(1);
    result.camera_rpy_sigma_rad = sigmas.tail<3>();
    describe_axis(network_.pan, network_.pan_spread_rad, pan_variances_.cwiseMax(share * pan_scatter), result.pan);
    describe_axis(network_.tilt, network_.tilt_spread_rad, tilt_variances_.cwiseMax(share * tilt_scatter), result.tilt);
    result.body.pan_sigma_rad = result.pan.sigma_rad;
    result.body.tilt_sigma_rad = result.tilt.sigma_rad;
    return true;
  }

  static bool is_placed(const HeadNetwork& network, std::size_t place) {
    return std::ranges::any_of(network.sightings, [&](const StopSighting& sighting) {
      return sighting.place == place && network.counts(sighting);
    });
  }

  static void describe_axis(const AngleTable& table, double spread_rad, const Eigen::VectorXd& variances,
                            AxisCalibration& axis) {
    const auto knots = static_cast<Eigen::Index>(table.told_rad.size());
    double table_rad2 = 0;
    for (Eigen::Index i = 0; i < knots; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double variance = variances(i) + bend_rad2(table, at);
      axis.points.push_back({table.told_rad[at], table.angle_rad[at], std::sqrt(variance)});
      table_rad2 += variance / static_cast<double>(knots);
    }
    // An axis that is told the wrong way round is come to from the other side.
    const bool is_reversed = table.angle_rad.back() < table.angle_rad.front();
    axis.play_rad = (is_reversed ? -2 : 2) * table.lag_rad;
    axis.play_sigma_rad = 2 * std::sqrt(variances(knots));
    axis.sees_play = axis.play_sigma_rad > kNeverSeen_rad;
    axis.spread_rad = spread_rad;
    axis.sigma_rad = std::sqrt(spread_rad * spread_rad + table.lag_rad * table.lag_rad + table_rad2);
  }
  /// What straight pieces may miss of a curve between knots, h^2 f'' / 8, of which second differences are h^2 f''.
  static double bend_rad2(const AngleTable& table, std::size_t knot) {
    if (table.angle_rad.size() < 3) return 0;
    const std::size_t at = std::clamp<std::size_t>(knot, 1, table.angle_rad.size() - 2);
    const double bend_rad = (table.angle_rad[at - 1] - 2 * table.angle_rad[at] + table.angle_rad[at + 1]) / 8;
    return bend_rad * bend_rad;
  }
  /// Where no side is known the lag is held at 0, to less than this.
  static constexpr double kNeverSeen_rad = 1e-8;

  bool find_skew(HeadCalibration& result) {
    HeadNetwork skewed = network_;
    if (!adjust(skewed, false, true)) return false;
    result.skew_rad = skewed.skew_rad;
    result.skew_sigma_rad = std::sqrt(covariance_of_head(skewed, true).skew_rad2);
    return true;
  }

  const BodyGeometry before_;
  const std::function<bool()>& go_on_;
  HeadNetwork network_;
  Eigen::VectorXd chain_variances_, pan_variances_, tilt_variances_;
};

}  // namespace

std::optional<HeadCalibration> calibrate_head(std::span<const HeadStop> stops, const LandmarkGeometry& landmark,
                                              const BodyGeometry& before, const std::function<bool()>& go_on) {
  return HeadFitter(stops, landmark, before, go_on).fit();
}

}  // namespace ninedot
