#include "proto/register_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "base/reason.h"
#include "proto/register_document.h"

namespace ninedot {
namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(RegisterMap, TheAddressesThatControllersRelyOnStandWhereTheyAlwaysStood) {
  EXPECT_EQ(reg::kMagic, 0);
  EXPECT_EQ(reg::kHeartbeat, 2);
  EXPECT_EQ(reg::kPoseSequence, 3);
  EXPECT_EQ(reg::kStatus, 4);
  EXPECT_EQ(reg::kAge, 8);
  EXPECT_EQ(reg::kX16, 10);
  EXPECT_EQ(reg::kX32, 16);
  EXPECT_EQ(reg::kSigmaX, 28);
  EXPECT_EQ(reg::kAmbiguity, 34);
  EXPECT_EQ(reg::kPan, 37);
  EXPECT_EQ(reg::kPoseSequenceCopy, 39);
  EXPECT_EQ(reg::kXFloat, 40);
  EXPECT_EQ(reg::kRivalX32, 54);
  EXPECT_EQ(reg::kFrameRate, 60);
  EXPECT_EQ(reg::kProbeInt32, 80);
  EXPECT_EQ(reg::kCommand, 100);
}

TEST(RegisterMap, NamesAreUnique) {
  std::set<std::string_view> names;
  for (const RegisterEntry& entry : kRegisterMap) EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
}

TEST(RegisterMap, EveryAddressHasAnEntryUpToTheEnd) {
  std::size_t next = 0;
  for (const RegisterEntry& entry : kRegisterMap) {
    EXPECT_EQ(entry.address, next) << entry.name;
    next = std::size_t{entry.address} + entry.words();
  }
  EXPECT_EQ(next, kRegisterCount);
}

TEST(RegisterMap, OneRequestReadsAllButTheAngles) { EXPECT_EQ(reg::kPoseContent, 125); }

TEST(RegisterMap, OnlyRegistersFrom100OnAreWritable) {
  for (const RegisterEntry& entry : kRegisterMap) {
    if (entry.access == RegisterAccess::kReadWrite) {
      EXPECT_GE(entry.address, 100) << entry.name;
    }
  }
}

TEST(RegisterMap, EveryReasonHasItsCodeInOrder) {
  ASSERT_EQ(kReasonCodes.size(), static_cast<std::size_t>(Reason::kZoom) + 1);
  for (std::size_t i = 0; i < kReasonCodes.size(); ++i) EXPECT_EQ(kReasonCodes[i].code, i);
}

TEST(RegisterMap, StatusBitsAreSingleAndDistinct) {
  unsigned seen = 0;
  for (const RegisterBit& bit : kStatusBits) {
    EXPECT_EQ(bit.mask & (bit.mask - 1), 0) << bit.name;
    EXPECT_EQ(seen & bit.mask, 0U) << bit.name;
    seen |= bit.mask;
  }
}

TEST(Metrics, EachHasARegisterOrAHealthBitOfItsName) {
  for (const Metric& metric : kMetrics) {
    if (metric.kind == MetricKind::kFlag) {
      const auto bit = std::ranges::find(kHealthBits, metric.name, &RegisterBit::name);
      ASSERT_NE(bit, kHealthBits.end()) << metric.name;
      EXPECT_EQ(bit->mask, metric.address);
      continue;
    }
    const RegisterEntry* entry = find_register(metric.address);
    ASSERT_NE(entry, nullptr) << metric.name;
    EXPECT_EQ(entry->name, metric.name);
  }
}

TEST(Metrics, StandWhereTheyAlwaysStood) {
  EXPECT_EQ(register_address("frames_processed"), 61);
  EXPECT_EQ(register_address("temperature"), 72);
  EXPECT_EQ(register_address("bus_errors"), 75);
  EXPECT_EQ(register_address("pulse_error_p99"), 86);
  EXPECT_EQ(register_address("requests"), 88);
  EXPECT_EQ(register_address("runs_cut"), 108);
  EXPECT_EQ(health_bit::kRealtime, 1);
  EXPECT_EQ(health_bit::kMemoryLocked, 2);
}

TEST(Reasons, AreTheDocumentsCodesInWords) {
  for (const RegisterCode& code : kReasonCodes) EXPECT_EQ(code.meaning, reason_sentence(code.code));
  EXPECT_NE(reason_sentence(4711U).find("newer"), std::string_view::npos);
}

TEST(RegisterDocument, DocsRegistersMdIsWhatTheTableSays) {
  EXPECT_EQ(read_file(NINEDOT_SOURCE_DIR "/docs/registers.md"), register_map_markdown())
      << "run: ninedot registers --format md > docs/registers.md";
}

TEST(RegisterDocument, CsvHasOneLinePerRegister) {
  const std::string csv = register_map_csv();
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), static_cast<std::ptrdiff_t>(kRegisterMap.size()) + 1);
  EXPECT_NE(csv.find("\n37,pan,1,int16,0.01,deg,-32767,32767,r,"), std::string::npos);
}

TEST(RegisterDocument, JsonNamesEveryRegister) {
  const std::string json = register_map_json();
  for (const RegisterEntry& entry : kRegisterMap)
    EXPECT_NE(json.find("\"name\": \"" + std::string(entry.name) + "\""), std::string::npos) << entry.name;
}

}  // namespace
}  // namespace ninedot
