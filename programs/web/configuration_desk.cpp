#include "programs/web/configuration_desk.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "base/json_text.h"
#include "base/startup_error.h"
#include "config/config_reference.h"
#include "drivers/posix/text_file.h"
#include "programs/assembly/config_findings.h"
#include "programs/web/access.h"

namespace ninedot {
namespace {

/// Which text it is. Not a secret: who wants to change it has the token.
std::string tag_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325U;  // FNV-1a, 64 bits
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return fmt::format("{:016x}", hash);
}

std::string problems_json(const std::vector<ConfigProblem>& problems) {
  std::string json = "[";
  for (std::size_t i = 0; i < std::min(problems.size(), ApplyRequest::kMostLines); ++i)
    json +=
        fmt::format(R"({}{{"line":{},"what":{},"file":{}}})", i == 0 ? "" : ",", problems[i].line,
                    json_text(problems[i].what.substr(0, ApplyRequest::kMostLine_bytes)), json_text(problems[i].file));
  return json + "]";
}

/// As text, or null. \param path  may be a link, and then its file is meant
std::string text_json(const std::string& path) {
  try {
    return json_text(read_text_file(path, kMostLargeBody_bytes));
  } catch (const StartupError&) {
    return "null";
  }
}

}  // namespace

std::string ConfigurationDesk::file_json(bool has_token) const {
  std::string text, problem;
  try {
    text = read_text_file(config_path_, kMostLargeBody_bytes);
  } catch (const StartupError& error) {
    problem = error.what();
  }
  std::error_code unknown;
  const std::filesystem::path real = std::filesystem::canonical(config_path_, unknown);
  struct stat status {};
  const bool has_status = ::stat(config_path_.c_str(), &status) == 0;
  const auto age = std::chrono::system_clock::now() - std::chrono::system_clock::from_time_t(status.st_mtime);
  return fmt::format(
      R"({{"path":{},"text":{},"problem":{},"tag":"{}","changed_s":{},"before":{},"why_not":{},"apply":{}}})",
      json_text(config_path_), json_text(text), json_text(problem), tag_of(text),
      has_status ? std::chrono::duration_cast<std::chrono::seconds>(age).count() : 0,
      text_json(real.string() + ".before"), json_text(request_.why_not(has_token)), request_.json());
}

std::string ConfigurationDesk::check_json(std::string_view text) const {
  const ConfigVerdict verdict = check_text(text, config_path_);
  return fmt::format(R"({{"problems":{},"notes":{},"count":{}}})", problems_json(verdict.problems),
                     problems_json(verdict.notes), verdict.problems.size());
}

DeskReply ConfigurationDesk::apply(std::string_view text, std::string_view tag, bool has_token) {
  if (const std::string reason = request_.why_not(has_token); !reason.empty()) return {403, reason + "\n"};
  try {
    if (tag_of(read_text_file(config_path_, kMostLargeBody_bytes)) != tag)
      return {412, "the file has been changed since this page read it: load it again\n"};
  } catch (const StartupError& error) {
    return {409, std::string(error.what()) + "\n"};
  }
  return request_.begin("apply", std::string(text), has_token);
}

std::string configuration_keys_json() {
  std::string tables, keys, table = "\n";
  for (const ConfigKey& key : config_keys()) {
    if (key.table != table) {
      table = key.table;
      tables += fmt::format(R"({}{{"name":{},"list":{},"meaning":{}}})", tables.empty() ? "" : ",", json_text(table),
                            is_config_list(table), json_text(config_table_meaning(table)));
    }
    keys += fmt::format(R"({}{{"table":{},"name":{},"unit":{},"range":{},"default":{},"meaning":{}}})",
                        keys.empty() ? "" : ",", json_text(key.table), json_text(key.name), json_text(key.unit),
                        json_text(config_key_range(key)), json_text(config_key_default(key)), json_text(key.meaning));
  }
  return fmt::format(R"({{"tables":[{}],"keys":[{}]}})", tables, keys);
}

}  // namespace ninedot
