// Format: POSIX.1-2017, pax, "ustar Interchange Format". Blocks of 512 bytes; two of zeros end the archive.
#include "programs/web/tar_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace ninedot {
namespace {

constexpr std::size_t kBlock_bytes = 512;
// Of each, where it is there; frames.csv tells the rest.
constexpr std::array<const char*, 4> kFixedFiles{"camera.yaml", "camera.json", "ended.txt", "frames.csv"};

struct TarHeader {
  std::array<char, 100> name;
  std::array<char, 8> mode, user, group;
  std::array<char, 12> size, changed;
  std::array<char, 8> checksum;
  char kind;
  std::array<char, 100> link;
  std::array<char, 8> magic;
  std::array<char, 247> rest;
};
static_assert(sizeof(TarHeader) == kBlock_bytes);

template <std::size_t N>
void put_octal(std::array<char, N>& field, std::uint64_t value) {
  const std::string text = fmt::format("{:0{}o}", value, N - 1);
  std::memcpy(field.data(), text.data(), N - 1);
}

}  // namespace

TarStream::TarStream(const std::string& folder, std::string name)
    : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW)), name_(std::move(name)) {
  FileDescriptor rows(::openat(folder_.get(), "frames.csv", O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (rows) rows_.reset(::fdopen(rows.let_go(), "r"));
  std::array<char, 256> header{};
  if (rows_ && std::fgets(header.data(), static_cast<int>(header.size()), rows_.get()) == nullptr) rows_.reset();
}

void TarStream::put_header(const std::string& file, std::uint64_t bytes, std::int64_t changed_s) {
  block_.fill('\0');
  TarHeader header{};
  const std::string name = name_ + "/" + file;
  std::memcpy(header.name.data(), name.data(), std::min(name.size(), header.name.size() - 1));
  put_octal(header.mode, 0644);
  put_octal(header.user, 0);
  put_octal(header.group, 0);
  put_octal(header.size, bytes);
  put_octal(header.changed, static_cast<std::uint64_t>(std::max<std::int64_t>(changed_s, 0)));
  header.kind = '0';
  header.magic = {'u', 's', 't', 'a', 'r', '\0', '0', '0'};
  header.checksum.fill(' ');
  std::memcpy(block_.data(), &header, sizeof header);
  unsigned sum = 0;
  for (std::size_t i = 0; i < kBlock_bytes; ++i) sum += static_cast<unsigned char>(block_[i]);
  const std::string text = fmt::format("{:06o}", sum);
  // Six digits, a zero, a blank: as tar itself has always written it.
  std::memcpy(header.checksum.data(), text.c_str(), text.size() + 1);
  std::memcpy(block_.data(), &header, sizeof header);
  block_from_ = 0;
  block_to_ = kBlock_bytes;
}

/// \return  false: it is not there
bool TarStream::open_file(const std::string& file) {
  file_ = FileDescriptor(::openat(folder_.get(), file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  struct stat status {};
  if (!file_ || ::fstat(file_.get(), &status) != 0) return false;
  file_bytes_left_ = static_cast<std::uint64_t>(status.st_size);
  padding_bytes_ = (kBlock_bytes - file_bytes_left_ % kBlock_bytes) % kBlock_bytes;
  put_header(file, file_bytes_left_, status.st_mtim.tv_sec);
  return true;
}

bool TarStream::next_number() {
  std::array<char, 256> row{};
  if (std::fgets(row.data(), static_cast<int>(row.size()), rows_.get()) == nullptr) return false;
  return std::from_chars(row.data(), row.data() + row.size(), number_).ec == std::errc();
}

TarStream::Next TarStream::next_file() {
  if (!rows_) return Next::kBroken;
  while (fixed_files_done_ < kFixedFiles.size())
    if (open_file(kFixedFiles[fixed_files_done_++])) return Next::kFile;
  for (;;) {
    if (report_is_next_) {
      report_is_next_ = false;
      // A picture may be without one: the disk was full, or the power went.
      if (open_file(fmt::format("reports/{:06}.json", number_))) return Next::kFile;
    }
    if (!next_number()) return Next::kEnd;
    report_is_next_ = true;
    return open_file(fmt::format("frames/{:06}.png", number_)) ? Next::kFile : Next::kBroken;
  }
}

ssize_t TarStream::read(std::span<char> to) {
  std::size_t done = 0;
  while (done < to.size()) {
    if (block_from_ < block_to_) {
      const std::size_t count = std::min(block_to_ - block_from_, to.size() - done);
      std::memcpy(to.data() + done, block_.data() + block_from_, count);
      block_from_ += count;
      done += count;
    } else if (file_bytes_left_ > 0) {
      const std::size_t wanted = std::min<std::uint64_t>(file_bytes_left_, to.size() - done);
      const ssize_t count = ::read(file_.get(), to.data() + done, wanted);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return -1;
      file_bytes_left_ -= static_cast<std::uint64_t>(count);
      done += static_cast<std::size_t>(count);
    } else if (padding_bytes_ > 0) {
      block_.fill('\0');
      block_from_ = 0;
      block_to_ = std::exchange(padding_bytes_, 0);
    } else if (is_over_) {
      break;
    } else if (const Next next = next_file(); next == Next::kBroken) {
      return -1;
    } else if (next == Next::kEnd) {
      is_over_ = true;
      block_.fill('\0');
      block_from_ = 0;
      block_to_ = 2 * kBlock_bytes;
    }
  }
  return static_cast<ssize_t>(done);
}

}  // namespace ninedot
