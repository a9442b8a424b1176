#include "drivers/posix/output_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/startup_error.h"

namespace ninedot {
namespace {

bool is_special(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

}  // namespace

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path.empty() || path == "-") {
    path_ = "standard output";
    file_ = stdout;
    return;
  }
  if (!is_special(path)) temporary_path_ = path + ".tmp";
  file_ = std::fopen(temporary_path_.empty() ? path.c_str() : temporary_path_.c_str(), "we");
  if (file_ == nullptr) {
    temporary_path_.clear();
    fail("cannot be written");
  }
}

OutputFile::~OutputFile() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  if (!temporary_path_.empty()) unlink(temporary_path_.c_str());
}

void OutputFile::fail(const char* what) const {
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{} {}: {}", path_, what, std::strerror(errno)));
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail("cannot be written");
}

void OutputFile::finish() {
  if (std::fflush(file_) != 0) fail("cannot be written");
  if (file_ == stdout) return;
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail("cannot be written");
  if (temporary_path_.empty()) return;
  if (std::rename(temporary_path_.c_str(), path_.c_str()) != 0) fail("cannot be replaced");
  temporary_path_.clear();
}

}  // namespace ninedot
