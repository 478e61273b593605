// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "lodestar/sahrs/smdu_calibration.h"

namespace lodestar::sahrs::smdu {

/// How a calibration came about.
enum class Source : std::uint8_t { kFlight = 0, kGroundSwing = 1 };
inline constexpr const char* kSourceNames[] = {"flight", "ground swing"};

/// A calibration as it is stored.
struct Record {
  std::string airframe;      // id of the aircraft whose detector it is, at most kLongestAirframe
  std::int64_t time_us = 0;  // flight time of the last sample that went in
  double epoch_year = 0.0;   // date of that flight, decimal year
  Source source = Source::kFlight;
  Calibration calibration;
};
inline constexpr std::size_t kLongestAirframe = 31;

/// Why bytes are no calibration for this aircraft, in the order in which it is asked.
enum class Refusal : std::uint8_t {
  kForeign,      // something else, or torn within its first eight bytes
  kOldVersion,   // written by an older build
  kNewVersion,   // written by a newer one
  kSize,         // torn, or with something behind it
  kChecksum,     // a bit is not what it was
  kAirframe,     // of another aircraft
  kImplausible,  // numbers that no calibration has
};
inline constexpr const char* kRefusalNames[] = {"not a calibration file",
                                                "written in an older format",
                                                "written in a newer format",
                                                "torn: its size is wrong",
                                                "damaged: its checksum is wrong",
                                                "of another airframe",
                                                "its numbers cannot be a calibration's"};

inline const char* name(Refusal refusal) {
  return kRefusalNames[static_cast<std::size_t>(refusal)];
}

inline constexpr std::string_view kRecordMagic = "LODESMDU";
inline constexpr std::uint32_t kRecordVersion = 1;

/// The bytes of a record, little-endian:
///     magic (8), version (4), source (4), airframe (32, filled up with zeros), time_us (8),
///     epoch_year (8), x (12 x 8), the lower triangle of P row by row (78 x 8), CRC-32 of all that
///     is before it (4).
inline constexpr std::size_t kRecordSize = 8 + 4 + 4 + 32 + 8 + 8 + 12 * 8 + 78 * 8 + 4;
std::string encode(const Record& record);

/// The record in `bytes`, which may be anything, for the aircraft `airframe`.
std::variant<Record, Refusal> decode(std::string_view bytes, std::string_view airframe);

}  // namespace lodestar::sahrs::smdu
