// What the tap costs beside the frame that it shows: the way of each frame of a recording, with nobody reading,
// with one who looks on, or with one who records. Prints: mode, frames, microseconds of a frame and of its tap.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "drivers/recording/recording_source.h"
#include "drivers/tap/tap_reader.h"
#include "drivers/tap/tap_writer.h"
#include "pipeline/next_report.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/recording_camera.h"
#include "programs/service/tap_output.h"
#include "programs/tap/tap_frame.h"

namespace ninedot {

// Named for callgrind's --toggle-collect.
extern "C" [[gnu::noinline]] const void* ninedot_measured_frame(FrameProcessor& processor, const Frame& frame) {
  return &processor.process(frame);
}
extern "C" [[gnu::noinline]] void ninedot_measured_tap(FrameObserver& observer, const Frame& frame, const Fix& fix,
                                                       const FrameProcessor& by, const Report& report) {
  observer.observe(frame, fix, by, report);
}

namespace {

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <typename Work>
double time_us(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

int run(const std::string& recording, TapDemand demand, const char* name, int rounds) {
  const CameraModel camera = recording_camera(recording, "", Config{});
  const LocaliserOptions options = localiser_options(Config{});
  TapHeader header;
  describe_camera(camera, options.seeker.landmark, header);
  const std::string path = fmt::format("/dev/shm/ninedot-tap-cost-{}", ::getpid());
  TapWriter writer(path, header);
  TapReader reader(path);
  reader.announce(demand);
  writer.look_for_readers();
  TapObserver observer(writer);
  std::vector<double> frame_us, tap_us;
  MonoTime clock = mono_now();
  for (int round = 0; round < rounds; ++round) {
    RecordingOptions every;
    every.pace = RecordingPace::kEveryFrame;
    RecordingSource source(recording, every);
    const auto localiser = make_localiser(camera, options);
    Report report;
    for (;;) {
      const Result<FrameLease> lease = source.next(mono_now() + std::chrono::seconds(1));
      if (!lease && lease.error().code == Errc::kEndOfStream) break;
      if (!lease) continue;
      const Fix* fix = nullptr;
      frame_us.push_back(
          time_us([&] { fix = static_cast<const Fix*>(ninedot_measured_frame(*localiser, lease->frame)); }));
      // As at 35 frames a second, however fast this goes.
      clock += std::chrono::microseconds(28571);
      report = next_report(report, lease->frame, *fix, {.now = clock});
      tap_us.push_back(time_us([&] { ninedot_measured_tap(observer, lease->frame, *fix, *localiser, report); }));
    }
  }
  const std::size_t count = frame_us.size();
  // Of the tap the mean: of some frames most are passed by.
  const double tap = std::accumulate(tap_us.begin(), tap_us.end(), 0.0) / static_cast<double>(count);
  const double frame = median(frame_us);
  fmt::print("{} {} {:.2f} {:.3f}\n", name, count, frame, tap);
  return 0;
}

}  // namespace
}  // namespace ninedot

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: bench_tap RECORDING nothing|some|every ROUNDS\n");
    return 2;
  }
  using ninedot::TapDemand;
  const TapDemand demand = std::strcmp(argv[2], "every") == 0  ? TapDemand::kEvery
                           : std::strcmp(argv[2], "some") == 0 ? TapDemand::kSome
                                                               : TapDemand::kNothing;
  return ninedot::run(argv[1], demand, argv[2], std::stoi(argv[3]));
}
