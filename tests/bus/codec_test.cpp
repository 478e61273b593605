// SPDX-License-Identifier: Apache-2.0
#include "lodestar/bus/codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <lodestar/attitude_t.hpp>
#include <lodestar/health_t.hpp>
#include <lodestar/ins_monitor_t.hpp>
#include <lodestar/navigation_t.hpp>
#include <lodestar/smdu_calibration_t.hpp>
#include <optional>
#include <string>

#include "lodestar/bus/channels.h"
#include "lodestar/samples/validity.h"
#include "wire_samples.h"

namespace lodestar::bus {
namespace {

using samples::Channel;
using samples::Reason;

template <class Sample, class Wire>
Sample decoded(Channel channel, const Wire& wire) {
  const Bytes bytes = bytes_of(wire);
  return std::get<Sample>(decode(channel, bytes.data(), bytes.size()));
}

std::optional<Reason> refusal_of(Channel channel, const Bytes& bytes) {
  const Decoded result = decode(channel, bytes.data(), bytes.size());
  if (const Reason* reason = std::get_if<Reason>(&result)) return *reason;
  return std::nullopt;
}

TEST(Codec, CarriesEveryFieldOfBodyRates) {
  const auto s = decoded<samples::BodyRates>(Channel::kBodyRates, wire_body_rates());
  EXPECT_EQ(s.time_us, 1'000'000);
  EXPECT_EQ(s.omega_B, Eigen::Vector3d(0.01, -0.02, 0.03));
  EXPECT_TRUE(s.valid);
}

TEST(Codec, CarriesEveryFieldOfLoadFactor) {
  const auto s = decoded<samples::LoadFactor>(Channel::kLoadFactor, wire_load_factor());
  EXPECT_EQ(s.time_us, 1'000'001);
  EXPECT_EQ(s.n_B, Eigen::Vector3d(0.01, 0.02, 1.03));
  EXPECT_TRUE(s.valid);
}

TEST(Codec, CarriesEveryFieldOfMagneticField) {
  const auto s = decoded<samples::MagneticField>(Channel::kMagneticField, wire_magnetic_field());
  EXPECT_EQ(s.time_us, 1'000'002);
  EXPECT_EQ(s.b_B, Eigen::Vector3d(15000.0, 1200.0, 48000.0));
  EXPECT_TRUE(s.valid);
}

TEST(Codec, CarriesEveryFieldOfAirData) {
  const auto s = decoded<samples::AirData>(Channel::kAirData, wire_air_data());
  EXPECT_EQ(s.time_us, 1'000'003);
  EXPECT_EQ(s.true_airspeed, 220.0);
  EXPECT_EQ(s.alpha, 0.05);
  EXPECT_EQ(s.beta, -0.01);
  EXPECT_EQ(s.baro_altitude, 6000.0);
  EXPECT_EQ(s.static_temperature, 249.0);
  EXPECT_TRUE(s.valid);
}

TEST(Codec, CarriesEveryFieldOfSpecificForce) {
  const auto s = decoded<samples::SpecificForce>(Channel::kSpecificForce, wire_specific_force());
  EXPECT_EQ(s.time_us, 1'000'004);
  EXPECT_EQ(s.f_B, Eigen::Vector3d(0.1, -0.2, -9.8));
  EXPECT_EQ(s.temperature, 300.0);
  EXPECT_TRUE(s.valid);
}

TEST(Codec, CarriesEveryFieldOfAGpsFix) {
  const auto s = decoded<samples::GpsFix>(Channel::kGps, wire_gps());
  EXPECT_EQ(s.time_us, 1'000'005);
  EXPECT_EQ(s.lat, 1.0);
  EXPECT_EQ(s.lon, 0.28);
  EXPECT_EQ(s.h, 6000.0);
  EXPECT_EQ(s.v_N, Eigen::Vector3d(200.0, 10.0, -1.0));
  EXPECT_TRUE(s.has_velocity);
  EXPECT_EQ(s.sigma_horizontal, 5.0);
  EXPECT_EQ(s.sigma_vertical, 9.0);
  EXPECT_EQ(s.sigma_velocity, 0.2);
  EXPECT_EQ(s.fix_type, 3);
  EXPECT_EQ(s.satellites, 9);
  EXPECT_EQ(s.hdop, 0.9);
}

TEST(Codec, CarriesEveryFieldOfGpsObservables) {
  const auto wire = wire_gps_observables();
  const auto s = decoded<samples::GpsObservables>(Channel::kGpsObservables, wire);
  EXPECT_EQ(s.time_us, 1'000'009);
  EXPECT_EQ(s.kind, 1);
  EXPECT_EQ(s.count, 2);
  for (int i = 0; i < samples::GpsObservables::kMaximum; ++i) {
    EXPECT_EQ(s.prn[i], wire.prn[i]);
    EXPECT_EQ(s.pseudorange[i], wire.pseudorange[i]);
    EXPECT_EQ(s.carrier_phase[i], wire.carrier_phase[i]);
    EXPECT_EQ(s.sigma[i], wire.sigma[i]);
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(s.sv_p_E[i][axis], wire.sv_p_E[i][axis]);
  }
}

TEST(Codec, CarriesEveryFieldOfAnInsSolution) {
  const auto s = decoded<samples::InsSolution>(Channel::kIns, wire_ins());
  EXPECT_EQ(s.time_us, 1'000'006);
  EXPECT_EQ(s.roll, 0.1);
  EXPECT_EQ(s.pitch, 0.05);
  EXPECT_EQ(s.heading, 1.5);
  EXPECT_EQ(s.lat, 1.0);
  EXPECT_EQ(s.lon, 0.28);
  EXPECT_EQ(s.h, 6000.0);
  EXPECT_EQ(s.v_N, Eigen::Vector3d(200.0, 10.0, -1.0));
  EXPECT_TRUE(s.valid);
}

TEST(Codec, CarriesEveryFieldOfASarMeasurement) {
  const auto s = decoded<samples::SarMeasurement>(Channel::kSar, wire_sar());
  EXPECT_EQ(s.time_us, 1'000'007);
  EXPECT_EQ(s.target_id, 42);
  EXPECT_EQ(s.range, 30e3);
  EXPECT_EQ(s.range_rate, -150.0);
  EXPECT_EQ(s.nominal_target_p_E, Eigen::Vector3d(3.2e6, 0.9e6, 5.4e6));
}

TEST(Codec, CarriesEveryFieldOfRadarAltitude) {
  const auto s = decoded<samples::RadarAltitude>(Channel::kRadarAltitude, wire_radar_altitude());
  EXPECT_EQ(s.time_us, 1'000'008);
  EXPECT_EQ(s.height, 431.5);
  EXPECT_TRUE(s.valid);
}

class CodecOfEachChannel : public testing::TestWithParam<Channel> {};

TEST_P(CodecOfEachChannel, TakesOnlyTheExactSize) {
  const Bytes whole = wire_message(GetParam());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(refusal_of(GetParam(), cut), Reason::kSize) << size;
  }
  for (const std::size_t more : {1u, 8u, 60000u}) {
    Bytes longer = whole;
    longer.resize(whole.size() + more, 0xA5);
    EXPECT_EQ(refusal_of(GetParam(), longer), Reason::kSize) << more;
  }
}

TEST_P(CodecOfEachChannel, RefusesAnyOtherFingerprint) {
  for (int bit = 0; bit < 64; ++bit) {
    Bytes bytes = wire_message(GetParam());
    bytes[static_cast<std::size_t>(bit / 8)] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    EXPECT_EQ(refusal_of(GetParam(), bytes), Reason::kFingerprint) << bit;
  }
}

TEST_P(CodecOfEachChannel, RefusesTheMessagesOfOtherChannels) {
  for (const Channel other : all_channels()) {
    if (other == GetParam()) continue;
    const auto refusal = refusal_of(GetParam(), wire_message(other));
    EXPECT_TRUE(refusal == Reason::kSize || refusal == Reason::kFingerprint) << name(other);
  }
}

TEST_P(CodecOfEachChannel, NamesTheChannelBothWays) {
  EXPECT_EQ(input_channel(name(GetParam())), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Inputs, CodecOfEachChannel, testing::ValuesIn(all_channels()),
                         [](const auto& info) {
                           return std::to_string(static_cast<int>(info.param));
                         });

TEST(Codec, TakesOnlyZeroAndOneForABoolean) {
  for (int byte = -128; byte < 128; ++byte) {
    body_rates_t rates = wire_body_rates();
    gps_fix_t fix = wire_gps();
    rates.valid = fix.has_velocity = static_cast<std::int8_t>(byte);
    if (byte == 0 || byte == 1) {
      EXPECT_EQ(decoded<samples::BodyRates>(Channel::kBodyRates, rates).valid, byte == 1);
      EXPECT_EQ(decoded<samples::GpsFix>(Channel::kGps, fix).has_velocity, byte == 1);
    } else {
      EXPECT_EQ(refusal_of(Channel::kBodyRates, bytes_of(rates)), Reason::kDecode) << byte;
      EXPECT_EQ(refusal_of(Channel::kGps, bytes_of(fix)), Reason::kDecode) << byte;
    }
  }
}

TEST(Codec, RefusesTimesThatArithmeticCannotHold) {
  constexpr std::int64_t kLimit = std::int64_t{1} << 61;
  body_rates_t rates = wire_body_rates();
  for (const std::int64_t good : {-kLimit, std::int64_t{-1}, std::int64_t{0}, kLimit}) {
    rates.time_us = good;
    EXPECT_EQ(decoded<samples::BodyRates>(Channel::kBodyRates, rates).time_us, good);
  }
  for (const std::int64_t bad : {-kLimit - 1, kLimit + 1, std::numeric_limits<std::int64_t>::min(),
                                 std::numeric_limits<std::int64_t>::max()}) {
    rates.time_us = bad;
    EXPECT_EQ(refusal_of(Channel::kBodyRates, bytes_of(rates)), Reason::kOutOfRange) << bad;
  }
}

TEST(Codec, LeavesMeasuredValuesToTheValidityChecks) {
  body_rates_t rates = wire_body_rates();
  rates.omega_B[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(samples::refusal(decoded<samples::BodyRates>(Channel::kBodyRates, rates)),
            Reason::kNotFinite);
  rates.omega_B[1] = 1e9;
  EXPECT_EQ(samples::refusal(decoded<samples::BodyRates>(Channel::kBodyRates, rates)),
            Reason::kOutOfRange);
  gps_observables_t observables = wire_gps_observables();
  observables.count = 17;
  EXPECT_EQ(
      samples::refusal(decoded<samples::GpsObservables>(Channel::kGpsObservables, observables)),
      Reason::kOutOfRange);
}

TEST(Channels, KnowsNoChannelButTheInputs) {
  for (const char* other : {"TRUTH", "SAHRS", "NAV", "HEALTH", "INS.MONITOR", "", "EFCSxRATES",
                            "SMDU\n", "SMDU.CALIBRATION", "efcs.rates", ".*"}) {
    EXPECT_FALSE(input_channel(other)) << other;
  }
}

/// What another program reads from the bytes of an output.
template <class Wire>
Wire read_back(const Message& message) {
  Wire wire{};
  const int size = static_cast<int>(message.size);
  EXPECT_EQ(wire.decode(message.bytes.data(), 0, size), size);
  EXPECT_EQ(wire.getEncodedSize(), size);
  return wire;
}

TEST(Codec, PublishesEveryFieldOfAnAttitude) {
  samples::Attitude s;
  s.time_us = 77;
  s.q_NB = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  s.roll = 0.1;
  s.pitch = 0.2;
  s.heading = 0.3;
  s.P_B.diagonal() = Eigen::Vector3d(4.0, 9.0, 16.0);
  s.gyro_bias_B = Eigen::Vector3d(1.0, 2.0, 3.0);
  s.field_bias_B = Eigen::Vector3d(4.0, 5.0, 6.0);
  s.used = 5;
  s.rejected = -2;
  s.reset_count = 7;
  s.reset_delta_B = Eigen::Vector3d(7.0, 8.0, 9.0);
  s.mode = samples::AttitudeMode::kCoasting;
  s.valid = true;
  Message message;
  encode(s, message);
  const auto m = read_back<attitude_t>(message);
  EXPECT_EQ(m.time_us, 77);
  const double q[4] = {0.5, -0.5, 0.5, -0.5};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(m.q_NB[i], q[i]);
  EXPECT_EQ(m.roll, 0.1);
  EXPECT_EQ(m.pitch, 0.2);
  EXPECT_EQ(m.heading, 0.3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(m.sigma_B[i], 2.0 + i);
    EXPECT_EQ(m.gyro_bias_B[i], 1.0 + i);
    EXPECT_EQ(m.field_bias_B[i], 4.0 + i);
    EXPECT_EQ(m.reset_delta_B[i], 7.0 + i);
  }
  EXPECT_EQ(m.used, 5);
  EXPECT_EQ(m.rejected, -2);
  EXPECT_EQ(m.reset_count, 7);
  EXPECT_EQ(m.mode, 3);
  EXPECT_EQ(m.valid, 1);
}

TEST(Codec, PublishesEveryFieldOfANavigationSolution) {
  samples::Navigation s;
  s.time_us = 78;
  s.lat = 1.0;
  s.lon = 0.25;
  s.h = 5000.0;
  s.v_N = Eigen::Vector3d(1.0, 2.0, 3.0);
  s.roll = 0.1;
  s.pitch = 0.2;
  s.heading = 0.3;
  s.wind_N = Eigen::Vector3d(4.0, 5.0, 6.0);
  s.sigma_position = Eigen::Vector3d(7.0, 8.0, 9.0);
  s.sigma_velocity = Eigen::Vector3d(10.0, 11.0, 12.0);
  s.sigma_attitude = Eigen::Vector3d(13.0, 14.0, 15.0);
  s.sigma_wind = Eigen::Vector2d(16.0, 17.0);
  s.gps_error = Eigen::Vector2d(18.0, 19.0);
  s.gps_age = 0.5;
  s.horizontal_protection_level = 30.0;
  s.reset_count = 2;
  s.reset_delta = Eigen::Vector2d(20.0, 21.0);
  s.mode = samples::FusionMode::kDeadReckoning;
  s.valid = true;
  Message message;
  encode(s, message);
  const auto m = read_back<navigation_t>(message);
  EXPECT_EQ(m.time_us, 78);
  EXPECT_EQ(m.lat, 1.0);
  EXPECT_EQ(m.lon, 0.25);
  EXPECT_EQ(m.h, 5000.0);
  EXPECT_EQ(m.roll, 0.1);
  EXPECT_EQ(m.pitch, 0.2);
  EXPECT_EQ(m.heading, 0.3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(m.v_N[i], 1.0 + i);
    EXPECT_EQ(m.wind_N[i], 4.0 + i);
    EXPECT_EQ(m.sigma_position[i], 7.0 + i);
    EXPECT_EQ(m.sigma_velocity[i], 10.0 + i);
    EXPECT_EQ(m.sigma_attitude[i], 13.0 + i);
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(m.sigma_wind[i], 16.0 + i);
    EXPECT_EQ(m.gps_error[i], 18.0 + i);
    EXPECT_EQ(m.reset_delta[i], 20.0 + i);
  }
  EXPECT_EQ(m.gps_age, 0.5);
  EXPECT_EQ(m.horizontal_protection_level, 30.0);
  EXPECT_EQ(m.reset_count, 2);
  EXPECT_EQ(m.mode, 2);
  EXPECT_EQ(m.valid, 1);
}

TEST(Codec, PublishesEveryFieldOfTheInsMonitor) {
  samples::InsMonitor s;
  s.time_us = 80;
  s.difference = Eigen::Vector3d(1.0, 2.0, 3.0);
  s.threshold = Eigen::Vector3d(4.0, 5.0, 6.0);
  s.time_over = Eigen::Vector3d(7.0, 8.0, 9.0);
  s.state = samples::InsState::kMiscompare;
  Message message;
  encode(s, message);
  const auto m = read_back<ins_monitor_t>(message);
  EXPECT_EQ(m.time_us, 80);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(m.difference[i], 1.0 + i);
    EXPECT_EQ(m.threshold[i], 4.0 + i);
    EXPECT_EQ(m.time_over[i], 7.0 + i);
  }
  EXPECT_EQ(m.state, 3);
}

TEST(Codec, PublishesEveryFieldOfHealth) {
  samples::Health s;
  s.time_us = 79;
  for (int i = 0; i < samples::kChannels; ++i) {
    auto& counters = of(s.counters, static_cast<Channel>(i));
    counters.received = 1000 + i;
    counters.used = 500 + i;
    for (std::size_t r = 0; r < samples::kReasons; ++r) {
      counters.rejected[r] = 100 * i + static_cast<int>(r);
    }
    s.sensor_state[static_cast<std::size_t>(i)] = static_cast<samples::SensorState>(i % 4);
  }
  s.cycle.mean = 1e-6;
  s.cycle.p99 = 2e-6;
  s.cycle.max = 3e-6;
  for (std::size_t i = 0; i < 16; ++i) s.cycle.histogram[i] = static_cast<int>(i) + 50;
  s.sahrs_form = samples::SahrsForm::kPaper;
  s.sahrs_mode = samples::AttitudeMode::kRunning;
  s.fusion_mode = samples::FusionMode::kAiding;
  s.ahrs_mode = samples::AttitudeMode::kAligning;
  for (std::size_t i = 0; i < 10; ++i) s.assumption_rejects[i] = static_cast<int>(i) + 1;
  for (std::size_t i = 0; i < 10; ++i) {
    s.innovation[i] = 0.5 + static_cast<double>(i);
    s.innovation_sigma[i] = 1.5 + static_cast<double>(i);
  }
  s.calibration_id = 0xFFFFFFFF;
  s.config_hash = 0x12345678;
  s.log_dropped = 3;
  s.warning = samples::kWarningRealtime;
  s.build_version = {'0', '.', '1'};
  Message message;
  encode(s, message);
  const auto m = read_back<health_t>(message);
  EXPECT_EQ(m.time_us, 79);
  for (int i = 0; i < samples::kChannels; ++i) {
    EXPECT_EQ(m.received[i], 1000 + i);
    EXPECT_EQ(m.used[i], 500 + i);
    for (int r = 0; r < samples::kReasons; ++r) EXPECT_EQ(m.rejected[i][r], 100 * i + r);
    EXPECT_EQ(m.sensor_state[i], i % 4);
  }
  EXPECT_EQ(m.cycle_mean, 1e-6);
  EXPECT_EQ(m.cycle_p99, 2e-6);
  EXPECT_EQ(m.cycle_max, 3e-6);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(m.cycle_histogram[i], 50 + i);
  EXPECT_EQ(m.sahrs_form, 1);
  EXPECT_EQ(m.sahrs_mode, 2);
  EXPECT_EQ(m.fusion_mode, 1);
  EXPECT_EQ(m.ahrs_mode, 1);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(m.assumption_rejects[i], i + 1);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(m.innovation[i], 0.5 + i);
    EXPECT_EQ(m.innovation_sigma[i], 1.5 + i);
  }
  EXPECT_EQ(m.calibration_id, 0xFFFFFFFF);
  EXPECT_EQ(m.config_hash, 0x12345678);
  EXPECT_EQ(m.log_dropped, 3);
  EXPECT_EQ(m.warning, 2);
  EXPECT_STREQ(reinterpret_cast<const char*>(m.build_version), "0.1");
}

TEST(Codec, WritesEveryFieldOfACalibration) {
  samples::SmduCalibration s;
  s.time_us = 80;
  for (int i = 0; i < 12; ++i) {
    s.x(i) = 100.0 + i;
    s.sigma(i) = 200.0 + i;
  }
  s.state = samples::CalibrationState::kRefused;
  Message message;
  encode(s, message);
  const auto m = read_back<smdu_calibration_t>(message);
  EXPECT_EQ(m.time_us, 80);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(m.x[i], 100.0 + i);
    EXPECT_EQ(m.sigma[i], 200.0 + i);
  }
  EXPECT_EQ(m.state, 3);
}

}  // namespace
}  // namespace lodestar::bus
