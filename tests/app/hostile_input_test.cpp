// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <lodestar/attitude_t.hpp>
#include <lodestar/navigation_t.hpp>
#include <random>
#include <string>
#include <vector>

#include "level_flight.h"
#include "lodestar/app/session.h"
#include "lodestar/bus/channels.h"

// A fifth of all messages of a flight is damaged, lost, doubled or put on the wrong channel. Run
// under the sanitizers, this also proves that no such message reaches undefined behaviour.

namespace lodestar::app {
namespace {

bool all_finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Looks at what the session claims to be valid.
struct Judge : Sink {
  void send(const char* channel, const bus::Message& message) override {
    const int size = static_cast<int>(message.size);
    if (channel == std::string(bus::kSahrs)) {
      attitude_t m{};
      m.decode(message.bytes.data(), 0, size);
      check(m.valid, all_finite({m.roll, m.pitch, m.heading, m.sigma_B[0], m.gyro_bias_B[0]}));
    } else if (channel == std::string(bus::kNav)) {
      navigation_t m{};
      m.decode(message.bytes.data(), 0, size);
      check(m.valid, all_finite({m.lat, m.lon, m.h, m.v_N[0], m.heading, m.wind_N[0],
                                 m.sigma_position[0], m.sigma_attitude[2], m.gps_error[0]}));
    }
  }
  void check(bool claimed_valid, bool finite) {
    valid += claimed_valid;
    wrong += claimed_valid && !finite;
  }
  int valid = 0;
  int wrong = 0;
};

class Saboteur {
 public:
  explicit Saboteur(int seed) : random_(static_cast<unsigned>(seed)) {}

  /// How often to send `message`, after it was tampered with.
  int tamper(Sent& message) {
    std::vector<std::uint8_t>& bytes = message.bytes;
    const std::size_t value = 8 * (1 + below((bytes.size() - 8) / 8));  // a field, time included
    switch (below(40)) {
      case 0:  // one bit, anywhere behind the fingerprint
        bytes[8 + below(bytes.size() - 8)] ^= static_cast<std::uint8_t>(1u << below(8));
        return 1;
      case 1:  // one bit of the time
        bytes[8 + below(8)] ^= static_cast<std::uint8_t>(1u << below(8));
        return 1;
      case 2:
        for (int i = 0; i < 8; ++i) bytes[value + static_cast<std::size_t>(i)] = byte();
        return 1;
      case 3:
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(value), 8, std::uint8_t{0});
        return 1;
      case 4:
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(value), 8, std::uint8_t{0xFF});
        return 1;
      case 5:
        return 2;
      case 6:
        return 0;
      case 7:
        message.channel = static_cast<samples::Channel>(below(samples::kChannels));
        return 1;
      default:
        return 1;
    }
  }

 private:
  std::size_t below(std::size_t limit) { return random_() % limit; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_()); }
  std::mt19937_64 random_;
};

TEST(HostileInput, NeverMakesAnOutputThatIsClaimedValidAndIsNotANumber) {
  constexpr int kFlights = 20;
  const std::vector<Sent> flight = level_flight(30);
  int valid = 0;
  for (int seed = 0; seed < kFlights; ++seed) {
    Judge judge;
    Session session(navigator::Config{}, judge);
    Saboteur saboteur(seed);
    for (Sent message : flight) {
      for (int times = saboteur.tamper(message); times > 0; --times) {
        session.receive(message.channel, message.bytes.data(), message.bytes.size());
      }
    }
    EXPECT_EQ(judge.wrong, 0) << "seed " << seed;
    EXPECT_GT(judge.valid, 0) << "seed " << seed;
    valid += judge.valid;
  }
  // All in all it goes on working: each flight could give 1800 attitudes and as many positions.
  EXPECT_GT(valid, kFlights * 1800);
}

}  // namespace
}  // namespace lodestar::app
