#include "drivers/posix/listening_program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A /proc with a socket 4711 that listens on 127.0.0.1:1502, 4712 on [::]:1503, and 4713, a client's on 1504.
class ListeningProgram : public testing::Test {
 protected:
  ListeningProgram() : proc_(fs::temp_directory_path() / fmt::format("ninedot_proc_{}", ::getpid())) {
    fs::create_directories(proc_ / "net");
    std::ofstream(proc_ / "net" / "tcp")
        << "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
           "   0: 0100007F:05DE 00000000:0000 0A 00000000:00000000 00:00000000 00000000  998        0 4711 1 0 100 0\n"
           "   1: 0100007F:05E0 0100007F:05DE 01 00000000:00000000 00:00000000 00000000  998        0 4713 1 0 20 4\n";
    std::ofstream(proc_ / "net" / "tcp6")
        << "  sl  local_address                         remote_address                        st tx_queue rx_queue\n"
           "   0: 00000000000000000000000000000000:05DF 00000000000000000000000000000000:0000 0A 00000000:00000000 "
           "00:00000000 00000000  998        0 4712 1 0 100 0\n";
  }
  ~ListeningProgram() override { fs::remove_all(proc_); }

  fs::path add_process(const char* id, const char* name) {
    fs::create_directories(proc_ / id);
    std::ofstream(proc_ / id / "comm") << name << "\n";
    return proc_ / id / "fd";
  }
  void add_process(const char* id, const char* name, const char* descriptor) {
    const fs::path descriptors = add_process(id, name);
    fs::create_directories(descriptors);
    fs::create_symlink("/dev/null", descriptors / "0");
    fs::create_symlink(descriptor, descriptors / "5");
  }
  Listening found(std::uint16_t port) { return find_listener("ninedotd", port, proc_.string()); }

  const fs::path proc_;
};

TEST_F(ListeningProgram, IsFoundByItsNameAndItsSocket) {
  add_process("12", "ninedotd", "socket:[4711]");
  add_process("13", "nginx", "socket:[4712]");
  EXPECT_EQ(found(1502), Listening::kYes);
  EXPECT_EQ(found(1503), Listening::kNo) << "another program's";
  add_process("14", "ninedotd", "socket:[4712]");
  EXPECT_EQ(found(1503), Listening::kYes) << "by IPv6";
}

TEST_F(ListeningProgram, IsNoneThatOnlyHasAConnectionThere) {
  add_process("12", "ninedotd", "socket:[4713]");
  EXPECT_EQ(found(1504), Listening::kNo);
}

TEST_F(ListeningProgram, MayBeOneWhoseDescriptorsAreHidden) {
  std::ofstream(add_process("12", "ninedotd")) << "root reads every directory, so this is none";
  EXPECT_EQ(found(1502), Listening::kMaybe);
  EXPECT_EQ(found(1600), Listening::kNo) << "nobody listens there";
  add_process("13", "ninedotd", "socket:[4711]");
  EXPECT_EQ(found(1502), Listening::kYes);
}

TEST_F(ListeningProgram, IsNoneThatHasEnded) {
  add_process("12", "ninedotd");
  EXPECT_EQ(found(1502), Listening::kNo);
}

}  // namespace
}  // namespace ninedot
