// `ninedot apply`: a new configuration, calibration of camera or head, or map in the old one's place, if the service
// comes up with it. Until that is known the old one is kept beside it, and brought back otherwise.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/startup_error.h"
#include "drivers/posix/signals.h"
#include "drivers/posix/text_file.h"
#include "programs/commands/candidate.h"
#include "programs/commands/child_check.h"
#include "programs/commands/child_work.h"
#include "programs/commands/commands.h"
#include "programs/commands/config_change.h"
#include "programs/commands/named_file.h"
#include "programs/commands/new_head.h"
#include "programs/commands/service_trial.h"
#include "programs/startup_errors.h"

namespace ninedot {
namespace {

struct ApplyArguments {
  std::string candidate = "-", config, check_as;
  std::vector<std::string> restart;
  int within_s = 30;
  bool is_calibration = false, is_head = false, is_map = false, page = false;
};

/// One line of progress. Whoever listened may be gone: that is no reason to stop half way.
void say(std::string_view phase, std::string_view words) {
  std::fputs(fmt::format("{}: {}\n", phase, words).c_str(), stdout);
  std::fflush(stdout);
  std::clearerr(stdout);
}

/// What is to be seen by whoever asked, and the word for how it ended.
class Apply {
 public:
  explicit Apply(const ApplyArguments& arguments)
      : arguments_(arguments),
        name_(arguments.page               ? arguments.config
              : arguments.candidate == "-" ? "standard input"
                                           : arguments.candidate) {}

  void run() {
    const Candidate candidate = this->candidate();
    const ApplyLock lock(arguments_.config);
    if (candidate.kind == CandidateKind::kCalibration) return put_file(NamedFile::kCalibration, candidate.text);
    if (candidate.kind == CandidateKind::kMap) return put_file(NamedFile::kMap, candidate.text);
    ConfigChange change(arguments_.config);
    const bool is_head = candidate.kind == CandidateKind::kHead;
    const std::string text = is_head ? merged(change.text(), candidate.text) : candidate.text;
    if (!is_new(change, text)) return;
    const CheckedConfig checked = check({text, is_head ? arguments_.config : name_, arguments_.config, {}});
    try_out(change, text, checked, change.last_good());
  }

  /// How it failed.
  const char* failure(ExitStatus status) const noexcept {
    return is_back_ ? "back" : status == ExitStatus::kWrongUsage ? "refused" : "failed";
  }

 private:
  Candidate candidate() const {
    if (arguments_.page) return read_request(STDIN_FILENO);
    return {arguments_.is_calibration ? CandidateKind::kCalibration
            : arguments_.is_head      ? CandidateKind::kHead
            : arguments_.is_map       ? CandidateKind::kMap
                                      : CandidateKind::kConfiguration,
            read_candidate(arguments_.candidate)};
  }

  std::string merged(const std::string& config, const std::string& head) const {
    std::string text =
        in_child(arguments_.check_as, "the merging", [&] { return with_head(config, arguments_.config, head, name_); });
    if (text.size() > kMaxApplied_bytes)
      throw StartupError(ExitStatus::kWrongUsage,
                         fmt::format("{}: would be longer than {} bytes", arguments_.config, kMaxApplied_bytes));
    return text;
  }

  /// The file that the configuration names, or a first one, which it names from then on.
  void put_file(NamedFile which, const std::string& text) {
    const std::string config = read_text_file(arguments_.config, kMaxApplied_bytes);
    const FilePlace place = place_for(which, config, arguments_.config);
    if (place.config_text.empty()) {
      ConfigChange change(place.path);
      if (!is_new(change, text)) return;
      const FileOnTrial file(free_name_beside(place.path), text, place.path);
      ConfigToCheck subject{config, arguments_.config, arguments_.config, {}};
      (which == NamedFile::kMap ? subject.map : subject.calibration) = file.path();
      const CheckedConfig checked = check(subject);
      return try_out(change, text, checked, config);
    }
    ConfigChange change(arguments_.config);
    is_new(change, place.config_text);
    // Until the configuration names it nobody reads it.
    FileOnTrial file(place.path, text, arguments_.config);
    const CheckedConfig checked = check({place.config_text, arguments_.config, arguments_.config, {}});
    try_out(change, place.config_text, checked, change.last_good());
    file.keep();
  }

  /// Says what there is to say where it is not, or where an earlier one was cut short.
  static bool is_new(const ConfigChange& change, const std::string& text) {
    if (change.was_cut_short()) {
      say("note", fmt::format("an earlier apply was cut short; what ran before it is {}", change.last_good_path()));
      return true;
    }
    if (text == change.text()) say("unchanged", change.path() + " holds this already");
    return text != change.text();
  }

  CheckedConfig check(const ConfigToCheck& subject) const {
    say("checking", !subject.calibration.empty() ? subject.calibration
                    : !subject.map.empty()       ? subject.map
                                                 : subject.name);
    CheckedConfig checked = check_in_child(subject, arguments_.check_as, CheckDepth::kEverything);
    for (const std::string& note : checked.notes) say("note", note);
    if (!checked.refused.empty()) throw StartupErrors(checked.refused);
    return checked;
  }

  /// \param last_config  with which it ran
  void try_out(ConfigChange& change, const std::string& text, const CheckedConfig& checked,
               const std::string& last_config) {
    const TerminationSignals signals;
    const TrialTeller tell = say;
    ServiceTrial trial({arguments_.restart, std::chrono::seconds(arguments_.within_s)}, signals, tell);
    // Before anything is changed: on the way back nothing may fail that can be done now.
    const CheckedConfig old = check_in_child({last_config, arguments_.config, arguments_.config, {}},
                                             arguments_.check_as, CheckDepth::kEndpointOnly);
    say("replacing", change.path());
    change.put(text);
    const std::optional<std::string> reason = trial.restart_and_watch(checked.host, checked.port);
    if (!reason) {
      change.confirm();
      return say("up", fmt::format("it runs; the one before is {}", change.before_path()));
    }
    say("returning", *reason);
    change.put_back();
    const std::optional<std::string> again = trial.restart_and_watch(old.host, old.port);
    is_back_ = !again;
    throw StartupError(ExitStatus::kWorkFailed,
                       again ? fmt::format("{}: as it was before, because with the new one: {}; with the old one the "
                                           "service does not run either: {}",
                                           change.path(), *reason, *again)
                             : fmt::format("{}: as it was before, and the service runs with it; with the new one: {}",
                                           change.path(), *reason));
  }

  const ApplyArguments& arguments_;
  const std::string name_;
  bool is_back_ = false;
};

void say_lines(const char* phase, std::string_view lines) {
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    say(phase, line);
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
  }
}

void run_apply(const ApplyArguments& arguments) {
  Apply apply(arguments);
  try {
    apply.run();
  } catch (const StartupError& error) {
    // The other end of the connection does not see standard error.
    if (arguments.page) say_lines(apply.failure(error.status), error.what());
    throw;
  }
}

}  // namespace

void add_apply_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "apply",
      "Put a new configuration, a calibration of the camera or of the head, or a map in the place of the service's, "
      "restart it, and go back if it does not come up with it");
  const auto arguments = std::make_shared<ApplyArguments>();
  CLI::Option* const candidate =
      command->add_option("new", arguments->candidate, "the new configuration; - is standard input");
  CLI::Option* const calibration = command->add_flag(
      "--calibration", arguments->is_calibration,
      "the new file is a calibration of the camera: it takes the place of the one that the configuration names");
  CLI::Option* const head = command->add_flag(
      "--head", arguments->is_head,
      "the new file is of `ninedot calibrate pan-tilt`: its keys take the place of those of the configuration");
  CLI::Option* const map = command->add_flag(
      "--map", arguments->is_map,
      "the new file is of `ninedot map`: it takes the place of the map that the configuration names, or of its "
      "[[landmarks]]");
  command->add_option("--config", arguments->config, "the file that the service reads")->required();
  command
      ->add_option("--restart", arguments->restart,
                   "program and arguments that restart the service and fail where it does not come up; default: "
                   "systemctl restart ninedotd")
      ->expected(1, 16);
  command
      ->add_option("--within", arguments->within_s,
                   "seconds that the service has to come up, and to have stayed up for three [s]")
      ->check(CLI::Range(5, 600))
      ->capture_default_str();
  command->add_option("--check-as", arguments->check_as,
                      "user with whose rights the new configuration is checked; for root");
  CLI::Option* const page = command->add_flag("--page", arguments->page,
                                              "standard input is a connection of ninedot-web: a line `apply BYTES`, "
                                              "`calibration BYTES`, `head BYTES` or `map BYTES`, then the file");
  page->excludes(candidate)->excludes(calibration)->excludes(head)->excludes(map);
  head->excludes(calibration);
  map->excludes(calibration)->excludes(head);
  command->callback([arguments, candidate, page] {
    if (candidate->count() + page->count() == 0)
      throw StartupError(ExitStatus::kWrongUsage, "name the new file, or - for standard input");
    run_apply(*arguments);
  });
}

}  // namespace ninedot
