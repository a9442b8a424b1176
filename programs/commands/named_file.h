#pragma once
/// A new file in the place of one that the configuration names, a calibration of the camera or a map: where it goes,
/// and a file for it while it is on trial.
#include <cstdint>
#include <string>
#include <string_view>

namespace ninedot {

enum class NamedFile : std::uint8_t { kCalibration, kMap };

struct FilePlace {
  std::string path;         ///< the file that it is to become
  std::string config_text;  ///< the configuration that names it; empty: the one that there is does
};

/// The file that the configuration names; where it names none, camera.yaml or map.toml beside it, and a line that names
/// that. Of a map it takes the place of the [[landmarks]] as well.
/// \param config_text  of the file `config_path`
/// Throws StartupError(kWrongUsage): the configuration can't be read, there is no such file, or one is beside it that
/// it does not name. Memory: the text twice. Threads: one.
FilePlace place_for(NamedFile file, const std::string& config_text, const std::string& config_path);

/// FILE.new, or the first of FILE.new2, FILE.new3 .. that there is not: somebody may keep a file of his own there.
/// Threads: one; waits for the disk.
std::string free_name_beside(const std::string& file);

/// A file where the service's user may read it, which goes with this object unless it is kept.
/// Threads: one; waits for the disk.
class FileOnTrial {
 public:
  /// \param path  is written anew \param like  has the owner and the mode that it is to have
  /// Throws StartupError(kWorkFailed): it can't be written.
  FileOnTrial(std::string path, std::string_view text, const std::string& like);
  ~FileOnTrial();
  FileOnTrial(const FileOnTrial&) = delete;
  FileOnTrial& operator=(const FileOnTrial&) = delete;

  const std::string& path() const noexcept { return path_; }
  void keep() noexcept { is_kept_ = true; }

 private:
  const std::string path_;
  bool is_kept_ = false;
};

}  // namespace ninedot
