#include "programs/web/live_json.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "base/json_text.h"

namespace ninedot {
namespace {

TEST(LiveJson, QuotesWhatALogOrAClientSays) {
  EXPECT_EQ(json_text("plain"), "\"plain\"");
  EXPECT_EQ(json_text("a \"b\" \\ \n\x01"), R"("a \"b\" \\ \u000a\u0001")");
}

TEST(LiveJson, SaysNullForWhatIsUnknown) {
  TapFrame frame;
  frame.rms_px = std::numeric_limits<double>::quiet_NaN();
  frame.distance_mm = std::numeric_limits<double>::infinity();
  const std::string json = frame_json(frame, MonoTime{});
  EXPECT_NE(json.find("\"rms_px\":null"), std::string::npos);
  EXPECT_NE(json.find("\"distance_mm\":null"), std::string::npos);
  EXPECT_NE(json.find("\"age_ms\":null"), std::string::npos) << "no pose yet";
  EXPECT_EQ(json.find("nan"), std::string::npos);
}

TEST(LiveJson, TellsTheNewestLinesOfTheLogInTheirOrder) {
  TapService service;
  for (service.log_count = 0; service.log_count < 30; ++service.log_count) {
    const std::string text = "line " + std::to_string(service.log_count);
    std::copy(text.begin(), text.end() + 1, service.log[service.log_count % kTapLogCount].text.begin());
  }
  const std::string json = service_json(service, MonoTime{});
  EXPECT_EQ(json.find("\"line 5\""), std::string::npos);
  EXPECT_LT(json.find("\"line 6\""), json.find("\"line 7\""));
  EXPECT_LT(json.find("\"line 28\""), json.find("\"line 29\""));
}

TEST(LiveJson, OfADamagedCountStaysWithinWhatThereIs) {
  TapFrame frame;
  frame.landmark_count = 4000000000;
  frame.landmarks[0].candidate_count = 4000000000;
  frame.search.has_failed = 1;
  frame.search.spot_count = 4000000000;
  frame.search.refusal = 4000000000;
  EXPECT_LT(frame_json(frame, MonoTime{}).size(), 40000U);
}

TEST(LiveJson, TellsWhyNothingWasFoundAndOnlyThen) {
  TapFrame frame;
  EXPECT_EQ(frame_json(frame, MonoTime{}).find("\"search\""), std::string::npos);
  frame.search.has_failed = 1;
  frame.search.refusal = 4;
  frame.search.spots_seen = 300;
  frame.search.spot_count = 3;
  frame.search.spots[0] = {100.25F, 50, 8, 4, 30};
  frame.search.spots[1].u_px = std::numeric_limits<float>::quiet_NaN();
  frame.search.spots[2] = {1, 2, 3, 4, 5};
  const std::string json = frame_json(frame, MonoTime{});
  EXPECT_NE(json.find(R"("refusal":4,"why":"it has no ninth dot in its middle")"), std::string::npos) << json;
  EXPECT_NE(json.find(R"("spots_seen":300,"spots":[[100.2,50.0,8.0,4.0,30.0],[1.0,2.0,3.0,4.0,5.0]])"),
            std::string::npos)
      << json;
  EXPECT_EQ(json.find("nan"), std::string::npos);
}

TEST(LiveJson, PutsTheLoneLandmarkAtTheWorldsOrigin) {
  EXPECT_EQ(map_json(Config{}), R"([{"id":0,"code":"","mm":[0,0,0],"heading_deg":0}])");
  Config config;
  config.landmarks.resize(2);
  config.landmarks[0].id = 7;
  config.landmarks[0].code = "KRGBKKRB";
  config.landmarks[0].position_mm = {1000, 2000, 1200};
  config.landmarks[0].heading_deg = 90;
  config.landmarks[1].id = 8;
  const std::string json = map_json(config);
  EXPECT_NE(json.find(R"("id":7,"code":"KRGBKKRB","mm":[1000,2000,1200],"heading_deg":90)"), std::string::npos) << json;
  EXPECT_EQ(json.find("\"id\":8"), std::string::npos) << "its place is unknown";
}

}  // namespace
}  // namespace ninedot
