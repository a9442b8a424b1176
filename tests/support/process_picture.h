#pragma once
/// A picture through a frame processor, as the frame loop sends it.
#include "pipeline/next_report.h"

namespace ninedot::test {

/// \param report  in: of the frame before; out: of this one \param chroma  empty: of a camera without colours
inline void process_picture(FrameProcessor& unit, const ImageView& luma, MonoTime exposed_at, std::uint64_t number,
                            Report& report, const ChromaView& chroma = {}) {
  Frame frame;
  frame.luma = luma;
  frame.chroma = chroma;
  frame.number = number;
  frame.set_exposure(exposed_at);
  report = next_report(report, frame, unit.process(frame), {.now = exposed_at});
}

}  // namespace ninedot::test
