#include "programs/assembly/config_findings.h"

#include <algorithm>
#include <cerrno>

#include "base/startup_error.h"
#include "drivers/camera/camera_device.h"
#include "drivers/posix/late_device.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/open_source.h"

namespace ninedot {
namespace {

/// Of a camera: not there, busy, not permitted, or without a signal. Anything else is a setting that it does not have.
bool is_absent(int error) {
  for (const int mended : {ENOENT, ENODEV, ENXIO, EBUSY, EACCES, EPERM, ENOLINK})
    if (error == mended) return true;
  return false;
}

std::vector<ConfigProblem> in_order(std::vector<ConfigProblem> list) {
  std::ranges::stable_sort(list, {}, &ConfigProblem::place);
  return list;
}

}  // namespace

void ConfigFindings::attempt(const char* key, const std::function<void()>& step) {
  if (file_.is_in(std::string_view(key).substr(0, std::string_view(key).find('.')))) return;
  try {
    step();
  } catch (const DeviceAbsent& absent) {
    note_absent(key, absent.what());
  } catch (const CameraRefused& camera) {
    if (is_absent(camera.os_errno))
      note_absent(key, camera.what());
    else
      refuse(key, camera.what());
  } catch (const StartupError& error) {
    refuse(key, error.what());
  }
}

void ConfigFindings::note_absent(const char* key, const std::string& what) {
  note(key, is_service_running_ ? "a ninedotd is running, which may be what has it: " + what : "waits for it: " + what);
}

std::vector<ConfigProblem> ConfigFindings::problems() const { return in_order(problems_); }
std::vector<ConfigProblem> ConfigFindings::notes() const { return in_order(notes_); }

void check_file(const Config& config, const ConfigProblems& problems, ConfigFindings& findings) {
  if (problems.can_be_read) findings.attempt("landmarks", [&] { static_cast<void>(localiser_options(config)); });
  if (!config.camera.wait_for_device)
    findings.note("camera.wait_for_device", "without effect: the service always waits for its camera; remove it");
}

void check_camera_keys(const Config& config, const ConfigProblems& problems, ConfigFindings& findings) {
  // What could not be read says nothing of devices.
  if (!problems.can_be_read || problems.is_in("camera")) return;
  const CameraConfig& camera = config.camera;
  findings.attempt("camera.device", [&] { check_device_named(camera); });
  // Without a recording there is no calibration of its own either; that is no second mistake.
  if (camera.source != "recording" && camera.source != "simulated")
    findings.attempt("camera.calibration", [&] { calibration_file(camera); });
}

ConfigVerdict check_text(std::string_view text, const std::string& path) {
  ConfigProblems problems;
  const Config config = read_config(text, path, path, problems);
  ConfigFindings findings(problems);
  check_file(config, problems, findings);
  check_camera_keys(config, problems, findings);
  return {findings.problems(), findings.notes()};
}

}  // namespace ninedot
