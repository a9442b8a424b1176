#include "proto/register_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

const MonoTime kNow = mono_from_ns(5'000'000'000'000);
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Written by a script of its own (struct.pack in Python), not by the codec under test.
constexpr std::array<std::uint16_t, kRegisterCount> kPinned = {
    /*   0 */ 0x9D09, 0x0001, 0x1171, 0x01D0, 0x2EB3, 0x0000, 0x0007, 0x0391, 0x007B, 0x0058,
    /*  10 */ 0x09A5, 0xEC78, 0x1999, 0x012C, 0xFE70, 0x04B0, 0x0012, 0xD688, 0xFFD9, 0xDA60,
    /*  20 */ 0x0031, 0xFF9C, 0x0000, 0x4325, 0xFFFF, 0xA67A, 0x0001, 0x0C93, 0x000C, 0x0022,
    /*  30 */ 0x00D2, 0x001D, 0x0039, 0x0073, 0x007B, 0x002E, 0x0009, 0x04D2, 0xFDC9, 0x01D0,
    /*  40 */ 0x449A, 0x522B, 0xC51C, 0x4000, 0x454C, 0xCB33, 0x3F4B, 0xCC26, 0x3E0F, 0x029D,
    /*  50 */ 0xBE3E, 0xAE26, 0x3F0F, 0x029D, 0xFFFB, 0x1824, 0x003D, 0x09FA, 0x0000, 0x4268,
    /*  60 */ 0x015E, 0x0001, 0x86A0, 0x0001, 0x0001, 0x0000, 0x0003, 0x0002, 0x0057, 0x005F,
    /*  70 */ 0x0078, 0x014D, 0x01D9, 0x0000, 0x0E4D, 0x0000, 0x0005, 0x0002, 0x000F, 0x0004,
    /*  80 */ 0xFFFF, 0xFFFF, 0x1234, 0x5678, 0x47F1, 0x2000, 0x0007, 0x0015, 0x0001, 0x0006,
    /*  90 */ 0x0000, 0x000B, 0x0000, 0x000C, 0x0000, 0x000D, 0x0000, 0x000E, 0x000F, 0x0010,
    /* 100 */ 0x0002, 0x0011, 0x0010, 0x0001, 0x0001, 0x1194, 0xFC18, 0x01F4, 0x0000, 0x0011,
    /* 110 */ 0x0000, 0x0012, 0x0000, 0x0013, 0x0000, 0x0014, 0x0000, 0x0015, 0xFED4, 0x0190,
    /* 120 */ 0x04B0, 0x0078, 0x0003, 0x0001, 0x000C, 0x0002, 0x0002, 0x0001, 0xE241, 0xFFFF,
    /* 130 */ 0x4F3E, 0xFFFD, 0x40E0, 0x007B, 0x002E, 0xFFFF, 0x303A, 0xEE53, 0xB9B0, 0x42F6,
    /* 140 */ 0xE9D5, 0xC235, 0x0000, 0xC333, 0xFFE6, 0x01D0, 0x0004, 0x0096, 0x0001, 0x0014,
    /* 150 */ 0x012C, 0x3130, 0x3030, 0x3030, 0x3030, 0x6131, 0x6232, 0x6333, 0x6400, 0x04A9,
    /* 160 */ 0x01E5, 0x00AC, 0x0D00, 0x003E, 0x0002, 0x0015, 0x0016,
};

RegisterBlock encode_known(const RegisterCodecOptions& options = {}) {
  return encode_registers(test::known_report(kNow), test::known_metrics(), test::known_server_state(kNow), options);
}

/// A generator seeded by the running test's name, so that each law has its own, repeatable numbers.
std::mt19937_64 generator_of_this_test() {
  const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::seed_seq seed(name.begin(), name.end());
  return std::mt19937_64(seed);
}

double encode_then_decode(const RegisterEntry& entry, double value, const RegisterCodecOptions& options) {
  std::array<std::uint16_t, 2> words{};
  const std::span<std::uint16_t> used = std::span(words).first(entry.words());
  encode_value(entry, value, options, used);
  return decode_value(entry, used, options);
}

double step_of(const RegisterEntry& entry, const RegisterCodecOptions& options) {
  return entry.scale_is_configured ? options.position_step_mm : entry.scale;
}

TEST(RegisterCodec, EveryRegisterOfTheKnownReportIsPinned) {
  const RegisterBlock block = encode_known();
  for (std::size_t address = 0; address < block.size(); ++address)
    EXPECT_EQ(block[address], kPinned[address]) << "register " << address;
}

TEST(RegisterCodec, EncodeThenDecodeIsWithinHalfAStepForEveryRegister) {
  std::mt19937_64 random = generator_of_this_test();
  for (const double position_step_mm : {0.01, 0.5, 100.0}) {
    RegisterCodecOptions options;
    options.position_step_mm = position_step_mm;
    for (const RegisterEntry& entry : kRegisterMap) {
      if (entry.type == RegisterType::kF32) continue;
      const double step = step_of(entry, options);
      std::uniform_real_distribution<double> values(static_cast<double>(entry.lowest) * step,
                                                    static_cast<double>(entry.highest) * step);
      for (int i = 0; i < 1000; ++i) {
        const double value = values(random);
        // The margin is the rounding of the doubles themselves, far below a step.
        EXPECT_LE(std::abs(encode_then_decode(entry, value, options) - value), step / 2 * (1 + 1e-6)) << entry.name;
      }
    }
  }
}

TEST(RegisterCodec, FloatsComeBackAsTheNearestFloatInBothWordOrders) {
  std::mt19937_64 random = generator_of_this_test();
  std::uniform_real_distribution<double> values(-1e6, 1e6);
  const RegisterEntry& entry = *find_register(reg::kXFloat);
  for (const WordOrder order : {WordOrder::kHighFirst, WordOrder::kLowFirst}) {
    RegisterCodecOptions options;
    options.float_word_order = order;
    for (int i = 0; i < 1000; ++i) {
      const double value = values(random);
      EXPECT_EQ(encode_then_decode(entry, value, options), static_cast<double>(static_cast<float>(value)));
    }
  }
}

TEST(RegisterCodec, IntegersSaturateAtBothEndsAndNeverWrap) {
  const RegisterCodecOptions options;
  for (const RegisterEntry& entry : kRegisterMap) {
    if (entry.type == RegisterType::kF32) continue;
    const double step = step_of(entry, options);
    const double top = static_cast<double>(entry.highest) * step, bottom = static_cast<double>(entry.lowest) * step;
    for (const double beyond : {step, 70000 * step, 1e18, 1e300, kInfinity}) {
      EXPECT_EQ(encode_then_decode(entry, top + beyond, options), top) << entry.name;
      EXPECT_EQ(encode_then_decode(entry, bottom - beyond, options), bottom) << entry.name;
    }
  }
}

TEST(RegisterCodec, FloatsSaturateAtTheLargestFiniteFloat) {
  const RegisterEntry& entry = *find_register(reg::kXFloat);
  const double top = static_cast<double>(std::numeric_limits<float>::max());
  for (const double huge : {1e39, 1e300, kInfinity}) {
    EXPECT_EQ(encode_then_decode(entry, huge, {}), top);
    EXPECT_EQ(encode_then_decode(entry, -huge, {}), -top);
  }
}

TEST(RegisterCodec, NotANumberBecomesTheValueForUnknown) {
  for (const RegisterEntry& entry : kRegisterMap) {
    const double decoded = encode_then_decode(entry, kNaN, {});
    const bool has_nan =
        entry.type == RegisterType::kF32 || entry.type == RegisterType::kI16 || entry.type == RegisterType::kI32;
    if (has_nan)
      EXPECT_TRUE(std::isnan(decoded)) << entry.name;
    else
      EXPECT_EQ(decoded, static_cast<double>(entry.highest) * entry.scale) << entry.name;
  }
  std::array<std::uint16_t, 2> words{};
  encode_value(*find_register(reg::kX16), kNaN, {}, std::span(words).first(1));
  EXPECT_EQ(words[0], 0x8000);
  encode_value(*find_register(reg::kX32), kNaN, {}, words);
  EXPECT_EQ(words, (std::array<std::uint16_t, 2>{0x8000, 0x0000}));
  encode_value(*find_register(reg::kXFloat), -kNaN, {}, words);
  EXPECT_EQ(words, (std::array<std::uint16_t, 2>{0x7FC0, 0x0000}));
}

TEST(RegisterCodec, RoundsToTheNearestStep) {
  const RegisterEntry& pan = *find_register(reg::kPan);
  EXPECT_EQ(encode_then_decode(pan, 0.0149, {}), 0.01);
  EXPECT_EQ(encode_then_decode(pan, 0.0151, {}), 0.02);
  EXPECT_EQ(encode_then_decode(pan, -0.0149, {}), -0.01);
  EXPECT_EQ(encode_then_decode(pan, -0.0151, {}), -0.02);
}

TEST(RegisterCodec, LowWordFirstSwapsFloatsAndNothingElse) {
  RegisterCodecOptions options;
  options.float_word_order = WordOrder::kLowFirst;
  const RegisterBlock high_first = encode_known(), low_first = encode_known(options);
  for (const RegisterEntry& entry : kRegisterMap) {
    const std::size_t a = entry.address;
    if (entry.type == RegisterType::kF32) {
      EXPECT_EQ(low_first[a], high_first[a + 1]) << entry.name;
      EXPECT_EQ(low_first[a + 1], high_first[a]) << entry.name;
    } else {
      EXPECT_EQ(low_first[a], high_first[a]) << entry.name;
    }
  }
}

TEST(RegisterCodec, ReaderGivesBackTheReportsNumbers) {
  const RegisterBlock block = encode_known();
  const RegisterReader reader(block);
  EXPECT_TRUE(reader.is_ninedot());
  EXPECT_TRUE(reader.is_of_one_frame());
  EXPECT_TRUE(reader.status(status_bit::kValid));
  EXPECT_FALSE(reader.status(status_bit::kAmbiguous));
  EXPECT_NEAR(reader.value(reg::kX32), 1234.5678, 0.0005);
  EXPECT_NEAR(reader.value(reg::kRotationX32), 0.3 * 180 / std::numbers::pi, 0.0005);
  EXPECT_NEAR(reader.value(reg::kQwFloat), std::cos(0.65), 1e-7);
  EXPECT_NEAR(reader.value(reg::kAge), 12.34, 0.05);
  EXPECT_EQ(reader.integer(reg::kFramesDropped), 65537U);
  EXPECT_NEAR(reader.value(reg::kRivalX32), -321.5, 0.0005);
  EXPECT_NEAR(reader.value(reg::kRivalX32 + 2), 4000.25, 0.0005);
  EXPECT_EQ(reader.value(reg::kRivalRotationX16), -300);
  EXPECT_EQ(reader.value(reg::kRivalRotationX16 + 2), 1200);
  EXPECT_NEAR(reader.value(reg::kRivalOdds), 0.12, 1e-9);
}

TEST(RegisterCodec, WhereThereIsNoOtherReadingItsPoseIsUnknownAndItsOddsAreZero) {
  WireReport report = test::known_report(kNow);
  report.rival_odds = 0;
  report.rival = {};
  const RegisterBlock block = encode_registers(report, {}, test::known_server_state(kNow), {});
  for (std::uint16_t i = 0; i < 6; ++i) EXPECT_EQ(block[reg::kRivalX32 + i], i % 2 == 0 ? 0x8000 : 0) << i;
  for (std::uint16_t i = 0; i < 3; ++i) EXPECT_EQ(block[reg::kRivalRotationX16 + i], 0x8000) << i;
  EXPECT_EQ(block[reg::kRivalOdds], 0);
}

TEST(RegisterCodec, TheAgeGrowsWithTheMomentOfTheReplyAndSaturates) {
  WireReport report = test::known_report(kNow);
  ServerState server = test::known_server_state(kNow);
  const auto age_at = [&](std::chrono::nanoseconds later) {
    server.now = kNow + later;
    return encode_registers(report, {}, server, {})[reg::kAge];
  };
  EXPECT_EQ(age_at(std::chrono::milliseconds(0)), 123);
  EXPECT_EQ(age_at(std::chrono::milliseconds(100)), 1123);
  EXPECT_EQ(age_at(std::chrono::hours(10000)), 0xFFFF);
  EXPECT_EQ(age_at(std::chrono::milliseconds(-50)), 0) << "a report from the future is new, not ancient";
}

TEST(RegisterCodec, AValidReportThatGrowsOldIsStaleAndNoLongerValid) {
  ServerState server = test::known_server_state(kNow);
  server.commands.hold = false;
  server.now += std::chrono::milliseconds(600);
  const RegisterBlock block = encode_registers(test::known_report(kNow), {}, server, {});
  const RegisterReader reader(block);
  EXPECT_FALSE(reader.status(status_bit::kValid));
  EXPECT_TRUE(reader.status(status_bit::kStale));
  EXPECT_EQ(reader.integer(reg::kReason), static_cast<std::uint32_t>(Reason::kStale));
  EXPECT_EQ(reader.integer(reg::kQuality), 0U);
  EXPECT_EQ(reader.value(reg::kX32), encode_then_decode(*find_register(reg::kX32), 1234.5678, {}))
      << "the last pose stays";
}

TEST(RegisterCodec, AHeldReportThatGrowsOldIsNoMissingFrame) {
  ServerState server = test::known_server_state(kNow);
  server.now += std::chrono::milliseconds(600);
  server.commands.hold = true;
  const auto reason = [&](const WireReport& report) { return encode_registers(report, {}, server, {})[reg::kReason]; };
  WireReport report = test::known_report(kNow);
  EXPECT_EQ(reason(report), static_cast<std::uint16_t>(Reason::kHeld));
  report.valid = false;
  report.reason = Reason::kNoLandmark;
  EXPECT_EQ(reason(report), static_cast<std::uint16_t>(Reason::kNoLandmark)) << "it was not valid in the first place";
}

TEST(RegisterCodec, AnInvalidReportKeepsItsOwnReason) {
  WireReport report = test::known_report(kNow);
  report.valid = report.found = false;
  report.reason = Reason::kNoLandmark;
  const RegisterBlock block = encode_registers(report, {}, test::known_server_state(kNow), {});
  const RegisterReader reader(block);
  EXPECT_FALSE(reader.status(status_bit::kValid));
  EXPECT_FALSE(reader.status(status_bit::kFound));
  EXPECT_EQ(reader.integer(reg::kReason), static_cast<std::uint32_t>(Reason::kNoLandmark));
}

TEST(RegisterCodec, BeforeTheFirstPoseEveryNumberOfAPoseIsUnknown) {
  ServerState server;
  server.now = kNow;
  const RegisterBlock block = encode_registers(WireReport{}, MetricValues{}, server, {});
  for (const std::uint16_t first : std::array<std::uint16_t, 2>{reg::kX16, reg::kRotationX16})
    for (std::uint16_t i = 0; i < 3; ++i) EXPECT_EQ(block[first + i], 0x8000) << first + i;
  for (const std::uint16_t first : std::array<std::uint16_t, 2>{reg::kX32, reg::kRotationX32})
    for (std::uint16_t i = 0; i < 6; ++i) EXPECT_EQ(block[first + i], i % 2 == 0 ? 0x8000 : 0) << first + i;
  const RegisterReader reader(block);
  for (std::uint16_t i = 0; i < 14; i += 2)
    EXPECT_TRUE(std::isnan(reader.value(static_cast<std::uint16_t>(reg::kXFloat + i)))) << i;
  EXPECT_EQ(block[reg::kLandmarkId], kNoLandmarkYet);
  EXPECT_EQ(block[reg::kAmbiguity], 1000) << "the end of its range";
  EXPECT_EQ(block[reg::kResidual], 0xFFFF);
  EXPECT_EQ(block[reg::kLatency], 0xFFFF);
  EXPECT_EQ(block[reg::kQuality], 0);
  EXPECT_EQ(block[reg::kDotsUsed], 0) << "known: it rests on none";
}

TEST(RegisterCodec, BeforeTheFirstPoseNothingLooksFresh) {
  ServerState server;
  server.now = kNow;
  const RegisterBlock block = encode_registers(WireReport{}, MetricValues{}, server, {});
  const RegisterReader reader(block);
  EXPECT_FALSE(reader.status(status_bit::kValid));
  EXPECT_TRUE(reader.status(status_bit::kStale));
  EXPECT_EQ(block[reg::kAge], 0xFFFF);
  for (std::uint16_t i = 0; i < 6; ++i) EXPECT_EQ(block[reg::kSigmaX + i], 0xFFFF);
  EXPECT_EQ(block[reg::kReason], static_cast<std::uint16_t>(Reason::kStarting));
}

TEST(RegisterCodec, ASmallSigmaNeverReadsAsCertainty) {
  WireReport report = test::known_report(kNow);
  report.sigma_mm = report.sigma_deg = {1e-9, 1e-9, 1e-9};
  const RegisterBlock block = encode_registers(report, {}, test::known_server_state(kNow), {});
  for (std::uint16_t i = 0; i < 6; ++i) EXPECT_EQ(block[reg::kSigmaX + i], 1);
}

TEST(RegisterCodec, TheRotationVectorHasTheQuaternionsAxisAndAngle) {
  std::mt19937_64 random = generator_of_this_test();
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> angles_rad(0, std::numbers::pi);
  WireReport report = test::known_report(kNow);
  for (int i = 0; i < 1000; ++i) {
    const double x = normal(random), y = normal(random), z = normal(random), norm = std::sqrt(x * x + y * y + z * z);
    const double angle_rad = i == 0 ? 0 : i == 1 ? std::numbers::pi : angles_rad(random);
    const double s = std::sin(angle_rad / 2) / norm;
    report.pose.quaternion_wxyz = {std::cos(angle_rad / 2), x * s, y * s, z * s};
    const RegisterBlock block = encode_registers(report, {}, test::known_server_state(kNow), {});
    const RegisterReader reader(block);
    const double angle_deg = angle_rad * 180 / std::numbers::pi;
    EXPECT_NEAR(reader.value(reg::kRotationX32), x / norm * angle_deg, 0.00051);
    EXPECT_NEAR(reader.value(reg::kRotationX32 + 2), y / norm * angle_deg, 0.00051);
    EXPECT_NEAR(reader.value(reg::kRotationX32 + 4), z / norm * angle_deg, 0.00051);
    EXPECT_NEAR(reader.value(reg::kRotationX16), x / norm * angle_rad * 1000, 0.51);
  }
}

TEST(RegisterCodec, CountersWrapAndStayEqualToTheirCopy) {
  WireReport report = test::known_report(kNow);
  for (const std::uint32_t sequence : {65535U, 65536U, 4294967295U}) {
    report.pose_sequence = sequence;
    const RegisterBlock block = encode_registers(report, {}, test::known_server_state(kNow), {});
    EXPECT_EQ(block[reg::kPoseSequence], sequence & 0xFFFFU);
    EXPECT_EQ(block[reg::kPoseSequenceCopy], sequence & 0xFFFFU);
  }
}

}  // namespace
}  // namespace ninedot
