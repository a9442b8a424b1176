#include "programs/web/tar_stream.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "programs/web/tap_recording.h"
#include "tests/web/recording_frames.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

std::string made_in(const MemoryFolder& folder, int frames) {
  const std::string made = folder.path() + "/20261123-121415-asked";
  MadeUpService service;
  TapRecording recording(made, *service.next().header);
  for (int i = 0; i < frames; ++i) EXPECT_TRUE(recording.add(service.next().copy));
  recording.end("stopped by hand");
  return made;
}

/// \param piece  bytes that are asked for at a time
std::string archive_of(TarStream& stream, std::size_t piece, ssize_t& last) {
  std::string archive;
  std::vector<char> room(piece);
  while ((last = stream.read(room)) > 0) archive.append(room.data(), static_cast<std::size_t>(last));
  return archive;
}

TEST(TarStream, IsReadByTarItself) {
  const MemoryFolder folder;
  const std::string made = made_in(folder, 5);
  ssize_t last = 0;
  TarStream stream(made, "20261123-121415-asked");
  std::ofstream(folder.path() + "/a.tar", std::ios::binary) << archive_of(stream, 65536, last);
  EXPECT_EQ(last, 0);
  fs::create_directory(folder.path() + "/out");
  const std::string unpack = "tar -xf " + folder.path() + "/a.tar -C " + folder.path() + "/out";
  ASSERT_EQ(std::system(unpack.c_str()), 0);  // NOLINT(cert-env33-c): a path of ours
  const std::string compare = "diff -r " + made + " " + folder.path() + "/out/20261123-121415-asked";
  EXPECT_EQ(std::system(compare.c_str()), 0);  // NOLINT(cert-env33-c)
}

TEST(TarStream, IsTheSameHoweverItIsAskedFor) {
  const MemoryFolder folder;
  const std::string made = made_in(folder, 3);
  ssize_t last = 0;
  TarStream whole(made, "x");
  const std::string archive = archive_of(whole, std::size_t{1} << 20U, last);
  EXPECT_EQ(archive.size() % 512, 0U);
  for (const std::size_t piece : {1U, 7U, 512U, 1000U}) {
    TarStream stream(made, "x");
    EXPECT_EQ(archive_of(stream, piece, last), archive) << piece;
  }
}

TEST(TarStream, BreaksOffWhereTheRecordingGoes) {
  const MemoryFolder folder;
  const std::string made = made_in(folder, 5);
  TarStream stream(made, "x");
  std::vector<char> room(3000);
  ASSERT_GT(stream.read(room), 0);
  fs::remove_all(made);
  ssize_t last = 0;
  archive_of(stream, 4096, last);
  EXPECT_EQ(last, -1) << "or half of it would be taken for all";
  TarStream none(made, "x");
  EXPECT_EQ(none.read(room), -1);
}

}  // namespace
}  // namespace ninedot
