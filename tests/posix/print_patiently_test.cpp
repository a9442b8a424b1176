#include "drivers/posix/print_patiently.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

#include "base/mono_time.h"
#include "drivers/posix/file_descriptor.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    read = FileDescriptor(ends[0]), write = FileDescriptor(ends[1]);
    std::signal(SIGPIPE, SIG_IGN);
  }
  FileDescriptor read, write;
};

TEST(PrintPatiently, PrintsAllThatItsReaderHasRoomFor) {
  Pipe pipe;
  EXPECT_EQ(print_patiently(pipe.write.get(), "line\n", 0ns), Printed::kWhole);
  std::array<char, 16> text{};
  EXPECT_EQ(::read(pipe.read.get(), text.data(), text.size()), 5);
  EXPECT_STREQ(text.data(), "line\n");
}

TEST(PrintPatiently, LosesTheRestRatherThanWaitForAReaderWhoHasStopped) {
  Pipe pipe;
  const std::string much(1 << 20, 'x');  // a pipe holds a sixteenth of that
  const MonoTime before = mono_now();
  EXPECT_EQ(print_patiently(pipe.write.get(), much, 50ms), Printed::kCutOff);
  EXPECT_GE(mono_now() - before, 50ms);
  EXPECT_LT(mono_now() - before, 5s);
  EXPECT_EQ(print_patiently(pipe.write.get(), "more", 0ns), Printed::kCutOff);
}

TEST(PrintPatiently, SaysThatNobodyWillRead) {
  Pipe pipe;
  pipe.read = FileDescriptor();
  EXPECT_EQ(print_patiently(pipe.write.get(), "line\n", 1s), Printed::kBroken);
  const FileDescriptor full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
  EXPECT_EQ(print_patiently(full.get(), "line\n", 1s), Printed::kBroken);
  EXPECT_EQ(print_patiently(-1, "line\n", 10ms), Printed::kCutOff) << "poll() passes over what is no descriptor";
}

}  // namespace
}  // namespace ninedot
