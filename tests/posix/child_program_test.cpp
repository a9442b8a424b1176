#include "drivers/posix/child_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string>
#include <utility>

#include "drivers/posix/file_descriptor.h"

namespace ninedot {
namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    read = FileDescriptor(ends[0]), write = FileDescriptor(ends[1]);
  }
  std::string all() {
    write = FileDescriptor();
    std::string text;
    std::array<char, 256> part{};
    for (ssize_t count = 0; (count = ::read(read.get(), part.data(), part.size())) > 0;)
      text.append(part.data(), static_cast<std::size_t>(count));
    return text;
  }
  FileDescriptor read, write;
};

/// What a shell prints that runs `script`.
std::pair<std::string, int> printed_by(const std::string& script) {
  Pipe pipe;
  const Result<pid_t> child = start_program({"sh", "-c", script}, pipe.write.get(), -1);
  EXPECT_TRUE(child) << child.error().os_errno;
  std::string text = pipe.all();
  int status = 0;
  EXPECT_EQ(::waitpid(*child, &status, 0), *child);
  return {text, status};
}

TEST(ChildProgram, HasItsOutputHeardAndItsArgumentsWhole) {
  const auto [text, status] = printed_by("printf '%s' 'two words'; echo unheard >&2; exit 7");
  EXPECT_EQ(text, "two words");
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

TEST(ChildProgram, ReadsNothing) { EXPECT_EQ(printed_by("readlink /proc/self/fd/0").first, "/dev/null\n"); }

TEST(ChildProgram, HasOrdinarySignalsWhateverThisProcessBlocksOrIgnores) {
  sigset_t blocked, before;
  ::sigemptyset(&blocked);
  ::sigaddset(&blocked, SIGTERM);
  ASSERT_EQ(::pthread_sigmask(SIG_BLOCK, &blocked, &before), 0);
  const auto handler = std::signal(SIGINT, SIG_IGN);
  const int terminated = printed_by("kill -TERM $$; sleep 5").second;
  const int interrupted = printed_by("kill -INT $$; sleep 5").second;
  std::signal(SIGINT, handler);
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_TRUE(WIFSIGNALED(terminated) && WTERMSIG(terminated) == SIGTERM);
  EXPECT_TRUE(WIFSIGNALED(interrupted) && WTERMSIG(interrupted) == SIGINT);
}

TEST(ChildProgram, HasNoFileOfThisProcessOpen) {
  const FileDescriptor careless(::open("/dev/null", O_RDONLY));  // NOLINT(android-cloexec-open): that is the point
  const std::string script = fmt::format("[ -e /proc/self/fd/{} ] && echo open || echo closed", careless.get());
  EXPECT_EQ(printed_by(script).first, "closed\n");
}

TEST(ChildProgram, LeadsAGroupOfItsOwn) {
  const Result<pid_t> child = start_program({"sleep", "30"}, -1, -1);
  ASSERT_TRUE(child);
  EXPECT_EQ(::getpgid(*child), *child);
  EXPECT_EQ(::kill(-*child, SIGKILL), 0);
  EXPECT_EQ(::waitpid(*child, nullptr, 0), *child);
}

TEST(ChildProgram, OneThatIsNotThereIsSaid) {
  const Result<pid_t> child = start_program({"/nonexistent/program"}, -1, -1);
  ASSERT_FALSE(child);
  EXPECT_EQ(child.error().code, Errc::kIo);
  EXPECT_EQ(child.error().os_errno, ENOENT);
}

}  // namespace
}  // namespace ninedot
