#include "programs/commands/new_calibration.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "base/startup_error.h"
#include "config/config_edit.h"
#include "drivers/posix/whole_file.h"
#include "programs/assembly/input_files.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "camera.yaml";
constexpr const char* kName = "\"camera.yaml\"";

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

std::string calibration_named_in(const std::string& config_text, const std::string& config_path) {
  ConfigProblems problems;
  Config config = read_config(config_text, config_path, config_path, problems);
  if (!problems.can_be_read) refuse_first(problems, config_path);
  return std::move(config.camera.calibration);
}

}  // namespace

CalibrationPlace place_for_calibration(const std::string& config_text, const std::string& config_path) {
  std::error_code error;
  const std::string named = calibration_named_in(config_text, config_path);
  if (!named.empty()) {
    if (!fs::is_regular_file(named, error))
      refuse(fmt::format("{}: is no file, and {} names it: put the first one there by hand", named, config_path));
    return {named, {}};
  }
  const std::string path = (fs::path(config_path).parent_path() / kFile).string();
  if (fs::exists(fs::symlink_status(path, error)))
    refuse(
        fmt::format("{}: is there, and {} does not name it: write `calibration = {}` under [camera], or move it away",
                    path, config_path, kName));
  return {path, with_keys(config_text, std::array{KeyText{"camera", "calibration", kName}}, config_path)};
}

FileOnTrial::FileOnTrial(std::string path, std::string_view text, const std::string& like) : path_(std::move(path)) {
  const auto written = [&]() -> Result<std::size_t> {
    NINEDOT_TRY(FileReplacement file, FileReplacement::begin(path_));
    NINEDOT_TRY([[maybe_unused]] const std::size_t rights, file.keep_rights(like));
    NINEDOT_TRY([[maybe_unused]] const std::size_t bytes,
                file.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
    return file.commit(Durability::kPowerCut);
  }();
  if (!written)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{}: {}: {}", path_, written.error().text, std::strerror(written.error().os_errno)));
}

FileOnTrial::~FileOnTrial() {
  if (!is_kept_) ::unlink(path_.c_str());
}

}  // namespace ninedot
