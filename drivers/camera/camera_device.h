#pragma once
/// A camera as ReopeningSource sees it: something that is opened, gives frames, and may vanish.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "base/mono_time.h"
#include "base/result.h"
#include "base/startup_error.h"
#include "drivers/camera/bayer.h"
#include "image/frame.h"

namespace ninedot {

/// Against the flicker of lamps.
enum class PowerLine { kUnchanged, kOff, k50Hz, k60Hz, kAutomatic };

/// Of the lens.
enum class Focus {
  kUnchanged,  ///< as the camera has it
  kFixed,      ///< no autofocus; the lens stands where CameraRequest::focus_position says
  kAutomatic,  ///< autofocus, always on
};

/// What is asked of a camera.
struct CameraRequest {
  std::string device;  ///< V4L2 path or "sensor:NAME", or libcamera id or model
  int width_px = 640;
  int height_px = 480;
  double rate_hz = 35;                           ///< frames per second
  std::string pixel_format = "auto";             ///< a name of pixel_formats(), or "auto"
  std::chrono::nanoseconds exposure{0};          ///< 0 = automatic
  BayerBalance bayer;                            ///< of pixel formats that are a sensor's mosaic
  double gain = 0;                               ///< 0 = automatic; V4L2: in the driver's units, libcamera: a factor
  bool lower_rate_in_the_dark = false;           ///< automatic exposure may lower the frame rate
  PowerLine power_line = PowerLine::kUnchanged;  ///< V4L2 only
  Focus focus = Focus::kUnchanged;
  /// V4L2: the driver's steps; libcamera: 1 / distance [1/m]; below 0: not said
  double focus_position = -1;
  /// There is a calibration, which holds for one focus of the lens: a camera that focuses by itself is refused.
  bool is_calibrated = false;
  std::string calibrated_id;            ///< of the calibration's camera (camera_identity.h); empty: unknown
  std::chrono::nanoseconds readout{0};  ///< see ShutterTiming::readout
  /// Frame::row_time of every frame: no driver tells it. 0 = global shutter, or unknown.
  std::chrono::nanoseconds row_time{0};
  /// camera.row_time_us, to be held against what a sensor tells of its lines; no frame is changed by it.
  std::chrono::nanoseconds expected_row_time{0};
};

/// Why a camera can't be opened: the line for the user, and the errno behind it (0 = none).
class CameraRefused : public StartupError {
 public:
  CameraRefused(const std::string& line, int error) : StartupError(ExitStatus::kWrongUsage, line), os_errno(error) {}
  int os_errno;
};

/// A buffer of the device's with the newest frame in it.
struct GrabbedFrame {
  Frame frame;                 ///< its pixels are valid until `release`; its number is the source's to give
  std::uint32_t buffer = 0;    ///< for `release`
  std::uint32_t sequence = 0;  ///< the device's count of frames, wraps; starts anew with each opening
  std::uint32_t skipped = 0;   ///< good frames given back unseen since the grab before, because this one is newer
  std::uint32_t flagged = 0;   ///< buffers given back as damaged since then
};

/// Threads: see each method. One thread opens and closes a device, another one grabs from it; they hand it over between
/// them (ReopeningSource), so that none of `open`, `close` and `grab` runs beside another.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  /// Opens, agrees on a format, sets all controls, starts. May take a second and may allocate. Throws CameraRefused;
  /// then the device is closed again. Not while it is open (contract). Threads: one at a time.
  virtual void open() = 0;
  /// Stops and gives everything back; harmless when closed. No buffer may be lent. Threads: as `open`, never beside
  /// `grab`.
  virtual void close() noexcept = 0;
  /// What was agreed on, for the log: "GREY 640x480, 30 Hz, exposure 5000 us". Empty before the first opening.
  /// Threads: the one that opens.
  virtual std::string description() const = 0;
  /// Of the newest opening. Threads: the one that opens.
  virtual std::chrono::nanoseconds frame_period() const noexcept = 0;

  /// The newest frame. One that is there is returned whatever the deadline.
  /// \error kNoFrame: none came in time. kFrameUnreadable: this one is damaged, the device is well. Any other: the
  ///        device must be closed and opened again.
  /// Memory: none of ours. Threads: one caller, while open.
  virtual Result<GrabbedFrame> grab(MonoTime deadline) noexcept = 0;
  /// Threads: any, while open; the frame loop's above all: waits for nobody.
  virtual void release(std::uint32_t buffer) noexcept = 0;

  /// Asks the device what may have changed by itself since it was opened, such as an automatic exposure. May block as
  /// long as the device takes to answer; `grab` goes on meanwhile and uses what was known before.
  /// \return  when to ask again; nothing: never
  /// Threads: the one that opens and closes, while open.
  virtual std::optional<std::chrono::nanoseconds> refresh() noexcept { return std::nullopt; }
};

}  // namespace ninedot
