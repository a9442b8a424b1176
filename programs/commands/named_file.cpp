#include "programs/commands/named_file.h"

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

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

/// How a configuration names one.
struct Naming {
  std::string named;  ///< the file; empty: it names none
  const char* file;   ///< that it is to name then, beside it
  const char* where;  ///< it is to be named, for people
};

Naming naming_of(NamedFile file, const std::string& config_text, const std::string& config_path) {
  ConfigProblems problems;
  const Config config = read_config(config_text, config_path, config_path, problems);
  if (!problems.can_be_read) refuse_first(problems, config_path);
  if (file == NamedFile::kMap) return {config.map, "map.toml", "`map = \"map.toml\"` at its top"};
  return {config.camera.calibration, "camera.yaml", "`calibration = \"camera.yaml\"` under [camera]"};
}

}  // namespace

FilePlace place_for(NamedFile file, const std::string& config_text, const std::string& config_path) {
  std::error_code error;
  const Naming naming = naming_of(file, config_text, config_path);
  if (!naming.named.empty()) {
    if (!fs::is_regular_file(naming.named, error))
      refuse(
          fmt::format("{}: is no file, and {} names it: put the first one there by hand", naming.named, config_path));
    return {naming.named, {}};
  }
  const std::string path = (fs::path(config_path).parent_path() / naming.file).string();
  if (fs::exists(fs::symlink_status(path, error)))
    refuse(fmt::format("{}: is there, and {} does not name it: write {}, or move it away", path, config_path,
                       naming.where));
  const std::string value = fmt::format("\"{}\"", naming.file);
  if (file == NamedFile::kMap) return {path, with_map_named(config_text, value, config_path)};
  return {path, with_keys(config_text, std::array{KeyText{"camera", "calibration", value}}, config_path)};
}

std::string free_name_beside(const std::string& file) {
  std::string name = file + ".new";
  std::error_code error;
  for (int number = 2; fs::exists(fs::symlink_status(name, error)); ++number)
    name = fmt::format("{}.new{}", file, number);
  return name;
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
