#include "programs/commands/collect_head_frames.h"

#include "programs/commands/recording_frames.h"

namespace ninedot {

HeadFrame head_frame_of(const Fix& fix, MonoTime exposed_at, const HeadAngles& told, std::size_t recording) {
  HeadFrame frame{recording, exposed_at, told, {}};
  for (const LandmarkFix& landmark : fix.landmarks)
    if (landmark.verdict == Reason::kNone || landmark.verdict == Reason::kAmbiguous ||
        landmark.verdict == Reason::kUncertain || landmark.verdict == Reason::kMoved)
      frame.seen.push_back(landmark.sighting);
  return frame;
}

std::vector<HeadFrame> collect_head_frames(const std::vector<std::string>& recordings, const std::string& camera_file,
                                           const Config& config, LandmarkGeometry& landmark) {
  std::vector<HeadFrame> frames;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const RecordingView view = view_of_recording(recordings[i], camera_file, config);
    landmark = view.landmark;
    const SeenFrames looked = look_at_frames(
        recordings[i], config, view, true, [&](const Frame& frame, const Fix& fix, const LandmarkObservation*) {
          frames.push_back(head_frame_of(fix, frame.exposed_at(), frame.head.value_or(HeadAngles{}), i));
        });
    tell_interruption(looked);
    if (looked.is_interrupted) break;
  }
  return frames;
}

}  // namespace ninedot
