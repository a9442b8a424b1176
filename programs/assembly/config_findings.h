#pragma once
/// What is found about a configuration: what the service would refuse at its start, and what it would wait for.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config_checks.h"

namespace ninedot {

/// Problems, which the service refuses, and notes about what it waits for. Memory: allocates. Threads: one.
class ConfigFindings {
 public:
  /// \param problems  of the file's text; must outlive this
  explicit ConfigFindings(const ConfigProblems& problems) : file_(problems), problems_(problems.list) {}

  void refuse(const char* key, const std::string& what) { problems_.push_back({file_.line_of(key), what, {}}); }
  void note(const char* key, const std::string& what) { notes_.push_back({file_.line_of(key), what, {}}); }

  /// Does what the service does at its start, for the key that it is about. Not for a table with mistakes in the file:
  /// there the key may not have been read at all.
  void attempt(const char* key, const std::function<void()>& step);

  /// What the camera agreed to when it was opened, one line; empty: it was not, or has nothing to say.
  void note_camera(const std::string& agreed) { camera_ = agreed; }
  const std::string& camera() const noexcept { return camera_; }

  /// A ninedotd runs on this file's port: then it is the one that has the devices.
  void note_running_service() { is_service_running_ = true; }

  /// By rising line, those of the map last.
  std::vector<ConfigProblem> problems() const;
  std::vector<ConfigProblem> notes() const;

 private:
  void note_absent(const char* key, const std::string& what);

  const ConfigProblems& file_;
  std::vector<ConfigProblem> problems_, notes_;
  std::string camera_;
  bool is_service_running_ = false;
};

/// What the file itself says and lacks, and nothing else: no device, port or other file but the map is looked at.
/// \param config, problems  as read_config gave them
void check_file(const Config& config, const ConfigProblems& problems, ConfigFindings& findings);

/// What `ninedot check --file-only` asks of the camera's keys: the service asks it before it looks at anything else.
void check_camera_keys(const Config& config, const ConfigProblems& problems, ConfigFindings& findings);

struct ConfigVerdict {
  std::vector<ConfigProblem> problems, notes;
};

/// `ninedot check --file-only` of text that is to become the file `path`.
ConfigVerdict check_text(std::string_view text, const std::string& path);

}  // namespace ninedot
