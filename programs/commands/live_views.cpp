#include "programs/commands/live_views.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <utility>

#include "base/startup_error.h"
#include "calibrate_camera/sheet_map.h"
#include "calibrate_camera/wanted_pose.h"
#include "programs/commands/collect_views.h"
#include "programs/commands/source_failure.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kTablePeriod = 100ms;
/// The lens is learned from so many views, and again from twice as many: near enough to search with, no more.
constexpr std::size_t kLearnFrom = 8, kLearnAgain = 16;
/// So many more when the lens lacks something: a third of what is gathered at first.
constexpr std::size_t kMoreViews = 10;
/// Of each part whose directions are less certain than the others.
constexpr int kMoreInPart = 3;

/// By the lens that is known by now; where that shows nothing, as before it was.
class EitherFinder final : public SheetFinder {
 public:
  EitherFinder(std::unique_ptr<SheetFinder> first, std::unique_ptr<SheetFinder> second)
      : first_(std::move(first)), second_(std::move(second)) {}
  std::vector<SeenDisc> find(const ImageView& luma) override {
    std::vector<SeenDisc> seen = first_->find(luma);
    return seen.empty() ? second_->find(luma) : seen;
  }

 private:
  std::unique_ptr<SheetFinder> first_, second_;
};

Eigen::Vector2d middle_px(std::span<const SeenDisc> seen) {
  Eigen::Vector2d sum_px{0, 0};
  for (const SeenDisc& disc : seen) sum_px += disc.centre_px;
  return sum_px / static_cast<double>(seen.size());
}

}  // namespace

LiveViews::LiveViews(const OpenedSource& source, const CalibrationTarget& target, LiveViewsOptions options)
    : source_(source),
      target_(target),
      options_(std::move(options)),
      finder_(target.finder(usual_camera(options_.width_px, options_.height_px))),
      gatherer_(options_.width_px, target.discs),
      lines_(STDERR_FILENO),
      lens_(usual_camera(options_.width_px, options_.height_px)) {
  if (!options_.keep.empty()) writer_.emplace(options_.keep, "");
}

LiveViews::End LiveViews::gather() {
  MonoTime last_frame_at = mono_now();
  tell(Looked::kNoSheet);
  for (;;) {
    if (options_.is_stopped()) break;
    Result<FrameLease> lease = source_.frames->next(mono_now() + 200ms);
    if (lease) {
      last_frame_at = mono_now();
      look_at(*lease);
      if (!wanted_.empty()) continue;
      lines_.make_room();
      return End::kEnough;
    }
    if (lease.error().code == Errc::kEndOfStream) break;
    const std::string failure = why_source_failed(source_, lease.error(), last_frame_at);
    if (failure.empty()) continue;
    lines_.make_room();
    throw StartupError(ExitStatus::kWorkFailed, failure + where_kept());
  }
  lines_.make_room();
  return options_.is_stopped() ? End::kStopped : End::kSourceEnded;
}

void LiveViews::want_more(const CameraModel& lens, std::vector<std::string> lens_lacks,
                          std::span<const UncertainPart> uncertain) {
  lens_ = lens;
  lens_lacks_ = std::move(lens_lacks);
  shown_at_ = {};  // what is wanted now is news
  const ViewTally now = tally();
  goals_.views = now.views + kMoreViews;
  for (const UncertainPart& part : uncertain) {
    goals_.parts[part.part] = now.parts[part.part] + kMoreInPart;
    lens_lacks_.push_back(
        fmt::format("directions in the {} are uncertain by {:.2g} px: the sheet right into its corner",
                    kPartNames[part.part], part.sigma_px));
  }
}

void LiveViews::look_at(FrameLease& lease) {
  ++pictures_;
  const Looked looked = gatherer_.look(*finder_, lease.frame.luma, sensor_of(lease.frame));
  if (looked == Looked::kTaken) {
    keep(lease);
    learn_lens();
  }
  tell(looked);
}

void LiveViews::keep(FrameLease& lease) {
  if (!writer_) return;
  lease.dropped_before = 0;  // views are chosen: what lies between them is no loss
  if (const Result<std::uint64_t> number = writer_->add(lease); !number)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{}: {}{}", options_.keep, std::strerror(number.error().os_errno), where_kept()));
}

void LiveViews::learn_lens() {
  const std::size_t views = gatherer_.views().size();
  if (target_.grid || (views != kLearnFrom && views != kLearnAgain) || views == lens_of_) return;
  lens_of_ = views;
  if (const std::optional<CameraModel> lens = options_.rough_lens(gatherer_.views())) {
    lens_ = *lens;
    finder_ = std::make_unique<EitherFinder>(target_.finder(*lens),
                                             target_.finder(usual_camera(options_.width_px, options_.height_px)));
  }
}

std::string LiveViews::where_kept() const {
  if (!writer_ || writer_->frame_count() == 0) return {};
  return fmt::format("; the views until then are kept in {}", options_.keep);
}

ViewTally LiveViews::tally() const {
  return tally_of(gatherer_.views(), target_.discs, options_.width_px, options_.height_px);
}

void LiveViews::tell(Looked looked) {
  const bool is_news = looked == Looked::kTaken || shown_at_ == MonoTime{};
  const bool is_due = is_news || (lines_.is_terminal() && mono_now() - shown_at_ >= kTablePeriod) ||
                      (options_.news != nullptr && options_.news->is_due());
  if (!is_due) return;
  shown_at_ = mono_now();
  GatheringState now{tally(), {}, lens_lacks_, {}, looked};
  wanted_ = wanted_views(now.tally, goals_);
  for (const Want& want : wanted_) now.wanted.push_back(name_of(want));
  if (!gatherer_.newest().empty())
    now.part = part_of(middle_px(gatherer_.newest()), options_.width_px, options_.height_px);
  if (options_.news != nullptr) {
    // One that jumped from picture to picture could not be followed.
    if (is_news) ghost_ = ghost_for(wanted_);
    tell_news(now);
  }
  if (lines_.is_terminal() && lines_.draw(gathering_table(now, lines_.columns()))) return;
  if (is_news) lines_.print(gathering_line(now) + "\n");
}

void LiveViews::tell_news(const GatheringState& now) {
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  Eigen::Matrix3d H;
  if (fit_sheet_map(gatherer_.newest(), target_.discs, H))
    outlines = outlines_of([&H](const Eigen::Vector2d& at_m) { return map_point(H, at_m); }, target_.discs);
  options_.news->gathering(now, outlines.empty() ? std::span<const Eigen::Vector2d>() : outlines.front(), ghost_);
}

SheetGhost LiveViews::ghost_for(std::span<const Want> wanted) const {
  const std::optional<WantedPose> pose = pose_for(wanted, lens_, target_.discs, gatherer_.collection());
  if (!pose) return {};
  SheetGhost ghost;
  for (const std::size_t met : pose->meets) ghost.meets.push_back(name_of(wanted[met]));
  ghost.outlines = outlines_of(map_of_camera(lens_, pose->T_camera_sheet), target_.discs);
  return ghost;
}

}  // namespace ninedot
