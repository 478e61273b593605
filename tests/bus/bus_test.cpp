// SPDX-License-Identifier: Apache-2.0
#include "lodestar/bus/bus.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "lodestar/bus/channels.h"

namespace lodestar::bus {
namespace {

constexpr const char* kInProcess = "memq://";  // LCM's own bus within one process

class Record : public Receiver {
 public:
  void receive(samples::Channel channel, const void* data, std::size_t size) override {
    channels.push_back(channel);
    payloads.emplace_back(static_cast<const char*>(data), size);
    if (throws) throw std::runtime_error("from the receiver");
  }
  std::vector<samples::Channel> channels;
  std::vector<std::string> payloads;
  bool throws = false;
};

bool readable(const Bus& bus) {
  pollfd descriptor{bus.descriptor(), POLLIN, 0};
  return poll(&descriptor, 1, 0) == 1;
}

void handle_all(Bus& bus) {
  while (readable(bus)) ASSERT_TRUE(bus.handle());
}

bool send(Bus& bus, const char* channel, const std::string& payload) {
  return bus.publish(channel, payload.data(), payload.size());
}

TEST(Bus, HandsOverTheInputChannelsInOrderAsRawBytes) {
  Record record;
  Bus bus(kInProcess, record);
  for (const char* input : kInputNames) ASSERT_TRUE(send(bus, input, input));
  handle_all(bus);
  ASSERT_EQ(record.channels.size(), kInputNames.size());
  for (std::size_t i = 0; i < kInputNames.size(); ++i) {
    EXPECT_EQ(name(record.channels[i]), std::string(kInputNames[i]));
    EXPECT_EQ(record.payloads[i], kInputNames[i]);
  }
}

TEST(Bus, NeverHearsTheTruthNorAnyOtherChannel) {
  Record record;
  Bus bus(kInProcess, record);
  for (const char* other : {"TRUTH", "SAHRS", "NAV", "HEALTH", "EFCSxRATES", "EFCS.RATES\n",
                            "xSMDU", "SMDU.CALIBRATION", "GPSxRAW", "GPS.RAW2", ".*", ""}) {
    send(bus, other, "must not arrive");
  }
  send(bus, "SMDU", "last");
  handle_all(bus);
  ASSERT_EQ(record.payloads.size(), 1u);
  EXPECT_EQ(record.payloads[0], "last");
}

TEST(Bus, LetsExceptionsOfTheReceiverThroughAndGoesOn) {
  Record record;
  Bus bus(kInProcess, record);
  record.throws = true;
  send(bus, "GPS", "a");
  EXPECT_THROW(bus.handle(), std::runtime_error);
  record.throws = false;
  send(bus, "GPS", "b");
  EXPECT_TRUE(bus.handle());
  EXPECT_EQ(record.payloads.size(), 2u);
}

TEST(Bus, SaysInOneLineWhatIsWrongWithTheUrl) {
  Record record;
  for (const std::string url : {"nonsense", "carrier-pigeon://coop", "udpm://300.1.2.3:7667"}) {
    try {
      Bus bus(url, record);
      FAIL() << url;
    } catch (const BusError& error) {
      EXPECT_NE(std::string(error.what()).find(url), std::string::npos);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace lodestar::bus
