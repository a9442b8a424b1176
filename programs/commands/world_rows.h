#pragma once
/// The CSV files of `ninedot replay --out-world` and `--out-track`: where the camera is in the world, frame by frame.
///
/// | column | unit | what |
/// |---|---|---|
/// | frame | | the recording's frame number |
/// | timestamp_ns | ns | middle of the exposure, on the recording's clock |
/// | x_mm y_mm z_mm | mm | optical centre in the world; of the body its origin |
/// | qw qx qy qz | | rotates camera (body) vectors into the world (w >= 0) |
/// | sigma_x_mm sigma_y_mm sigma_z_mm | mm | 1-sigma along the world's axes |
/// | sigma_rot_deg | deg | 1-sigma of the rotation's angle: root of the sum of its three variances |
/// | ambiguity | | odds of all other places, 0..1 |
/// | landmarks_used | | how many the pose is made of; of a track: of this frame's |
/// | landmarks_rejected | | ids of those that do not hang where the map says, separated by spaces |
/// | vx_mm_s vy_mm_s vz_mm_s | mm/s | of a track: velocity of the optical centre, in the world |
/// | yaw_deg pitch_deg roll_deg, or w_deg p_deg r_deg, or a_deg b_deg c_deg | deg | with --euler: its rotation |
/// | sigma_yaw_deg ... | deg | with --euler: 1-sigma of each of them |
#include <optional>
#include <string>

#include "drivers/posix/output_file.h"
#include "geometry/body.h"
#include "image/frame.h"
#include "pipeline/frame_processor.h"
#include "proto/wire_report.h"

namespace ninedot {

struct WorldRowsOptions {
  double max_ambiguity = 0.01;           ///< of a track: beyond it there is no row
  std::optional<BodyGeometry> body;      ///< where the camera sits, to write the body's pose; none: the camera's
  std::optional<EulerConvention> euler;  ///< angles to add; none: none
};

/// One of the two files. Throws StartupError as OutputFile does. Memory: allocates.
class WorldRows {
 public:
  enum class Kind { kWorld, kTrack };
  /// \param path  of a file; empty: nothing is written. The head stands as the recording says.
  WorldRows(const std::string& path, Kind kind, const WorldRowsOptions& options);

  /// Whether a frame has a pose of this kind that may be acted on.
  static bool has_row(Kind kind, const Fix& fix, double max_ambiguity) noexcept;

  /// A row where has_row() says so.
  void add(const Frame& frame, const Fix& fix);
  /// \return  to be finished with others; null: none is written. Lives as long as this.
  OutputFile* file() noexcept { return file_ ? &*file_ : nullptr; }

 private:
  std::optional<OutputFile> file_;
  Kind kind_;
  WorldRowsOptions options_;
};

}  // namespace ninedot
