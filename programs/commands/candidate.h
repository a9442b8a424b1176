#pragma once
/// What `ninedot apply` is given: a configuration, a calibration of the camera or of the head, or a map.
#include <cstdint>
#include <string>

namespace ninedot {

enum class CandidateKind : std::uint8_t { kConfiguration, kCalibration, kHead, kMap };

struct Candidate {
  CandidateKind kind = CandidateKind::kConfiguration;
  std::string text;
};

/// The whole of `path`, or of standard input where that is "-".
/// Throws StartupError(kWrongUsage): it can't be read, is empty, or is longer than kMaxApplied_bytes.
std::string read_candidate(const std::string& path);

/// What ninedot-web sends over a connection that is our standard input: a line "apply BYTES", "calibration BYTES",
/// "head BYTES" or "map BYTES", then so many bytes. One that breaks off is known by that, where the end of a pipe would
/// be taken for the text's. Throws StartupError(kWrongUsage): it is none, breaks off, is too long, or took longer than
/// ten seconds.
Candidate read_request(int descriptor);

}  // namespace ninedot
