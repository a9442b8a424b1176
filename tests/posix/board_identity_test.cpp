#include "drivers/posix/board_identity.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace ninedot {
namespace {

/// A sysfs of the test's own.
class BoardIdentityTest : public testing::Test {
 protected:
  ~BoardIdentityTest() override { std::filesystem::remove_all(sys_); }

  void write(const std::string& path, std::string_view text) const {
    const std::filesystem::path file = sys_ + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
  }
  const std::string sys_ = testing::TempDir() + "board_identity_" + std::to_string(::getpid());
};

using namespace std::string_view_literals;

TEST_F(BoardIdentityTest, ComesFromTheDeviceTreeWithoutTheZeroThatEndsIt) {
  write("/firmware/devicetree/base/model", "Raspberry Pi 4 Model B Rev 1.5\0"sv);
  write("/firmware/devicetree/base/serial-number", "10000000a1b2c3d4\0"sv);
  const BoardIdentity board = read_board_identity(sys_);
  EXPECT_EQ(board.model, "Raspberry Pi 4 Model B Rev 1.5");
  EXPECT_EQ(board.serial, "10000000a1b2c3d4");
}

TEST_F(BoardIdentityTest, ComesFromDmiWhereThereIsNoDeviceTree) {
  write("/class/dmi/id/product_name", "Box 3000\n");
  write("/class/dmi/id/product_serial", " SN-0042 \n");
  const BoardIdentity board = read_board_identity(sys_);
  EXPECT_EQ(board.model, "Box 3000");
  EXPECT_EQ(board.serial, "SN-0042");
}

TEST_F(BoardIdentityTest, WordsThatStandForNoNumberAreNone) {
  for (const char* const words :
       {"To be filled by O.E.M.\n", "Default string\n", "None\n", "0000000000000000\n", "\n"}) {
    write("/class/dmi/id/product_serial", words);
    EXPECT_EQ(read_board_identity(sys_).serial, "") << words;
  }
  write("/class/dmi/id/board_serial", "B-7\n");
  EXPECT_EQ(read_board_identity(sys_).serial, "B-7");
}

TEST_F(BoardIdentityTest, KeepsPrintableCharactersOfTheFirstLineAlone) {
  write("/firmware/devicetree/base/serial-number",
        "ab\x01\xC3\xA4"
        "cd\nef");
  EXPECT_EQ(read_board_identity(sys_).serial, "abcd");
  EXPECT_EQ(read_board_identity(sys_).model, "");
}

}  // namespace
}  // namespace ninedot
