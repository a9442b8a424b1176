#pragma once
/// The tap's shared memory, byte by byte: docs/tap.md is made from tap_document.cpp, which lists these very members,
/// and a test pins every offset. Numbers are the machine's own (little-endian on all boards that are built for),
/// floating point is IEEE 754, lengths are mm, angles degrees, times CLOCK_MONOTONIC in ns. Not a number = unknown.
///
/// A change of any offset, unit or meaning is another kTapVersion; what is `reserved` is 0.
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace ninedot {

inline constexpr std::array<char, 8> kTapMagic{'N', 'I', 'N', 'E', 'T', 'A', 'P', '\0'};
inline constexpr std::uint32_t kTapVersion = 3;
inline constexpr std::uint32_t kTapByteOrder = 0x01020304;  ///< as the writer's machine stores it [1]
/// A reader that has the newest slot in hand loses it when two more were published: two frame periods to copy it.
inline constexpr std::uint32_t kTapSlots = 3;
inline constexpr std::size_t kTapPage_bytes = 4096;
/// The lock bytes, for F_OFD_SETLK: the service holds a write lock on the first while it lives; a reader holds a read
/// lock on the second while it looks at some frames, on the third while it wants every one. The kernel gives up the
/// locks of whoever dies.
inline constexpr std::int64_t kTapWriterLock_bytes = 0, kTapSomeLock_bytes = 1, kTapEveryLock_bytes = 2;
/// From one of some frames to the next, at least: a dozen a second, for eyes.
inline constexpr std::int64_t kTapSomePeriod_ns = 80'000'000;
inline constexpr std::size_t kTapDotCount = 9;         ///< P1..P9
inline constexpr std::size_t kTapLandmarkCount = 16;   ///< landmarks in view, at most
inline constexpr std::size_t kTapCandidateCount = 2;   ///< readings of a landmark, at most
inline constexpr std::size_t kTapSpotCount = 256;      ///< dark spots of a search that found nothing, at most
inline constexpr std::size_t kTapRegisterCount = 192;  ///< room for the map; TapService::register_count are used
inline constexpr std::size_t kTapClientCount = 16;
inline constexpr std::size_t kTapLogCount = 24;
/// Latencies: bin i ends at kTapFirstBin_us * 2^(i/4); the last one takes all that is longer.
inline constexpr std::size_t kTapBinCount = 40;
inline constexpr double kTapFirstBin_us = 100;

/// Written before the file gets its name; only the two counts at its end change.
struct TapHeader {
  std::array<char, 8> magic = kTapMagic;
  std::uint32_t version = kTapVersion, byte_order = kTapByteOrder;
  std::uint64_t segment_bytes = 0;
  std::uint64_t frame_slots_offset = 0, frame_slot_bytes = 0;  ///< [bytes]
  std::uint64_t pixels_offset = 0, pixels_capacity = 0;        ///< from the slot's start; of a slot [bytes]
  std::uint64_t service_slots_offset = 0, service_slot_bytes = 0;
  std::uint32_t slot_count = kTapSlots, process_id = 0;
  std::int64_t started_at_ns = 0;
  std::array<char, 32> software{};
  std::uint32_t width_px = 0, height_px = 0;
  std::uint32_t lens_model = 0;  ///< 0 plumb_bob, 1 rational_polynomial, 2 equidistant
  std::uint32_t reserved = 0;
  std::array<double, 4> intrinsics_px{};  ///< fx, fy, cx, cy
  std::array<double, 8> distortion{};     ///< in the model's own order [1]
  double ring_radius_mm = 0, dot_radius_mm = 0, centre_radius_mm = 0;
  double rate_hz = 0;  ///< as configured
  std::array<std::uint64_t, 29> reserved_words{};
  std::uint64_t newest_frame = 0;    ///< publications of frames; 0 = none yet. Slot (n - 1) % slot_count is the newest
  std::uint64_t newest_service = 0;  ///< how many of the service's part, likewise
};

/// Each slot begins with it. While the writer is at work `sequence` is odd; afterwards twice the publication's number.
struct TapSlot {
  std::uint64_t sequence = 0;
  std::array<std::uint64_t, 7> reserved_words{};
};

struct TapPose {
  std::array<double, 3> position_mm{};            ///< of the origin, in the named frame
  std::array<double, 4> quaternion_wxyz{};        ///< [1]; rotates its vectors into it
  std::array<double, 3> sigma_mm{}, sigma_deg{};  ///< 1-sigma
};

/// How the pixels lie behind a frame: see docs/tap.md.
struct TapPicture {
  std::uint32_t width_px = 0, height_px = 0;  ///< 0: no picture came with this frame
  std::uint32_t luma_stride_bytes = 0, chroma_width = 0, chroma_height = 0;
  std::uint32_t chroma_step_bytes = 0, chroma_stride_bytes = 0;
  std::uint32_t cb_offset = 0, cr_offset = 0;  ///< [bytes] from the first pixel
  std::uint32_t pixel_bytes = 0;
};

struct TapDot {
  double u_px = 0, v_px = 0, semi_major_px = 0, semi_minor_px = 0;
  double angle_deg = 0;         ///< of the major axis, from +u towards +v
  double visible_fraction = 0;  ///< of its outline 0..1; 0: not seen
};

struct TapCandidate {
  std::array<double, 3> position_mm{};      ///< of the camera in the landmark's frame
  std::array<double, 4> quaternion_wxyz{};  ///< [1]
  double chi2_above = 0;                    ///< how much worse than the best one it explains the picture [1]
  double rms_px = 0;
};

struct TapLandmark {
  std::uint32_t id = 0, reason = 0;  ///< reason: as register `reason` [1]; 0: it may be acted on
  std::uint32_t quality = 0, dots_used = 0;
  std::uint32_t chosen = 0, candidate_count = 0;  ///< chosen: index of it
  double rival_odds = 0;                          ///< of the likeliest other reading, 0..1
  std::array<TapCandidate, kTapCandidateCount> candidates{};
};

/// A dark spot of the search: an ellipse.
struct TapSpot {
  float u_px = 0, v_px = 0, semi_major_px = 0, semi_minor_px = 0;
  float angle_deg = 0;  ///< of the major axis, from +u towards +v
};

/// Why a search of the whole picture found nothing, by the guess that came nearest to a landmark.
struct TapSearch {
  std::uint32_t has_failed = 0;  ///< 1: this frame's did; 0: nothing below means anything
  std::uint32_t refusal = 0;     ///< 0: there was no guess; else what speaks against it, docs/tap.md [1]
  std::uint32_t spots_seen = 0, spot_count = 0;  ///< dark spots; of them in `spots`, the largest
  double contrast_lsb = 0, noise_lsb = 0;        ///< of ink and paper of the guess; of the picture, 1-sigma
  std::array<TapDot, kTapDotCount> dots{};       ///< where the guess has them
  std::array<TapSpot, kTapSpotCount> spots{};
};

namespace tap_flag {
/// Bits of TapFrame::flags [1].
inline constexpr std::uint32_t kValid = 1U << 0, kFound = 1U << 1, kAmbiguous = 1U << 2, kHasPose = 1U << 3,
                               kCalibrated = 1U << 4, kTracking = 1U << 5, kEllipseSolver = 1U << 6, kInWorld = 1U << 7,
                               kHasTrack = 1U << 8, kDotsFromPose = 1U << 9, kHasHead = 1U << 10, kHeadLimit = 1U << 11,
                               kHeadFault = 1U << 12, kHeadInhibited = 1U << 13;
}  // namespace tap_flag

/// One processed frame: what was seen, and the report that came of it.
struct TapFrame {
  std::uint64_t number = 0;  ///< the source's own
  std::int64_t exposed_at_ns = 0, exposure_ns = 0, published_at_ns = 0, pose_exposed_at_ns = 0;
  std::int64_t latency_ns = 0, process_ns = 0, row_time_ns = 0;
  double gain = 0;
  TapPicture picture;
  std::uint32_t flags = 0, reason = 0;  ///< flags: tap_flag; reason: as register `reason` [1]
  std::uint32_t landmark_id = 0, quality = 0, dots_used = 0, occlusion_level = 0;
  std::uint32_t frames_processed = 0, frames_dropped = 0, frames_failed = 0, pose_sequence = 0;
  std::uint32_t runs_cut = 0, blobs_cut = 0, neighbours_cut = 0, hypotheses_cut = 0, frames_cut = 0;
  std::uint32_t landmarks_seen = 0, landmarks_rejected = 0, last_rejected_id = 0;
  std::uint32_t landmark_count = 0, order = 0, order_progress = 0, reserved = 0;
  double rms_px = 0, ambiguity = 0, distance_mm = 0, rival_odds = 0;
  double swing_deg = 0, tilt_deg = 0, pan_deg = 0, deviation_deg = 0;
  double head_pan_deg = 0, head_tilt_deg = 0;
  TapPose camera_in_landmark, camera_in_world, body_in_world;
  TapPose track;                                ///< of the camera in the world, over time
  std::array<double, 3> track_velocity_mm_s{};  ///< [mm/s]
  double track_ambiguity = 0;                   ///< 0..1
  std::array<TapDot, kTapDotCount> dots{};      ///< of the landmark that counts first
  std::array<TapLandmark, kTapLandmarkCount> landmarks{};
  std::array<std::uint32_t, kTapBinCount> latency_bins{};  ///< frames since the start, by latency
  TapSearch search;
};

struct TapClient {
  std::array<char, 64> address{};
  std::uint64_t requests = 0;
  std::int64_t connected_ns = 0, silent_ns = 0;
};

struct TapLogLine {
  std::int64_t at_ns = 0;
  std::array<char, 184> text{};  ///< UTF-8, ends with 0; longer lines are cut
};

/// What the service's main thread knows, ten times a second while somebody reads.
struct TapService {
  std::int64_t written_at_ns = 0;
  std::uint32_t register_count = 0, client_count = 0;
  double position_step_mm = 0;  ///< of 16-bit positions
  std::uint32_t float_low_first = 0, frame_loop_over = 0;
  std::uint64_t log_count =
      0;  ///< lines since the start; the newest kTapLogCount of them are in `log`, line n at n % kTapLogCount
  std::array<std::uint16_t, kTapRegisterCount> registers{};  ///< as a Modbus client reads them
  std::array<TapClient, kTapClientCount> clients{};
  std::array<TapLogLine, kTapLogCount> log{};
};

static_assert(std::is_trivially_copyable_v<TapHeader> && std::is_standard_layout_v<TapHeader>);
static_assert(std::is_trivially_copyable_v<TapFrame> && std::is_standard_layout_v<TapFrame>);
static_assert(std::is_trivially_copyable_v<TapService> && std::is_standard_layout_v<TapService>);
static_assert(sizeof(TapHeader) == 512 && sizeof(TapSlot) == 64 && sizeof(TapHeader) <= kTapPage_bytes);

}  // namespace ninedot
