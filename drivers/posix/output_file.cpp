#include "drivers/posix/output_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <span>
#include <utility>

#include "base/startup_error.h"

namespace ninedot {
namespace {

/// What a pipe holds (pipe(7)): one system call for many rows.
constexpr std::size_t kPiece_bytes = std::size_t{64} * 1024;

}  // namespace

template <typename T>
T OutputFile::need(Result<T> result) const {
  if (!result)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{} {}: {}", path_, result.error().text, std::strerror(result.error().os_errno)));
  return *std::move(result);
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path.empty() || path == "-")
    path_ = "standard output";
  else
    file_.emplace(need(FileReplacement::begin(path)));
}

void OutputFile::write(std::string_view text) {
  pending_ += text;
  if (pending_.size() >= kPiece_bytes) flush();
}

void OutputFile::flush() {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(pending_.data()), pending_.size());
  need(file_ ? file_->write(bytes) : write_all(STDOUT_FILENO, bytes, write_to_disk));
  pending_.clear();
}

void OutputFile::settle() {
  flush();
  if (file_) need(file_->settle(Durability::kPowerCut));
}

void OutputFile::finish() {
  settle();
  if (file_) need(file_->commit(Durability::kPowerCut));
}

void finish_together(std::initializer_list<OutputFile*> files) {
  for (OutputFile* const file : files)
    if (file != nullptr) file->settle();
  for (OutputFile* const file : files)
    if (file != nullptr) file->finish();
}

}  // namespace ninedot
