#include "programs/service/device_identity.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

std::string serial_in_registers(const std::string& serial) {
  ServerState state;
  state.identity = device_identity({"", serial});
  const RegisterBlock block = encode_registers(WireReport{}, MetricValues{}, state, {});
  return RegisterReader(block).board_serial();
}

TEST(DeviceIdentity, TheSerialNumberGoesThroughTheRegistersAndBack) {
  for (const char* const serial : {"", "7", "SN-0042", "10000000a1b2c3d4"})
    EXPECT_EQ(serial_in_registers(serial), serial);
}

TEST(DeviceIdentity, OfALongSerialNumberTheEndCounts) {
  EXPECT_EQ(serial_in_registers("MAKER-10000000a1b2c3d4"), "10000000a1b2c3d4");
}

TEST(DeviceIdentity, WhatIsNoTextIsNoSerialNumber) {
  RegisterBlock block = encode_registers(WireReport{}, MetricValues{}, {}, {});
  block[reg::kBoardSerial] = 0x4101;
  EXPECT_EQ(RegisterReader(block).board_serial(), "");
  block[reg::kBoardSerial] = 0x4122;  // a quotation mark would break the JSON that it stands in
  EXPECT_EQ(RegisterReader(block).board_serial(), "");
}

}  // namespace
}  // namespace ninedot
