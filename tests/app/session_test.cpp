// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/session.h"

#include <gtest/gtest.h>

#include <lodestar/attitude_t.hpp>
#include <lodestar/health_t.hpp>
#include <lodestar/navigation_t.hpp>
#include <string>
#include <vector>

#include "level_flight.h"

namespace lodestar::app {
namespace {

struct Record : Sink {
  void send(const char* channel, const bus::Message& message) override {
    channels.emplace_back(channel);
    last = message;
  }
  void complete(samples::Health& health) override { health.log_dropped = 5; }
  std::vector<std::string> channels;
  bus::Message last;
};

class SessionTest : public testing::Test {
 protected:
  const navigator::Outputs* receive(const Sent& message) {
    return session_.receive(message.channel, message.bytes.data(), message.bytes.size());
  }
  health_t health() {
    session_.send_health();
    health_t wire{};
    EXPECT_GT(wire.decode(record_.last.bytes.data(), 0, static_cast<int>(record_.last.size)), 0);
    return wire;
  }
  Record record_;
  Session session_{navigator::Config{}, record_};
};

TEST_F(SessionTest, AnswersEachBodyRateWithAttitudeThenNavigationAndNowAndThenMonitorAndHealth) {
  int frames = 0;
  for (const Sent& message : level_flight(3)) {
    record_.channels.clear();
    const auto* outputs = receive(message);
    if (message.channel != samples::Channel::kBodyRates) {
      EXPECT_EQ(outputs, nullptr);
      EXPECT_TRUE(record_.channels.empty());
      continue;
    }
    ASSERT_NE(outputs, nullptr);
    EXPECT_EQ(outputs->sahrs.time_us, message.time_us);
    EXPECT_EQ(outputs->nav.time_us, message.time_us);
    std::vector<std::string> expected = {"SAHRS", "NAV"};
    if (frames % 6 == 0) expected.push_back("INS.MONITOR");
    if (frames % 60 == 0) expected.insert(expected.end(), {"SMDU.CALIBRATION", "HEALTH"});
    EXPECT_EQ(record_.channels, expected) << frames;
    ++frames;
  }
  EXPECT_EQ(frames, 180);
}

TEST_F(SessionTest, SendsHealthBeforeAnyFrameWithVersionAndWhatTheShellAdds) {
  const health_t wire = health();
  EXPECT_EQ(record_.channels, std::vector<std::string>{"HEALTH"});
  EXPECT_EQ(wire.time_us, 0);
  EXPECT_EQ(wire.log_dropped, 5);
  EXPECT_GT(wire.build_version[0], '\0');
}

TEST_F(SessionTest, CountsWhatTheCodecRefusesByChannelAndReason) {
  const auto rates = sent(samples::Channel::kBodyRates, body_rates_t{1'000'000, {0, 0, 0}, 1});
  Sent damaged = rates;
  damaged.bytes.pop_back();
  EXPECT_EQ(receive(damaged), nullptr);
  damaged = rates;
  damaged.bytes[0] ^= 0x40;
  EXPECT_EQ(receive(damaged), nullptr);
  receive({samples::Channel::kBodyRates, 0, {}});
  receive(sent(samples::Channel::kGps, air_data_t{}));
  EXPECT_EQ(receive(sent(samples::Channel::kBodyRates, body_rates_t{1'000'000, {0, 0, 0}, 2})),
            nullptr);
  EXPECT_TRUE(record_.channels.empty());
  const health_t wire = health();
  EXPECT_EQ(wire.received[0], 4);
  EXPECT_EQ(wire.rejected[0][0], 2);  // size
  EXPECT_EQ(wire.rejected[0][1], 1);  // fingerprint
  EXPECT_EQ(wire.rejected[0][2], 1);  // decode
  EXPECT_EQ(wire.received[5], 1);
  EXPECT_EQ(wire.rejected[5][0], 1);
}

}  // namespace
}  // namespace lodestar::app
