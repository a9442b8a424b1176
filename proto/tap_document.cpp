// One line per member, with its place taken from the structure itself: the document can't say another one.
#include "proto/tap_document.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <type_traits>

#include "proto/tap_layout.h"

namespace ninedot {
namespace {

template <typename T>
constexpr std::string_view name_of() {
  if constexpr (std::is_same_v<T, std::uint16_t>)
    return "u16";
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return "u32";
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return "u64";
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return "i64";
  else if constexpr (std::is_same_v<T, double>)
    return "f64";
  else if constexpr (std::is_same_v<T, float>)
    return "f32";
  else if constexpr (std::is_same_v<T, char>)
    return "char";
  else if constexpr (std::is_same_v<T, TapPose>)
    return "TapPose";
  else if constexpr (std::is_same_v<T, TapPicture>)
    return "TapPicture";
  else if constexpr (std::is_same_v<T, TapDot>)
    return "TapDot";
  else if constexpr (std::is_same_v<T, TapLandmark>)
    return "TapLandmark";
  else if constexpr (std::is_same_v<T, TapCandidate>)
    return "TapCandidate";
  else if constexpr (std::is_same_v<T, TapSpot>)
    return "TapSpot";
  else if constexpr (std::is_same_v<T, TapSearch>)
    return "TapSearch";
  else if constexpr (std::is_same_v<T, TapClient>)
    return "TapClient";
  else if constexpr (std::is_same_v<T, TapLogLine>)
    return "TapLogLine";
}

template <typename T>
struct TypeOf {
  static constexpr std::string_view kName = name_of<T>();
};
template <typename T, std::size_t N>
struct TypeOf<std::array<T, N>> : TypeOf<T> {};

#define FIELD(structure, member, meaning)                                                                           \
  TapField {                                                                                                        \
#member, TypeOf < decltype(structure::member)> ::kName, offsetof(structure, member), sizeof(structure::member), \
        meaning                                                                                                     \
  }

constexpr TapField kTapHeaderFields[] = {
    FIELD(TapHeader, magic, "`NINETAP` and a zero"),
    FIELD(TapHeader, version, "of this layout: 3"),
    FIELD(TapHeader, byte_order, "0x01020304 as the writer's machine stores it"),
    FIELD(TapHeader, segment_bytes, "size of the file"),
    FIELD(TapHeader, frame_slots_offset, "first slot of frames"),
    FIELD(TapHeader, frame_slot_bytes, "from one slot to the next"),
    FIELD(TapHeader, pixels_offset, "pixels, from their slot's start"),
    FIELD(TapHeader, pixels_capacity, "room for them in a slot"),
    FIELD(TapHeader, service_slots_offset, "first slot of the service's part"),
    FIELD(TapHeader, service_slot_bytes, "from one slot to the next"),
    FIELD(TapHeader, slot_count, "of either kind: 3"),
    FIELD(TapHeader, process_id, "of the service"),
    FIELD(TapHeader, started_at_ns, "when the service started"),
    FIELD(TapHeader, software, "version of the service, ends with 0"),
    FIELD(TapHeader, width_px, "of the calibration"),
    FIELD(TapHeader, height_px, "of the calibration"),
    FIELD(TapHeader, lens_model, "0 plumb_bob, 1 rational_polynomial, 2 equidistant"),
    FIELD(TapHeader, reserved, "0"),
    FIELD(TapHeader, intrinsics_px, "fx, fy, cx, cy"),
    FIELD(TapHeader, distortion, "coefficients in the model's own order"),
    FIELD(TapHeader, ring_radius_mm, "of the landmark: to the middles of P1..P8"),
    FIELD(TapHeader, dot_radius_mm, "of P1..P8"),
    FIELD(TapHeader, centre_radius_mm, "of P9"),
    FIELD(TapHeader, rate_hz, "frames per second, as configured"),
    FIELD(TapHeader, reserved_words, "0"),
    FIELD(TapHeader, newest_frame, "publications of frames: n; 0 none yet. The newest is in slot (n - 1) modulo 3"),
    FIELD(TapHeader, newest_service, "likewise of the service's part"),
};
constexpr TapField kTapSlotFields[] = {
    FIELD(TapSlot, sequence, "2 n when publication n is whole, odd while one is written"),
    FIELD(TapSlot, reserved_words, "0"),
};
constexpr TapField kTapFrameFields[] = {
    FIELD(TapFrame, number, "the source's own count"),
    FIELD(TapFrame, exposed_at_ns, "middle of the exposure of this frame"),
    FIELD(TapFrame, exposure_ns, "its length; 0 unknown"),
    FIELD(TapFrame, published_at_ns, "when the report was out"),
    FIELD(TapFrame, pose_exposed_at_ns, "middle of the exposure that the pose is of; 0: there has been none"),
    FIELD(TapFrame, latency_ns, "from the middle of the exposure to the report"),
    FIELD(TapFrame, process_ns, "detection and pose alone"),
    FIELD(TapFrame, row_time_ns, "rolling shutter: from row to row"),
    FIELD(TapFrame, gain, "a factor; not a number: unknown"),
    FIELD(TapFrame, picture, "how the pixels lie, see TapPicture"),
    FIELD(TapFrame, flags,
          "bits: 0 valid, 1 found, 2 ambiguous, 3 there has been a pose, 4 calibrated, 5 tracking, 6 solver `ellipse`, "
          "7 a place in the world, 8 a track, 9 dots from the pose, 10 head, 11 its end of range, 12 its fault, 13 "
          "inhibited"),
    FIELD(TapFrame, reason, "register `reason`: 0 or why the pose is not valid"),
    FIELD(TapFrame, landmark_id, "that the pose is of"),
    FIELD(TapFrame, quality, "0..1000"),
    FIELD(TapFrame, dots_used, "of nine"),
    FIELD(TapFrame, occlusion_level, "0..3"),
    FIELD(TapFrame, frames_processed, "since the start, wraps"),
    FIELD(TapFrame, frames_dropped, "likewise"),
    FIELD(TapFrame, frames_failed, "likewise"),
    FIELD(TapFrame, pose_sequence, "valid poses, wraps"),
    FIELD(TapFrame, runs_cut, "search: dark stretches of rows left out"),
    FIELD(TapFrame, blobs_cut, "search: dark spots left out"),
    FIELD(TapFrame, neighbours_cut, "search: neighbours left out"),
    FIELD(TapFrame, hypotheses_cut, "search: guesses left out"),
    FIELD(TapFrame, frames_cut, "frames beyond their budget"),
    FIELD(TapFrame, landmarks_seen, "of the map, in this frame"),
    FIELD(TapFrame, landmarks_rejected, "of these: they hang elsewhere"),
    FIELD(TapFrame, last_rejected_id, "65535: none since the start"),
    FIELD(TapFrame, landmark_count, "entries of `landmarks` that are used"),
    FIELD(TapFrame, order, "number of the head's order"),
    FIELD(TapFrame, order_progress, "0 none, 1 under way, 2 done, 3 failed"),
    FIELD(TapFrame, reserved, "0"),
    FIELD(TapFrame, rms_px, "residual"),
    FIELD(TapFrame, ambiguity, "odds of all other readings, 0..1"),
    FIELD(TapFrame, distance_mm, "from P9 to the camera"),
    FIELD(TapFrame, rival_odds, "of the likeliest other reading; 0 none"),
    FIELD(TapFrame, swing_deg, "psi of the founding paper"),
    FIELD(TapFrame, tilt_deg, "phi: line of sight to the sheet's normal"),
    FIELD(TapFrame, pan_deg, "theta"),
    FIELD(TapFrame, deviation_deg, "delta: optical axis to P9"),
    FIELD(TapFrame, head_pan_deg, "positive to the left"),
    FIELD(TapFrame, head_tilt_deg, "positive upwards"),
    FIELD(TapFrame, camera_in_landmark, "last valid pose, in the frame of its landmark; TapPose"),
    FIELD(TapFrame, camera_in_world, "likewise by the map"),
    FIELD(TapFrame, body_in_world, "likewise of the robot's body"),
    FIELD(TapFrame, track, "of the camera in the world, filtered over time; with bit 8"),
    FIELD(TapFrame, track_velocity_mm_s, "of it"),
    FIELD(TapFrame, track_ambiguity, "0..1"),
    FIELD(TapFrame, dots, "P1..P9 of the landmark that counts first; TapDot"),
    FIELD(TapFrame, landmarks, "all that gave a pose, valid or not; TapLandmark"),
    FIELD(TapFrame, latency_bins,
          "frames since the start, by latency: bin i ends at 100 us * 2^(i/4), the last one takes the rest"),
    FIELD(TapFrame, search, "why nothing was found; TapSearch"),
};
constexpr TapField kTapPoseFields[] = {
    FIELD(TapPose, position_mm, "of the origin, in the named frame"),
    FIELD(TapPose, quaternion_wxyz, "turns its vectors into that frame"),
    FIELD(TapPose, sigma_mm, "1-sigma along the named frame's axes"),
    FIELD(TapPose, sigma_deg, "1-sigma about the camera's (the body's) own axes"),
};
constexpr TapField kTapPictureFields[] = {
    FIELD(TapPicture, width_px, "0: this frame came without a picture"),
    FIELD(TapPicture, height_px, ""),
    FIELD(TapPicture, luma_stride_bytes, "from row to row; luma begins at the first pixel"),
    FIELD(TapPicture, chroma_width, "samples in a row; 0: grey"),
    FIELD(TapPicture, chroma_height, "rows of samples"),
    FIELD(TapPicture, chroma_step_bytes, "from sample to sample"),
    FIELD(TapPicture, chroma_stride_bytes, "from row to row"),
    FIELD(TapPicture, cb_offset, "first Cb, from the first pixel"),
    FIELD(TapPicture, cr_offset, "first Cr, likewise"),
    FIELD(TapPicture, pixel_bytes, "all of it"),
};
constexpr TapField kTapDotFields[] = {
    FIELD(TapDot, u_px, "middle"),
    FIELD(TapDot, v_px, ""),
    FIELD(TapDot, semi_major_px, ""),
    FIELD(TapDot, semi_minor_px, ""),
    FIELD(TapDot, angle_deg, "of the major axis, from +u towards +v"),
    FIELD(TapDot, visible_fraction, "0..1; 0: not seen"),
};
constexpr TapField kTapLandmarkFields[] = {
    FIELD(TapLandmark, id, ""),
    FIELD(TapLandmark, reason, "0: it may be acted on, else why not"),
    FIELD(TapLandmark, quality, "0..1000"),
    FIELD(TapLandmark, dots_used, "of nine"),
    FIELD(TapLandmark, chosen, "which candidate is believed"),
    FIELD(TapLandmark, candidate_count, ""),
    FIELD(TapLandmark, rival_odds, "of the likeliest other reading"),
    FIELD(TapLandmark, candidates, "planar solutions, the best first; TapCandidate"),
};
constexpr TapField kTapCandidateFields[] = {
    FIELD(TapCandidate, position_mm, "of the camera in the landmark's frame"),
    FIELD(TapCandidate, quaternion_wxyz, ""),
    FIELD(TapCandidate, chi2_above, "how much worse than the best it explains the picture"),
    FIELD(TapCandidate, rms_px, "residual"),
};
constexpr TapField kTapSearchFields[] = {
    FIELD(TapSearch, has_failed, "1: the whole picture was searched, and nothing found; 0: the rest means nothing"),
    FIELD(TapSearch, refusal,
          "what speaks against the guess that came nearest: 0 there was none of three dots or more, 1 too few dots, 2 "
          "too faint, 3 no blank "
          "paper between its dots, 4 no ninth dot, 5 paper where dots should be or other spots, 6 its outlines do not "
          "fit"),
    FIELD(TapSearch, spots_seen, "dark spots that could have been dots"),
    FIELD(TapSearch, spot_count, "entries of `spots` that are used"),
    FIELD(TapSearch, contrast_lsb, "between ink and paper of the guess, grey levels"),
    FIELD(TapSearch, noise_lsb, "of the picture, 1-sigma, grey levels"),
    FIELD(TapSearch, dots, "where the guess has them, numbered from any; TapDot"),
    FIELD(TapSearch, spots, "the largest first; TapSpot"),
};
constexpr TapField kTapSpotFields[] = {
    FIELD(TapSpot, u_px, "middle"),
    FIELD(TapSpot, v_px, ""),
    FIELD(TapSpot, semi_major_px, "of the ellipse with the same second moments"),
    FIELD(TapSpot, semi_minor_px, ""),
    FIELD(TapSpot, angle_deg, "of the major axis, from +u towards +v"),
};
constexpr TapField kTapServiceFields[] = {
    FIELD(TapService, written_at_ns, ""),
    FIELD(TapService, register_count, "of `registers` that are used"),
    FIELD(TapService, client_count, "of `clients` that are used"),
    FIELD(TapService, position_step_mm, "of 16-bit positions"),
    FIELD(TapService, float_low_first, "1: float registers have their low word first"),
    FIELD(TapService, frame_loop_over, "1: a recording that does not loop is over"),
    FIELD(TapService, log_count, "lines since the start; line n is at n modulo 24"),
    FIELD(TapService, registers, "as a Modbus client that asks now reads them"),
    FIELD(TapService, clients, "TapClient"),
    FIELD(TapService, log, "TapLogLine"),
};
constexpr TapField kTapClientFields[] = {
    FIELD(TapClient, address, "ends with 0"),
    FIELD(TapClient, requests, "that it made"),
    FIELD(TapClient, connected_ns, "for so long"),
    FIELD(TapClient, silent_ns, "since its last request"),
};
constexpr TapField kTapLogLineFields[] = {
    FIELD(TapLogLine, at_ns, ""),
    FIELD(TapLogLine, text, "UTF-8, ends with 0"),
};
constexpr TapStructure kStructures[] = {
    {"TapHeader", "at the file's start, one page. Only the two counts at its end change", sizeof(TapHeader),
     kTapHeaderFields},
    {"TapSlot", "begins each slot; what it holds follows at once", sizeof(TapSlot), kTapSlotFields},
    {"TapFrame", "in each slot of frames", sizeof(TapFrame), kTapFrameFields},
    {"TapPose", "a pose with its uncertainty", sizeof(TapPose), kTapPoseFields},
    {"TapPicture", "how the pixels lie behind a frame", sizeof(TapPicture), kTapPictureFields},
    {"TapDot", "an outline in the picture, pixel centres at integers", sizeof(TapDot), kTapDotFields},
    {"TapLandmark", "what the frame says of one landmark", sizeof(TapLandmark), kTapLandmarkFields},
    {"TapCandidate", "one reading of a landmark", sizeof(TapCandidate), kTapCandidateFields},
    {"TapSearch", "a search that found nothing", sizeof(TapSearch), kTapSearchFields},
    {"TapSpot", "a dark spot, pixel centres at integers", sizeof(TapSpot), kTapSpotFields},
    {"TapService", "in each slot of the service's part, ten times a second", sizeof(TapService), kTapServiceFields},
    {"TapClient", "a Modbus client", sizeof(TapClient), kTapClientFields},
    {"TapLogLine", "a line of the service's log", sizeof(TapLogLine), kTapLogLineFields},
};
#undef FIELD

constexpr std::size_t size_of(std::string_view type) noexcept {
  if (type == "char") return 1;
  if (type == "u16") return 2;
  if (type == "u32" || type == "f32") return 4;
  for (const TapStructure& structure : kStructures)
    if (structure.name == type) return structure.size;
  return 8;
}

}  // namespace

std::span<const TapStructure> tap_structures() { return kStructures; }

std::string tap_layout_markdown() {
  std::string text;
  for (const TapStructure& structure : kStructures) {
    text += fmt::format("\n### {}, {} bytes\n\n{}.\n\n| offset | member | type | meaning |\n|---|---|---|---|\n",
                        structure.name, structure.size, structure.meaning);
    for (const TapField& field : structure.fields) {
      const std::size_t count = field.size / size_of(field.type);
      text += fmt::format("| {} | `{}` | {}{} | {} |\n", field.offset, field.name, field.type,
                          count == 1 ? "" : fmt::format("[{}]", count), field.meaning);
    }
  }
  return text;
}

}  // namespace ninedot
